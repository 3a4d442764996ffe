// What objects are called while a process runs, since 6000.3 in place of their instance's number.
using System;

namespace UnityEngine
{
    public struct EntityId : IEquatable<EntityId>
    {
        readonly ulong id;
        internal EntityId(int instance) => id = unchecked((uint)instance);
        public static EntityId None => default;
        public static ulong ToULong(EntityId entityId) => entityId.id;
        public bool IsValid() => id != 0;
        public bool Equals(EntityId other) => id == other.id;
        public override bool Equals(object obj) => obj is EntityId other && Equals(other);
        public override int GetHashCode() => id.GetHashCode();
        public override string ToString() => id.ToString();
        public static bool operator ==(EntityId left, EntityId right) => left.Equals(right);
        public static bool operator !=(EntityId left, EntityId right) => !left.Equals(right);
    }
}
