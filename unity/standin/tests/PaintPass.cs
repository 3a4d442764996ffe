// A pass that draws after a volume, in pipelines without a render graph.
#if !UNITY_6000_3_OR_NEWER
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.Universal;

namespace Lumivox.Tests
{
    /// As URP's own transparents without a render graph: into what is bound, which should be the camera's.
    sealed class PaintPass : ScriptableRenderPass
    {
        readonly Color color;

        public PaintPass(Color color)
        {
            this.color = color;
            renderPassEvent = RenderPassEvent.AfterRenderingTransparents;
        }

#if UNITY_6000_0_OR_NEWER
        public override void RecordRenderGraph(UnityEngine.Rendering.RenderGraphModule.RenderGraph renderGraph, ContextContainer frameData) { }
#endif
#pragma warning disable 618, 672
        public override void Execute(ScriptableRenderContext context, ref RenderingData renderingData)
        {
            var cmd = CommandBufferPool.Get("Paint");
            cmd.ClearRenderTarget(false, true, color);
            context.ExecuteCommandBuffer(cmd);
            CommandBufferPool.Release(cmd);
        }
#pragma warning restore 618, 672
    }
}
#endif
