// Which fields the engine keeps of a script, and how it copies them: by Unity's rules for serialisation.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEngine;
using Object = UnityEngine.Object;

namespace StandIn
{
    public static class Serializer
    {
        static readonly Dictionary<(Type, bool), FieldInfo[]> known = new Dictionary<(Type, bool), FieldInfo[]>();
        const int MostDeep = 10;

        /// The fields that are kept, those of base classes first. A reload of scripts keeps private ones, too, which scenes,
        /// assets and clones do not have: whoever wants to begin anew says so with [NonSerialized].
        public static FieldInfo[] FieldsOf(Type type, bool isReload = false)
        {
            if (known.TryGetValue((type, isReload), out var found)) return found;
            var fields = new List<FieldInfo>();
            for (var at = type; at != null && at != typeof(object) && !IsEnginesObject(at); at = at.BaseType)
                fields.InsertRange(0, at.GetFields(BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly).Where(field => IsKept(field, isReload)));
            return known[(type, isReload)] = fields.ToArray();
        }

        static bool IsKept(FieldInfo field, bool isReload)
        {
            if (field.IsInitOnly || field.IsLiteral || Attribute.IsDefined(field, typeof(NonSerializedAttribute))) return false;
            if (Attribute.IsDefined(field, typeof(SerializeReference))) return true;
            var isSaid = field.IsPublic || Attribute.IsDefined(field, typeof(SerializeField));
            // What the engine's own classes have here is no state of Unity's.
            return (isSaid || isReload && !field.DeclaringType.Assembly.GetName().Name.StartsWith("Unity")) && IsKept(field.FieldType, true);
        }

        static bool IsKept(Type type, bool listsToo)
        {
            if (type.IsPrimitive) return type != typeof(IntPtr) && type != typeof(UIntPtr);
            if (type.IsEnum) return IsSmall(Enum.GetUnderlyingType(type));
            if (type == typeof(string) || typeof(Object).IsAssignableFrom(type)) return true;
            if (listsToo && type.IsArray && type.GetArrayRank() == 1) return IsKept(type.GetElementType(), false);
            if (listsToo && type.IsGenericType && type.GetGenericTypeDefinition() == typeof(List<>)) return IsKept(type.GetGenericArguments()[0], false);
            if (type.IsPointer || typeof(Delegate).IsAssignableFrom(type) || type.IsInterface || type == typeof(object) || typeof(IDictionary).IsAssignableFrom(type)) return false;
            // Of the class library nothing but lists, whatever else is serialisable there: no dictionaries, dates or tuples.
            if (type.Namespace != null && (type.Namespace + ".").StartsWith("System.")) return false;
            if (IsEngines(type) && native.Contains(type.Name)) return true;
            return type.IsSerializable && !type.IsAbstract;
        }

        /// What the engine serialises by itself of its own types; the others say that they are serialisable.
        static readonly HashSet<string> native = new HashSet<string>
        {
            "Vector2", "Vector3", "Vector4", "Vector2Int", "Vector3Int", "Quaternion", "Matrix4x4", "Color", "Color32", "Rect", "RectInt", "Bounds", "BoundsInt",
            "LayerMask", "AnimationCurve", "Gradient", "RectOffset", "Hash128",
        };
        static bool IsSmall(Type number) => number != typeof(long) && number != typeof(ulong);
        static bool IsEngines(Type type) => type.Assembly == typeof(Object).Assembly;
        static bool IsEnginesObject(Type type) => IsEngines(type) && typeof(Object).IsAssignableFrom(type);

        static bool IsPlain(Type type) => type.IsPrimitive || type == typeof(string) || type.IsEnum;

        /// Copies the kept fields of one object to another of the same (or a reloaded) type. References to objects go through `map`.
        public static void Copy(object from, object to, Func<Object, Object> map, bool isReload = false)
        {
            if (from is ISerializationCallbackReceiver before) before.OnBeforeSerialize();
            foreach (var field in FieldsOf(from.GetType(), isReload)) field.SetValue(to, CopyOf(field.GetValue(from), field.FieldType, map, isReload, Attribute.IsDefined(field, typeof(SerializeReference)), 0));
            if (to is ISerializationCallbackReceiver after) after.OnAfterDeserialize();
        }

