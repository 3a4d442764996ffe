// What a camera of the self-check saw, and how far it is from what it should have seen.
using System;
using System.IO;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.SelfChecks
{
    /// <remarks>
    /// Pictures are compared in squares of pixels, in the colours of the screen from 0 to 1. What may differ: the noise of 32
    /// samples, for pixels take other random numbers where an engine's rows run the other way, and squares even that out; the
    /// edges of meshes, which pipelines smooth or do not; rounding to eight bits. What must not: where anything is, which of
    /// two hides the other, colours, brightness. Noise comes to 0.002 and, in a square, 0.03; a tenth more light, or a shift by
    /// three pixels, to more than is allowed.
    /// </remarks>
    internal sealed class CheckPicture
    {
        /// <summary>Pixels along the side of a square.</summary>
        const int Square = 8;

        /// <summary>Differences that are no fault: of all squares on average, and of any one.</summary>
        public const float LargestMean = 0.008f, LargestOfSquare = 0.07f;

        /// <summary>How much the picture of differences is brightened.</summary>
        const int Gain = 8;

        readonly int width, height;
        /// The lowest row first.
        readonly Color32[] pixels;

        CheckPicture(int width, int height, Color32[] pixels) => (this.width, this.height, this.pixels) = (width, height, pixels);

        /// <summary>What was drawn into a texture in linear light.</summary>
        public static CheckPicture Of(RenderTexture drawn)
        {
            var copy = new Texture2D(drawn.width, drawn.height, TextureFormat.RGBAHalf, false, true);
            var active = RenderTexture.active;
            try
            {
                RenderTexture.active = drawn;
                copy.ReadPixels(new Rect(0, 0, drawn.width, drawn.height), 0, 0);
                return new CheckPicture(drawn.width, drawn.height, Array.ConvertAll(copy.GetPixels(), OfScreen));
            }
            finally
            {
                RenderTexture.active = active;
                Object.DestroyImmediate(copy);
            }
        }

        /// <summary>The colours of a texture as they are.</summary>
        public static CheckPicture Of(Texture2D texture) => new CheckPicture(texture.width, texture.height, texture.GetPixels32());

        static Color32 OfScreen(Color linear)
        {
            // What is brighter than white is white.
            var color = new Color(Mathf.Clamp01(linear.r), Mathf.Clamp01(linear.g), Mathf.Clamp01(linear.b)).gamma;
            return new Color(color.r, color.g, color.b, 1f);
        }

        /// <summary>Where the expected pictures lie; null: in the package.</summary>
        internal static string ExpectedFolder;

        /// <summary>What a scene looks like.</summary>
        /// <exception cref="LumivoxException">The package does not have that picture, or it is not where it should be.</exception>
        public static CheckPicture Expected(string scene)
        {
            var folder = ExpectedFolder;
#if UNITY_EDITOR
            if (folder == null)
            {
                var package = UnityEditor.PackageManager.PackageInfo.FindForAssembly(typeof(CheckPicture).Assembly);
                // In Assets it lies wherever somebody has put it.
                if (package == null) throw new LumivoxException("the expected pictures are found only where Lumivox is a package of the project, not a folder in Assets");
                folder = Path.Combine(package.resolvedPath, "SelfCheck", "Expected~");
            }
#endif
            return Load(Path.Combine(folder, scene + ".png"));
        }

        /// <exception cref="LumivoxException">There is none, or it is no picture.</exception>
        public static CheckPicture Load(string file)
        {
            if (!File.Exists(file)) throw new LumivoxException($"{file} is missing from the package. Install it anew");
            var texture = new Texture2D(2, 2, TextureFormat.RGBA32, false, true);
            try
            {
                if (!texture.LoadImage(File.ReadAllBytes(file))) throw new LumivoxException($"{file} is no picture. Install the package anew");
                return Of(texture);
            }
            finally
            {
                Object.DestroyImmediate(texture);
            }
        }

        /// <summary>For the editor's windows; whose who asks.</summary>
        public Texture2D ToTexture() => ToTexture(false);

        /// <summary>Also with colours that stay as they are.</summary>
        internal Texture2D ToTexture(bool isLinear)
        {
            var texture = new Texture2D(width, height, TextureFormat.RGBA32, false, isLinear) { hideFlags = HideFlags.HideAndDontSave, filterMode = FilterMode.Point };
            texture.SetPixels32(pixels);
            texture.Apply();
            return texture;
        }

        public void Save(string file)
        {
            // Its colours are the file's, whatever they mean.
            var texture = ToTexture(true);
            try
            {
                File.WriteAllBytes(file, texture.EncodeToPNG());
            }
            finally
            {
                Object.DestroyImmediate(texture);
            }
        }

        /// <summary>The mean difference of all squares, and that of the square that differs most.</summary>
        public (float mean, float most) DifferenceFrom(CheckPicture expected)
        {
            if (expected.width != width || expected.height != height) throw new LumivoxException($"a picture of {expected.width} x {expected.height} pixels was expected, not of {width} x {height}");
            float sum = 0f, most = 0f;
            var count = 0;
            for (var y = 0; y < height; y += Square)
                for (var x = 0; x < width; x += Square)
                {
                    var difference = (Mean(x, y) - expected.Mean(x, y));
                    var size = (Mathf.Abs(difference.x) + Mathf.Abs(difference.y) + Mathf.Abs(difference.z)) / 3f;
                    sum += size;
                    most = Mathf.Max(most, size);
                    count++;
                }
            return (sum / count, most);
        }

        /// <summary>Where it differs, and how: grey where it does not.</summary>
        public CheckPicture Difference(CheckPicture expected)
        {
            var result = new Color32[pixels.Length];
            byte Shown(byte seen, byte wanted) => (byte)Mathf.Clamp(128 + (seen - wanted) * Gain, 0, 255);
            for (var i = 0; i < result.Length; i++)
            {
                Color32 seen = pixels[i], wanted = expected.pixels[i];
                result[i] = new Color32(Shown(seen.r, wanted.r), Shown(seen.g, wanted.g), Shown(seen.b, wanted.b), 255);
            }
            return new CheckPicture(width, height, result);
        }

        Vector3 Mean(int left, int bottom)
        {
            var sum = Vector3.zero;
            int right = Math.Min(left + Square, width), top = Math.Min(bottom + Square, height);
            for (var y = bottom; y < top; y++)
                for (var x = left; x < right; x++)
                {
                    var pixel = pixels[y * width + x];
                    sum += new Vector3(pixel.r, pixel.g, pixel.b);
                }
            return sum / (255f * (right - left) * (top - bottom));
        }
    }
}
