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

        protected override bool IsInForce => GraphicsSettings.currentRenderPipeline is UniversalRenderPipelineAsset;

        public override string Name => "Universal";

        public override string Way => "by the Lumivox feature of the camera's renderer, or by themselves where it has none";

        public override Material Shining(Color color)
        {
            var material = MaterialOf("Universal Render Pipeline/Unlit");
            material.SetColor("_BaseColor", color);
            return material;
        }
    }
}
