// What an asset is called in files that refer to it.
using System;

// It is the engine's since 6000.5.
#if UNITY_6000_5_OR_NEWER
namespace UnityEngine
#else
namespace UnityEditor
#endif
{
    [Serializable]
    public struct GUID : IEquatable<GUID>
    {
        readonly string hex;
        public GUID(string hexRepresentation) { hex = hexRepresentation; }
        public bool Empty() => string.IsNullOrEmpty(hex);
        public override string ToString() => hex ?? new string('0', 32);
        public bool Equals(GUID obj) => ToString() == obj.ToString();
        public override bool Equals(object obj) => obj is GUID other && Equals(other);
        public override int GetHashCode() => ToString().GetHashCode();
        public static bool TryParse(string hex, out GUID result)
        {
            result = new GUID(hex);
            return hex != null && hex.Length == 32;
        }
        public static bool operator ==(GUID x, GUID y) => x.Equals(y);
        public static bool operator !=(GUID x, GUID y) => !x.Equals(y);
    }
}
