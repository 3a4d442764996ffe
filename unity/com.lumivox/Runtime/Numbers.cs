// Numbers that scripts give.
using UnityEngine;

namespace Lumivox
{
    internal static class Numbers
    {
        public static bool IsFinite(float value) => !float.IsNaN(value) && !float.IsInfinity(value);

        public static bool IsFinite(Vector3 value) => IsFinite(value.x) && IsFinite(value.y) && IsFinite(value.z);

        /// <summary>Whether a property takes a number, or a vector, that may not be finite. Says so where it does not.</summary>
        public static bool Takes(string property, bool isFinite, Object of)
        {
            if (!isFinite) Debug.LogError($"{property} takes neither NaN nor infinity, and stays as it was.", of);
            return isFinite;
        }

        public static Vector3 Clamp01(Vector3 value) =>
            new Vector3(Mathf.Clamp01(value.x), Mathf.Clamp01(value.y), Mathf.Clamp01(value.z));

        /// <summary>A number of a file or the inspector: the nearest in its range, or what it is without one.</summary>
        public static float Within(float value, float low, float high, float otherwise) =>
            IsFinite(value) ? Mathf.Clamp(value, low, high) : otherwise;

        /// <summary>A colour of the inspector's as light.</summary>
        public static Vector3 Linear(Color color)
        {
            var linear = color.linear;
            return new Vector3(linear.r, linear.g, linear.b);
        }
    }
}
