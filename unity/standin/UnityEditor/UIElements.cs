// The editor's own controls, and properties bound to controls.
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;
using UnityEngine.UIElements;
using Object = UnityEngine.Object;

namespace UnityEditor.UIElements
{
    public class ObjectField : BaseField<Object>
    {
        public ObjectField() : this(null) { }
        public ObjectField(string label) : base(label, null) { }
        public Type objectType { get; set; }
        public bool allowSceneObjects { get; set; } = true;
    }

    public class ColorField : BaseField<Color>
    {
        public ColorField() : this(null) { }
        public ColorField(string label) : base(label, null) { }
        public bool showAlpha { get; set; } = true;
        public bool hdr { get; set; }
    }

    public class Toolbar : VisualElement { }
    public class ToolbarButton : Button { public ToolbarButton(Action clickEvent) : base(clickEvent) { } }
    public class ToolbarSpacer : VisualElement { }

    public sealed class SerializedPropertyChangeEvent : EventBase<SerializedPropertyChangeEvent> { public SerializedProperty changedProperty { get; set; } }

    /// A field for a property; made when it is bound.
    public class PropertyField : VisualElement, IBindable
    {
        public PropertyField() { }
        public PropertyField(SerializedProperty property) : this(property, null) { }
        public PropertyField(SerializedProperty property, string label)
        {
            // Unity's stays empty and says nothing: whoever misspells a name would not see it.
            if (property == null) throw new ArgumentNullException(nameof(property), "a field of a property that is not there shows nothing");
            this.label = label;
            bindingPath = property.propertyPath;
        }
        public string bindingPath { get; set; }
        public string label { get; set; }
        public void RegisterValueChangeCallback(EventCallback<SerializedPropertyChangeEvent> callback) => RegisterCallback(callback);

        internal void Make(SerializedObject serialized)
        {
            Clear();
            var property = serialized.FindProperty(bindingPath) ?? throw new InvalidOperationException($"{serialized.targetObject.GetType().Name} has no property {bindingPath}");
            tooltip = string.IsNullOrEmpty(tooltip) ? property.tooltip : tooltip;
            var text = label ?? property.displayName;
            VisualElement field;
            switch (property.propertyType)
            {
                case SerializedPropertyType.Boolean: field = new Toggle(text); break;
                case SerializedPropertyType.Integer: field = new IntegerField(text); break;
                case SerializedPropertyType.Float: field = new FloatField(text); break;
                case SerializedPropertyType.String: field = new TextField(text); break;
                case SerializedPropertyType.ObjectReference: field = new ObjectField(text) { objectType = property.Node.Type }; break;
                case SerializedPropertyType.Color: field = new ColorField(text); break;
                case SerializedPropertyType.Enum: field = new EnumField(text); break;
                default: field = new Label(text); break;
            }
            Add(field);
            field.tooltip = tooltip;
            StandIn.Bindings.Bind(field, property, () => { using (var e = new SerializedPropertyChangeEvent { changedProperty = property }) SendEvent(e); });
        }
    }

    public static class BindingExtensions
    {
        public static void Bind(this VisualElement element, SerializedObject obj)
        {
            foreach (var one in StandIn.Panel.All(element).ToList())
                if (one is PropertyField field && field.bindingPath != null) field.Make(obj);
                else if (one is IBindable bindable && bindable.bindingPath != null && !(one is PropertyField)) StandIn.Bindings.Bind(one, obj.FindProperty(bindable.bindingPath) ?? throw new InvalidOperationException($"no property {bindable.bindingPath}"), null);
        }
        public static void Unbind(this VisualElement element) => StandIn.Bindings.Unbind(element);
        public static void BindProperty(this IBindable field, SerializedProperty property)
        {
            field.bindingPath = property.propertyPath;
            if (field is PropertyField made) made.Make(property.serializedObject);
            else StandIn.Bindings.Bind((VisualElement)field, property, null);
        }
        public static void TrackPropertyValue(this VisualElement element, SerializedProperty property, Action<SerializedProperty> callback = null) => StandIn.Bindings.Track(element, property.serializedObject, property, () => callback?.Invoke(property));
        public static void TrackSerializedObjectValue(this VisualElement element, SerializedObject obj, Action<SerializedObject> callback = null) => StandIn.Bindings.Track(element, obj, null, () => callback?.Invoke(obj));
    }

