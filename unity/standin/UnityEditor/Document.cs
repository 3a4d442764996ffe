// What Unity serialises of an object, as a tree: for SerializedObject, for Undo, and for what a domain reload keeps.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEngine;

namespace StandIn
{
    public sealed class Node
    {
        public Type Type;
        public FieldInfo Field;
        /// Of a leaf.
        public object Value;
        /// Of a class or struct with fields of its own.
        public Dictionary<string, Node> Fields;
        /// Of an array or a list.
        public List<Node> Elements;

        public static Node Of(object target) => new Node { Type = target.GetType(), Fields = FieldsOf(target.GetType()).ToDictionary(field => field.Name, field => Read(field.FieldType, field.GetValue(target), field)) };

        /// Fields that Unity serialises; of the engine's own objects none.
        public static IEnumerable<FieldInfo> FieldsOf(Type type) => Serializer.FieldsOf(type);

        static Type ElementOf(Type type) => type.IsArray ? type.GetElementType() : type.IsGenericType && type.GetGenericTypeDefinition() == typeof(List<>) ? type.GetGenericArguments()[0] : null;

        static bool IsLeaf(Type type) => type.IsPrimitive || type.IsEnum || type == typeof(string) || typeof(UnityEngine.Object).IsAssignableFrom(type)
            || type == typeof(Color) || type == typeof(Color32) || type == typeof(Vector2) || type == typeof(Vector3) || type == typeof(Vector4) || type == typeof(Quaternion) || type == typeof(Rect) || type == typeof(Bounds)
            || type.Namespace == "UnityEngine" && type.IsValueType;

        static Node Read(Type type, object value, FieldInfo field)
        {
            var node = new Node { Type = type, Field = field };
            var element = ElementOf(type);
            if (element != null) node.Elements = value == null ? new List<Node>() : ((IEnumerable)value).Cast<object>().Select(item => Read(element, item, null)).ToList();
            else if (IsLeaf(type)) node.Value = type == typeof(string) && value == null ? "" : value;
            else
            {
                value = value ?? Activator.CreateInstance(type);
                node.Fields = FieldsOf(type).ToDictionary(one => one.Name, one => Read(one.FieldType, one.GetValue(value), one));
            }
            return node;
        }

        public Node Copy() => new Node { Type = Type, Field = Field, Value = Value, Fields = Fields?.ToDictionary(pair => pair.Key, pair => pair.Value.Copy()), Elements = Elements?.Select(element => element.Copy()).ToList() };

        public bool Same(Node other)
        {
            if (Elements != null) return Elements.Count == other.Elements.Count && Elements.Zip(other.Elements, (a, b) => a.Same(b)).All(same => same);
            if (Fields != null) return Fields.All(pair => pair.Value.Same(other.Fields[pair.Key]));
            return Equals(Value, other.Value);
        }

        /// Writes all into an object, in place.
        public void WriteTo(object target)
        {
            foreach (var field in FieldsOf(target.GetType())) if (Fields.TryGetValue(field.Name, out var node)) field.SetValue(target, node.Make());
        }

        object Make()
        {
            if (Elements != null)
            {
                var element = ElementOf(Type);
                if (Type.IsArray)
                {
                    var array = Array.CreateInstance(element, Elements.Count);
                    for (var i = 0; i < Elements.Count; i++) array.SetValue(Elements[i].Make(), i);
                    return array;
                }
                var list = (IList)Activator.CreateInstance(Type);
                foreach (var one in Elements) list.Add(one.Make());
                return list;
            }
            if (Fields == null) return Value;
            var made = Activator.CreateInstance(Type);
            WriteTo(made);
            return made;
        }

        public Node NewElement() => Elements.Count > 0 ? Elements[Elements.Count - 1].Copy() : Read(ElementOf(Type), ElementOf(Type).IsValueType ? Activator.CreateInstance(ElementOf(Type)) : null, null);

        /// Follows a path such as `knots.Array.data[3].value`.
        public Node Find(string path)
        {
            var at = this;
            foreach (var part in path.Replace(".Array.data[", ".[").Split('.'))
            {
                if (part.StartsWith("["))
                {
                    var index = int.Parse(part.Substring(1, part.Length - 2));
                    if (at.Elements == null || index >= at.Elements.Count) return null;
                    at = at.Elements[index];
                }
                else if (at.Fields == null || !at.Fields.TryGetValue(part, out at)) return null;
            }
            return at;
        }

        /// Calls a message of Unity's, private or not.
        public static void Send(object target, string message)
        {
            for (var type = target.GetType(); type != null; type = type.BaseType)
            {
                var method = type.GetMethod(message, BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly, null, Type.EmptyTypes, null);
                if (method == null) continue;
                try { method.Invoke(target, null); }
                catch (TargetInvocationException error) { System.Runtime.ExceptionServices.ExceptionDispatchInfo.Capture(error.InnerException).Throw(); }
                return;
            }
        }
    }
}
