// Six faces to a panorama.
using System;
using UnityEngine;

namespace Lumivox
{
    internal static class CubeMap
    {
        /// <summary>
        /// Linear RGB in rows from the zenith, whose middle column is +z and whose right half has +x, of the faces +x, -x,
        /// +y, -y, +z, -z with four numbers a texel. What is not finite or negative is dark.
        /// </summary>
        public static float[] Panorama(float[] faces, int side, int width, int height, float scale)
        {
            var rgb = new float[width * height * 3];
            for (var y = 0; y < height; y++)
            {
                var polar = Math.PI * (y + 0.5) / height;
                double up = Math.Cos(polar), across = Math.Sin(polar);
                for (var x = 0; x < width; x++)
                {
                    var azimuth = 2.0 * Math.PI * ((x + 0.5) / width - 0.5);
                    var direction = new Vector3((float)(across * Math.Sin(azimuth)), (float)up, (float)(across * Math.Cos(azimuth)));
                    Texel(faces, side, direction, out var red, out var green, out var blue);
                    var at = 3 * (y * width + x);
                    rgb[at] = Light(red * scale);
                    rgb[at + 1] = Light(green * scale);
                    rgb[at + 2] = Light(blue * scale);
                }
            }
            return rgb;
        }

        /// <summary>FNV-1a of numbers, to tell whether a picture is another.</summary>
        public static ulong Hash(float[] numbers)
        {
            var hash = 14695981039346656037ul;
            foreach (var number in numbers) hash = (hash ^ (uint)BitConverter.SingleToInt32Bits(number)) * 1099511628211ul;
            return hash;
        }

        static float Light(float value) => Numbers.IsFinite(value) && value > 0f ? Mathf.Min(value, 1e9f) : 0f;

        /// <summary>Which face a direction meets, and where: 0 to 1 to the right and down.</summary>
        internal static int Face(Vector3 d, out float u, out float v)
        {
            float x = Math.Abs(d.x), y = Math.Abs(d.y), z = Math.Abs(d.z);
            int face;
            float right, down, major;
            if (x >= y && x >= z)
            {
                (face, major) = (d.x > 0f ? 0 : 1, x);
                (right, down) = (d.x > 0f ? -d.z : d.z, -d.y);
            }
            else if (y >= z)
            {
                (face, major) = (d.y > 0f ? 2 : 3, y);
                (right, down) = (d.x, d.y > 0f ? d.z : -d.z);
            }
            else
            {
                (face, major) = (d.z > 0f ? 4 : 5, z);
                (right, down) = (d.z > 0f ? d.x : -d.x, -d.y);
            }
            u = (right / major + 1f) * 0.5f;
            v = (down / major + 1f) * 0.5f;
            return face;
        }

        static void Texel(float[] faces, int side, Vector3 direction, out float red, out float green, out float blue)
        {
            var face = Face(direction, out var u, out var v);
            float x = Mathf.Clamp(u * side - 0.5f, 0f, side - 1f), y = Mathf.Clamp(v * side - 0.5f, 0f, side - 1f);
            int left = (int)x, top = (int)y;
            int right = Math.Min(left + 1, side - 1), bottom = Math.Min(top + 1, side - 1);
            float along = x - left, down = y - top;
            (red, green, blue) = (0f, 0f, 0f);
            void Add(int column, int row, float weight, ref float r, ref float g, ref float b)
            {
                var at = 4 * ((face * side + row) * side + column);
                r += weight * faces[at];
                g += weight * faces[at + 1];
                b += weight * faces[at + 2];
            }
            Add(left, top, (1f - along) * (1f - down), ref red, ref green, ref blue);
            Add(right, top, along * (1f - down), ref red, ref green, ref blue);
            Add(left, bottom, (1f - along) * down, ref red, ref green, ref blue);
            Add(right, bottom, along * down, ref red, ref green, ref blue);
        }
    }
}