    public class InspectorElement : BindableElement
    {
        public InspectorElement(Object obj) : this(Editor.CreateEditor(obj)) { }
        public InspectorElement(Editor editor)
        {
            var gui = editor.CreateInspectorGUI();
            if (gui == null) return;
            Add(gui);
            gui.Bind(editor.serializedObject);
        }
        public static void FillDefaultInspector(VisualElement container, SerializedObject serializedObject, Editor editor)
        {
            var property = serializedObject.GetIterator();
            if (property.NextVisible(true))
                do container.Add(new PropertyField(property.Copy())); while (property.NextVisible(false));
        }
    }
}

namespace StandIn
{
    /// Fields and what watches them. Unity looks a few times a second; here at each change and on `Refresh`.
    public static class Bindings
    {
        sealed class Binding
        {
            public VisualElement element;
            public UnityEditor.SerializedObject serialized;
            public UnityEditor.SerializedProperty property;
            public Node seen;
            public Action changed;
        }

        static readonly List<Binding> bindings = new List<Binding>();
        static bool isRefreshing;

        internal static void Track(VisualElement element, UnityEditor.SerializedObject serialized, UnityEditor.SerializedProperty property, Action changed) =>
            bindings.Add(new Binding { element = element, serialized = serialized, property = property, seen = Now(serialized, property).Copy(), changed = changed });

        static Node Now(UnityEditor.SerializedObject serialized, UnityEditor.SerializedProperty property) => property != null ? property.Node : serialized.nodes[0];

        internal static void Unbind(VisualElement element) => bindings.RemoveAll(binding => binding.element == element || element.Contains(binding.element));

        internal static void Bind(VisualElement field, UnityEditor.SerializedProperty property, Action told)
        {
            void Set<T>(Func<T> get, Action<T> set)
            {
                var control = (BaseField<T>)field;
                void Show()
                {
                    control.SetValueWithoutNotify(get());
                    control.showMixedValue = property.hasMultipleDifferentValues;
                }
                Show();
                control.RegisterValueChangedCallback(e =>
                {
                    if (e.target != field) return;
                    property.serializedObject.Update();
                    set(e.newValue);
                    property.serializedObject.ApplyModifiedProperties();
                });
                Track(field, property.serializedObject, property, () => { Show(); told?.Invoke(); });
            }
            switch (field)
            {
                case BaseField<bool> _: Set(() => property.boolValue, value => property.boolValue = value); break;
                case BaseField<int> _: Set(() => property.intValue, value => property.intValue = value); break;
                case BaseField<float> _: Set(() => property.floatValue, value => property.floatValue = value); break;
                case BaseField<string> _: Set(() => property.stringValue, value => property.stringValue = value); break;
                case BaseField<Color> _: Set(() => property.colorValue, value => property.colorValue = value); break;
                case BaseField<UnityEngine.Object> _: Set(() => property.objectReferenceValue, value => property.objectReferenceValue = value); break;
                case BaseField<Enum> _: Set(() => (Enum)property.Node.Value, value => property.enumValueIndex = Array.IndexOf(Enum.GetValues(property.Node.Type), value)); break;
                default: Track(field, property.serializedObject, property, () => told?.Invoke()); break;
            }
        }

        /// Looks whether what is bound has changed.
        public static void Refresh()
        {
            if (isRefreshing) return;
            isRefreshing = true;
            bindings.RemoveAll(binding => binding.element.panel == null && binding.seen != null && binding.serialized.targetObjects.Any(target => target == null));
            foreach (var binding in bindings.ToList())
            {
                if (binding.serialized.targetObjects.Any(target => target == null)) continue;
                binding.serialized.UpdateIfRequiredOrScript();
                var now = Now(binding.serialized, binding.property);
                if (now == null || now.Same(binding.seen)) continue;
                binding.seen = now.Copy();
                binding.changed();
            }
            isRefreshing = false;
        }

        public static void Clear() => bindings.Clear();
    }
}
