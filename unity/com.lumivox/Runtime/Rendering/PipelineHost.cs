// The pipeline that draws now, for those that check whether volumes are drawn in it and look as they should.
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    /// <summary>The Built-in pipeline; the others' are in their assemblies.</summary>
    internal class PipelineHost
    {
        static readonly List<PipelineHost> others = new List<PipelineHost>();
        static readonly PipelineHost builtIn = new PipelineHost();

        /// <summary>Another pipeline than the Built-in one.</summary>
        public static void Add(PipelineHost host)
        {
            foreach (var other in others)
                if (other.GetType() == host.GetType()) return;
            others.Add(host);
        }

        /// <summary>That which draws now; null where it is none of Lumivox'.</summary>
        public static PipelineHost Current
        {
            get
            {
                foreach (var other in others)
                    if (other.IsInForce) return other;
                return builtIn.IsInForce ? builtIn : null;
            }
        }

        protected virtual bool IsInForce => GraphicsSettings.currentRenderPipeline == null;

        /// <summary>What it is called, and how volumes come into its frames.</summary>
        public virtual string Name => "Built-in";

        public virtual string Way => "by command buffers of the cameras";

        /// <summary>What of its settings keeps volumes from being drawn, and how to change that; null: nothing.</summary>
        public virtual string Problem => null;

        /// <summary>The intensity of a sun that is as bright beside the studio as one of intensity 1 in the Built-in pipeline.</summary>
        public virtual float SunIntensity => 1f;

        /// <summary>Has a camera show linear light as it is: no exposure, fog, tone map.</summary>
        public virtual void ShowLightAsItIs(Camera camera)
        {
        }

        /// <summary>Draws a camera at once, without what the project's settings for all cameras make of a picture.</summary>
        public virtual void Draw(Camera camera) => camera.Render();

        /// <summary>A material that shines by itself in one colour, whatever lights it, and leaves its depth.</summary>
        public virtual Material Shining(Color color)
        {
            // Unlit shaders of this pipeline leave no depth.
            var material = MaterialOf("Standard");
            material.SetColor("_Color", Color.black);
            material.SetColor("_EmissionColor", color);
            foreach (var property in new[] { "_Glossiness", "_SpecularHighlights", "_GlossyReflections" }) material.SetFloat(property, 0f);
            foreach (var keyword in new[] { "_EMISSION", "_SPECULARHIGHLIGHTS_OFF", "_GLOSSYREFLECTIONS_OFF" }) material.EnableKeyword(keyword);
            return material;
        }

        /// <exception cref="LumivoxException">The project does not have it.</exception>
        protected static Material MaterialOf(string shader)
        {
            var found = Shader.Find(shader);
            if (found == null) throw new LumivoxException($"the shader '{shader}' is missing");
            return new Material(found) { hideFlags = HideFlags.HideAndDontSave };
        }
    }
}
