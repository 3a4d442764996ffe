using UnityEngine;
using UnityEngine.Rendering.Universal;

namespace Lumivox.Universal
{
    /// <summary>
    /// Draws volumes in the Universal Render Pipeline, at a place of your choice. It need not be added to a renderer:
    /// where no renderer has it, volumes are drawn before transparent things by themselves.
    /// </summary>
    [DisallowMultipleRendererFeature("Lumivox")]
    public sealed class LumivoxFeature : ScriptableRendererFeature
    {
        [SerializeField, Tooltip("When volumes are drawn. Transparent things that are drawn later meet their depth.")]
        RenderPassEvent m_RenderPassEvent = RenderPassEvent.BeforeRenderingTransparents;

        LumivoxPass pass;

        /// <summary>When volumes are drawn.</summary>
        public RenderPassEvent renderPassEvent
        {
            get => m_RenderPassEvent;
            set => m_RenderPassEvent = value;
        }

        /// <inheritdoc/>
        public override void Create() => pass = new LumivoxPass(false);

        /// <inheritdoc/>
        public override void AddRenderPasses(ScriptableRenderer renderer, ref RenderingData renderingData)
        {
            var camera = renderingData.cameraData.camera;
            if (!LumivoxRuntime.Draws(camera)) return;
            pass.renderPassEvent = m_RenderPassEvent;
            renderer.EnqueuePass(pass);
            LumivoxInjector.Yield();
        }
    }
}
