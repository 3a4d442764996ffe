// Serialised objects and their properties, over what Unity would serialise of them.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using StandIn;
using UnityEngine;
using Object = UnityEngine.Object;

namespace UnityEditor
{
    public enum SerializedPropertyType { Generic = -1, Integer, Boolean, Float, String, Color, ObjectReference, LayerMask, Enum, Vector2, Vector3, Vector4, Rect, ArraySize, Character, AnimationCurve, Bounds }

    public class SerializedObject : IDisposable
    {
        internal readonly Node[] nodes;
        Node[] known;

        public SerializedObject(Object obj) : this(new[] { obj }) { }
        public SerializedObject(Object[] objs)
        {
            if (objs.Length == 0 || objs.Any(one => one == null)) throw new ArgumentException("Object at index 0 is null");
            targetObjects = objs;
            nodes = new Node[objs.Length];
            Update();
        }

        public Object[] targetObjects { get; }
        public Object targetObject => targetObjects[0];
        public bool isEditingMultipleObjects => targetObjects.Length > 1;
        public bool hasModifiedProperties => nodes.Where((node, i) => !node.Same(known[i])).Any();

        public void Update()
        {
            foreach (var target in targetObjects) if (target == null) throw new NullReferenceException("SerializedObject target has been destroyed.");
            for (var i = 0; i < nodes.Length; i++) nodes[i] = Node.Of(targetObjects[i]);
            known = nodes.Select(node => node.Copy()).ToArray();
        }
        public bool UpdateIfRequiredOrScript()
        {
            if (!hasModifiedProperties) Update();
            return true;
        }

        public bool ApplyModifiedProperties() => Apply(true);
        public bool ApplyModifiedPropertiesWithoutUndo() => Apply(false);

        bool Apply(bool undo)
        {
            var changed = false;
            for (var i = 0; i < nodes.Length; i++)
            {
                if (nodes[i].Same(known[i])) continue;
                changed = true;
                if (undo) Undo.RegisterCompleteObjectUndo(targetObjects[i], "Inspector");
                // Only what was edited here: something else may have changed meanwhile.
                var now = Node.Of(targetObjects[i]);
                foreach (var field in nodes[i].Fields) if (!field.Value.Same(known[i].Fields[field.Key])) now.Fields[field.Key] = field.Value.Copy();
                now.WriteTo(targetObjects[i]);
                EditorUtility.SetDirty(targetObjects[i]);
                Messages.Send(targetObjects[i], "OnValidate");
            }
            Update();
            if (changed) StandIn.Bindings.Refresh();
            return changed;
        }

        public SerializedProperty FindProperty(string propertyPath) => nodes[0].Find(propertyPath) == null ? null : new SerializedProperty(this, propertyPath);
        public SerializedProperty GetIterator() => new SerializedProperty(this, null);
        public void Dispose() { }
    }

    public class SerializedProperty : IDisposable
    {
        internal SerializedProperty(SerializedObject serializedObject, string path) { this.serializedObject = serializedObject; propertyPath = path; }

        public SerializedObject serializedObject { get; }
        public string propertyPath { get; private set; }
        public string name => Node.Field?.Name ?? propertyPath.Substring(propertyPath.LastIndexOf('.') + 1);
        public string displayName => ObjectNames.NicifyVariableName(name);
        public string tooltip => Node.Field?.GetCustomAttribute<TooltipAttribute>()?.tooltip ?? "";
        public bool isArray => Node.Elements != null;
        public bool editable => true;
        public bool prefabOverride { get => false; set => throw new NotImplementedException("the stand-in has no prefabs"); }
        internal Node Node => serializedObject.nodes[0].Find(propertyPath);
        IEnumerable<Node> Nodes => serializedObject.nodes.Select(node => node.Find(propertyPath)).Where(node => node != null);

        public SerializedProperty Copy() => new SerializedProperty(serializedObject, propertyPath);
        public SerializedProperty FindPropertyRelative(string relativePropertyPath) => serializedObject.FindProperty(propertyPath + "." + relativePropertyPath);
        public bool hasMultipleDifferentValues => Nodes.Any(node => !node.Same(Node));

        public bool NextVisible(bool enterChildren)
        {
            var fields = serializedObject.nodes[0].Fields.Where(pair => pair.Value.Field.GetCustomAttribute<HideInInspector>() == null).Select(pair => pair.Key).ToList();
            if (propertyPath == null && enterChildren) propertyPath = "";
            var next = propertyPath == "" ? 0 : fields.IndexOf(propertyPath) + 1;
            if (next >= fields.Count) return false;
            propertyPath = fields[next];
            return true;
        }

