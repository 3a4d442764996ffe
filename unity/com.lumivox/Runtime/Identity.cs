using UnityEngine;

namespace Lumivox
{
    /// <summary>What tells objects from each other for as long as the process runs, also those that are gone.</summary>
    internal static class Identity
    {
        /// <summary>0 for none.</summary>
        public static ulong Of(Object of)
        {
            if (of == null) return 0;
#if UNITY_6000_4_OR_NEWER
            return EntityId.ToULong(of.GetEntityId());
#else
            return unchecked((uint)of.GetInstanceID());
#endif
        }
    }
}
