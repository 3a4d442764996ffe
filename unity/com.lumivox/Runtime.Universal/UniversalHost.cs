using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.Universal;

namespace Lumivox.Universal
{
    /// <summary>URP, for those that check how volumes are drawn in it.</summary>
    internal sealed class UniversalHost : PipelineHost
    {
#if UNITY_EDITOR
        [UnityEditor.InitializeOnLoadMethod]
#endif
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.BeforeSceneLoad)]
        static void Hook() => Add(new UniversalHost());

        static UniversalRenderPipelineAsset Asset => GraphicsSettings.currentRenderPipeline as UniversalRenderPipelineAsset;

        protected override bool IsInForce => Asset != null;

        public override string Name => "Universal";

        public override string Way => "by the Lumivox feature of the camera's renderer, or by themselves where it has none";

        /// <inheritdoc/>
        /// <remarks>The asset's Render Scale and what other features add are out of force meanwhile.</remarks>
        public override void Draw(Camera camera)
        {
            var asset = Asset;
            var scale = asset.renderScale;
            var others = new List<ScriptableRendererFeature>();
            try
            {
                // Assigning it has the asset check it, also where it is the same.
                if (scale != 1f) asset.renderScale = 1f;
                foreach (var feature in Resources.FindObjectsOfTypeAll<ScriptableRendererFeature>())
                {
                    if (!feature.isActive || feature is LumivoxFeature) continue;
                    feature.SetActive(false);
                    others.Add(feature);
                }
                camera.Render();
            }
            finally
            {
                foreach (var feature in others) feature.SetActive(true);
                if (scale != 1f) asset.renderScale = scale;
            }
        }

        public override Material Shining(Color color)
        {
            var material = MaterialOf("Universal Render Pipeline/Unlit");
            material.SetColor("_BaseColor", color);
            return material;
        }
    }
}