        static object CopyOf(object value, Type type, Func<Object, Object> map, bool isReload, bool byReference, int depth)
        {
            if (IsPlain(type)) return type == typeof(string) ? value ?? "" : value;
            if (typeof(Object).IsAssignableFrom(type)) return value is Object item && Objects.Find(item.instanceID) is Object now ? map(now) : null;
            if (type.IsValueType && IsEngines(type)) return value;
            if (type.IsArray)
            {
                var element = type.GetElementType();
                var source = (Array)value;
                var copy = Array.CreateInstance(element, source?.Length ?? 0);
                if (source != null && element.IsPrimitive) { Buffer.BlockCopy(source, 0, copy, 0, Buffer.ByteLength(source)); return copy; }
                for (int i = 0; i < copy.Length; i++) copy.SetValue(CopyOf(source.GetValue(i), element, map, isReload, byReference, depth + 1), i);
                return copy;
            }
            if (type.IsGenericType && type.GetGenericTypeDefinition() == typeof(List<>))
            {
                var copy = (IList)Activator.CreateInstance(type);
                if (value != null) foreach (var item in (IList)value) copy.Add(CopyOf(item, type.GetGenericArguments()[0], map, isReload, byReference, depth + 1));
                return copy;
            }
            if (byReference && value == null) return null;
            // By value: nothing becomes an instance with its defaults.
            if (depth > MostDeep) return null;
            if (value == null) return type.GetConstructor(BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic, null, Type.EmptyTypes, null) == null ? null : Activator.CreateInstance(type, true);
            var actual = byReference ? value.GetType() : type;
            var made = System.Runtime.Serialization.FormatterServices.GetUninitializedObject(actual);
            if (!actual.IsValueType && actual.GetConstructor(BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic, null, Type.EmptyTypes, null) != null) made = Activator.CreateInstance(actual, true);
            if (value is ISerializationCallbackReceiver before) before.OnBeforeSerialize();
            foreach (var field in FieldsOf(actual, isReload)) field.SetValue(made, CopyOf(field.GetValue(value), field.FieldType, map, isReload, Attribute.IsDefined(field, typeof(SerializeReference)), depth + 1));
            if (made is ISerializationCallbackReceiver after) after.OnAfterDeserialize();
            return made;
        }
    }

    static class Cloning
    {
        internal static Object Clone(Object original)
        {
            Threads.Main("Internal_CloneSingle");
            if (original == null) throw new ArgumentException("The Object you want to instantiate is null.");
            switch (original)
            {
                case GameObject gameObject: return Clone(gameObject, out _);
                case Component component:
                    Clone(component.gameObject, out var map);
                    return map[component];
                case ScriptableObject script:
                    var copy = (ScriptableObject)Objects.Make(script.GetType());
                    copy.name = script.name + "(Clone)";
                    Serializer.Copy(script, copy, item => item == script ? copy : item);
                    copy.Begin();
                    return copy;
                case Material material: return new Material(material) { name = material.name + " (Instance)" };
                default: throw new NotImplementedException($"the stand-in clones no {original.GetType().Name}");
            }
        }

        static GameObject Clone(GameObject original, out Dictionary<Object, Object> made)
        {
            var map = new Dictionary<Object, Object>();
            var clone = Bare(original, map);
            clone.name = original.name + "(Clone)";
            foreach (var pair in map)
                if (pair.Key is MonoBehaviour script) Serializer.Copy(script, pair.Value, item => map.TryGetValue(item, out var own) ? own : item);
                else if (pair.Key is IEngineComponent engine) engine.CopyTo((Component)pair.Value);
            foreach (var pair in map) if (pair.Key is Behaviour from) ((Behaviour)pair.Value).TakeOver(from.isOn);
            clone.isPrefab = false;
            foreach (var at in clone.transform.WithChildren()) at.gameObject.isPrefab = false;
            made = map;
            Lifecycle.Refresh(clone);
            return clone;
        }

        static GameObject Bare(GameObject original, Dictionary<Object, Object> map)
        {
            var clone = new GameObject(original.name) { layer = original.layer, tag = original.tag, isStatic = original.isStatic, isPrefab = true };
            if (!original.activeSelf) clone.SetActive(false);
            map[original] = clone;
            Transform from = original.transform, to = clone.transform;
            map[from] = to;
            to.SetLocalPositionAndRotation(from.localPosition, from.localRotation);
            to.localScale = from.localScale;
            foreach (var component in original.components.Skip(1)) map[component] = clone.Add(component.GetType());
            foreach (var child in from.Children()) Bare(child.gameObject, map).transform.SetParent(to, false);
            return clone;
        }
    }

    /// An engine's component whose state is copied with its object.
    interface IEngineComponent { void CopyTo(Component other); }
}
