using System;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>A transfer function at a glance: its colours from the lowest to the highest point, under its opacity.</summary>
    public sealed class PresetSwatch : VisualElement
    {
        const int Columns = 64;
        /// Colours that are hardly seen in the volume are seen here.
        const float Faintest = 0.3f;

        Color[] samples = Array.Empty<Color>();

        public PresetSwatch()
        {
            name = "swatch";
            pickingMode = PickingMode.Ignore;
            generateVisualContent += Draw;
        }

        /// <summary>Shows a function as it is now; null shows nothing.</summary>
        public void Show(LumivoxTransferFunction function)
        {
            samples = function != null ? Sample(function, Columns) : Array.Empty<Color>();
            MarkDirtyRepaint();
        }

        /// <summary>Shows the function of a preset, for a scan where it needs one.</summary>
        public void Show(string preset, LumivoxVolumeAsset volume)
        {
            var made = LumivoxTransferFunction.Preset(preset, volume);
            Show(made);
            Destroy(made);
        }

        /// <summary>Colours with the opacity as alpha, from the lowest to the highest point.</summary>
        internal static Color[] Sample(LumivoxTransferFunction function, int count)
        {
            var model = new TransferFunctionModel { State = function.GetState() };
            var colors = new Color[count];
            if (model.IsEmpty) return colors;
            var (low, high) = model.ShownRange;
            var lights = new Vector4[count];
            function.Sample((float)low, (float)high, lights);
            for (var i = 0; i < count; i++) colors[i] = ((Color)lights[i]).gamma;
            return colors;
        }

        /// <summary>The same as a picture, for asset browsers.</summary>
        internal static Texture2D Picture(LumivoxTransferFunction function, int width, int height)
        {
            var columns = Sample(function, width);
            var pixels = new Color[width * height];
            for (var i = 0; i < pixels.Length; i++)
            {
                var color = columns[i % width];
                // The lowest row comes first.
                var isUnder = (i / width + 0.5f) / height < color.a;
                pixels[i] = new Color(color.r, color.g, color.b, isUnder ? 1f : Faintest);
            }
            var texture = new Texture2D(width, height, TextureFormat.RGBA32, false) { hideFlags = HideFlags.DontSave };
            texture.SetPixels(pixels);
            texture.Apply();
            return texture;
        }

        /// As the runtime does for itself, of which this assembly sees what is public.
        internal static void Destroy(UnityEngine.Object made)
        {
            if (made == null) return;
            if (Application.isPlaying) UnityEngine.Object.Destroy(made);
            else UnityEngine.Object.DestroyImmediate(made);
        }

        void Draw(MeshGenerationContext context)
        {
            var (width, height) = (contentRect.width, contentRect.height);
            if (samples.Length == 0 || width < 1 || height < 1) return;
            float X(int i) => width * i / (samples.Length - 1);
            ValueStrip.FillBand(context, samples.Length, i =>
            {
                var faint = new Color(samples[i].r, samples[i].g, samples[i].b, Faintest);
                return (new Vector2(X(i), height), new Vector2(X(i), 0), faint, faint);
            });
            ValueStrip.FillBand(context, samples.Length, i =>
            {
                var full = new Color(samples[i].r, samples[i].g, samples[i].b, 1f);
                return (new Vector2(X(i), height), new Vector2(X(i), height * (1 - samples[i].a)), full, full);
            });
        }
    }
}