        public SerializedPropertyType propertyType
        {
            get
            {
                var type = Node.Type;
                if (type.IsEnum) return SerializedPropertyType.Enum;
                if (typeof(Object).IsAssignableFrom(type)) return SerializedPropertyType.ObjectReference;
                return type == typeof(int) || type == typeof(uint) || type == typeof(long) || type == typeof(byte) ? SerializedPropertyType.Integer : type == typeof(bool) ? SerializedPropertyType.Boolean
                    : type == typeof(float) || type == typeof(double) ? SerializedPropertyType.Float : type == typeof(string) ? SerializedPropertyType.String : type == typeof(Color) ? SerializedPropertyType.Color
                    : type == typeof(Vector2) ? SerializedPropertyType.Vector2 : type == typeof(Vector3) ? SerializedPropertyType.Vector3 : SerializedPropertyType.Generic;
            }
        }

        object Get(params SerializedPropertyType[] types)
        {
            if (!types.Contains(propertyType)) throw new InvalidOperationException($"type is not a supported {string.Join(" or ", types)} value: {propertyPath} is {propertyType}");
            return Node.Value;
        }

        void Set(object value, params SerializedPropertyType[] types)
        {
            Get(types);
            foreach (var node in Nodes) node.Value = node.Type.IsPrimitive ? Convert.ChangeType(value, node.Type) : value;
        }

        public int intValue { get => Convert.ToInt32(Get(SerializedPropertyType.Integer, SerializedPropertyType.Enum)); set => Set(value, SerializedPropertyType.Integer); }
        public uint uintValue { get => Convert.ToUInt32(Get(SerializedPropertyType.Integer)); set => Set(value, SerializedPropertyType.Integer); }
        public bool boolValue { get => (bool)Get(SerializedPropertyType.Boolean); set => Set(value, SerializedPropertyType.Boolean); }
        public float floatValue { get => Convert.ToSingle(Get(SerializedPropertyType.Float)); set => Set(value, SerializedPropertyType.Float); }
        public double doubleValue { get => Convert.ToDouble(Get(SerializedPropertyType.Float)); set => Set(value, SerializedPropertyType.Float); }
        public string stringValue { get => (string)Get(SerializedPropertyType.String); set => Set(value, SerializedPropertyType.String); }
        public Color colorValue { get => (Color)Get(SerializedPropertyType.Color); set => Set(value, SerializedPropertyType.Color); }
        public Vector2 vector2Value { get => (Vector2)Get(SerializedPropertyType.Vector2); set => Set(value, SerializedPropertyType.Vector2); }
        public Vector3 vector3Value { get => (Vector3)Get(SerializedPropertyType.Vector3); set => Set(value, SerializedPropertyType.Vector3); }
        public Object objectReferenceValue { get => (Object)Get(SerializedPropertyType.ObjectReference); set => Set(value, SerializedPropertyType.ObjectReference); }
        public int enumValueIndex
        {
            get => Array.IndexOf(Enum.GetValues(Node.Type), Get(SerializedPropertyType.Enum));
            set => Set(Enum.GetValues(Node.Type).GetValue(value), SerializedPropertyType.Enum);
        }

        public int arraySize
        {
            get => Node.Elements.Count;
            set
            {
                foreach (var node in Nodes)
                {
                    while (node.Elements.Count < value) node.Elements.Add(node.NewElement());
                    node.Elements.RemoveRange(value, node.Elements.Count - value);
                }
            }
        }
        public SerializedProperty GetArrayElementAtIndex(int index) => index < arraySize ? new SerializedProperty(serializedObject, $"{propertyPath}.Array.data[{index}]") : throw new IndexOutOfRangeException($"{propertyPath} has no element {index}");
        public void ClearArray() => arraySize = 0;
        public void Dispose() { }
    }

    public sealed class ObjectNames
    {
        public static string NicifyVariableName(string name)
        {
            name = name.TrimStart('_');
            if (name.StartsWith("m_")) name = name.Substring(2);
            var words = System.Text.RegularExpressions.Regex.Replace(name, "(?<=[a-z0-9])(?=[A-Z])", " ");
            return words.Length == 0 ? words : char.ToUpperInvariant(words[0]) + words.Substring(1);
        }
        public static string GetUniqueName(string[] existingNames, string name)
        {
            var unique = name;
            for (var i = 1; existingNames.Contains(unique); i++) unique = $"{name} ({i})";
            return unique;
        }
    }
}
