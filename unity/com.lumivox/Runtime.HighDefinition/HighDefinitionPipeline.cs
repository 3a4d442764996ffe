using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;

namespace Lumivox.HighDefinition
{
    /// <summary>HDRP, for those that check how volumes are drawn in it.</summary>
    internal sealed class HighDefinitionPipeline : PipelineHost
    {
        /// <summary>What changes light on its way from a scene to the screen, or adds any.</summary>
        static readonly FrameSettingsField[] changing = { FrameSettingsField.ExposureControl, FrameSettingsField.Postprocess, FrameSettingsField.AtmosphericScattering };

#if UNITY_EDITOR
        [UnityEditor.InitializeOnLoadMethod]
#endif
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.BeforeSceneLoad)]
        static void Hook() => Add(new HighDefinitionPipeline());

        static HDRenderPipelineAsset Asset => GraphicsSettings.currentRenderPipeline as HDRenderPipelineAsset;

        protected override bool IsInForce => Asset != null;

        public override string Name => "High Definition";

        public override string Way => "by a custom pass for all cameras";

        public override string Problem => Asset.currentPlatformRenderPipelineSettings.supportCustomPass ? null
            : "the pipeline's asset has Rendering > Custom Pass turned off, without which no volume is drawn. Turn it on";

        // Its suns have lux, of which surfaces reflect a pi-th, and the studio is as bright as physical skies.
        public override float SunIntensity => Mathf.PI * EnvironmentReader.Studio.strength;

        public override void ShowLightAsItIs(Camera camera)
        {
            if (!camera.TryGetComponent<HDAdditionalCameraData>(out var data)) data = camera.gameObject.AddComponent<HDAdditionalCameraData>();
            data.clearColorMode = HDAdditionalCameraData.ClearColorMode.Color;
            // HDRP takes it as linear light.
            data.backgroundColorHDR = camera.backgroundColor.linear;
            data.customRenderingSettings = true;
            foreach (var field in changing)
            {
                data.renderingPathCustomFrameSettingsOverrideMask.mask[(uint)field] = true;
                data.renderingPathCustomFrameSettings.SetEnabled(field, false);
            }
        }

        public override Material Shining(Color color)
        {
            var material = MaterialOf("HDRP/Unlit");
            material.SetColor("_UnlitColor", color);
            return material;
        }
    }
}
