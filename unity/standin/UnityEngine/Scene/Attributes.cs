using System;

namespace UnityEngine
{
    /// What is shown in inspectors.
    static class Values
    {
#if UNITY_6000_0_OR_NEWER
        internal const AttributeTargets Targets = AttributeTargets.Field | AttributeTargets.Property;
#else
        internal const AttributeTargets Targets = AttributeTargets.Field;
#endif
    }

    [AttributeUsage(Values.Targets, Inherited = true)]
    public abstract class PropertyAttribute : Attribute { public int order { get; set; } }

#if UNITY_6000_3_OR_NEWER
    [AttributeUsage(AttributeTargets.Field)]
#endif
    public sealed class SerializeField : Attribute { }
    [AttributeUsage(AttributeTargets.Field)] public sealed class SerializeReference : Attribute { }
    public sealed class HideInInspector : Attribute { }
    [AttributeUsage(Values.Targets)] public sealed class RangeAttribute : PropertyAttribute { public readonly float min, max; public RangeAttribute(float min, float max) { this.min = min; this.max = max; } }
    [AttributeUsage(Values.Targets)] public sealed class MinAttribute : PropertyAttribute { public readonly float min; public MinAttribute(float min) => this.min = min; }
    [AttributeUsage(AttributeTargets.All)] public class TooltipAttribute : PropertyAttribute { public readonly string tooltip; public TooltipAttribute(string tooltip) => this.tooltip = tooltip; }
    [AttributeUsage(Values.Targets, AllowMultiple = true)] public class HeaderAttribute : PropertyAttribute { public readonly string header; public HeaderAttribute(string header) => this.header = header; }
    [AttributeUsage(AttributeTargets.Field, AllowMultiple = true)] public class SpaceAttribute : PropertyAttribute { public readonly float height; public SpaceAttribute() => height = 8; public SpaceAttribute(float height) => this.height = height; }
    [AttributeUsage(Values.Targets)] public sealed class ColorUsageAttribute : PropertyAttribute { public readonly bool showAlpha, hdr; public ColorUsageAttribute(bool showAlpha) => this.showAlpha = showAlpha; public ColorUsageAttribute(bool showAlpha, bool hdr) { this.showAlpha = showAlpha; this.hdr = hdr; } }
    [AttributeUsage(AttributeTargets.Field)] public sealed class GradientUsageAttribute : PropertyAttribute { public readonly bool hdr; public GradientUsageAttribute(bool hdr) => this.hdr = hdr; }
    [AttributeUsage(Values.Targets)] public sealed class TextAreaAttribute : PropertyAttribute { public readonly int minLines, maxLines; public TextAreaAttribute() { minLines = maxLines = 3; } public TextAreaAttribute(int minLines, int maxLines) { this.minLines = minLines; this.maxLines = maxLines; } }
    [AttributeUsage(Values.Targets)] public sealed class MultilineAttribute : PropertyAttribute { public readonly int lines; public MultilineAttribute() => lines = 3; public MultilineAttribute(int lines) => this.lines = lines; }
    [AttributeUsage(Values.Targets)] public sealed class DelayedAttribute : PropertyAttribute { }
    [AttributeUsage(AttributeTargets.Field)] public sealed class NonReorderableAttribute : PropertyAttribute { }
    [AttributeUsage(AttributeTargets.Field)] public class InspectorNameAttribute : PropertyAttribute { public readonly string displayName; public InspectorNameAttribute(string displayName) => this.displayName = displayName; }
    [AttributeUsage(AttributeTargets.Field, AllowMultiple = true)] public class ContextMenuItemAttribute : PropertyAttribute { public readonly string name, function; public ContextMenuItemAttribute(string name, string function) { this.name = name; this.function = function; } }

    public sealed class ExecuteAlways : Attribute { }
    public sealed class ExecuteInEditMode : Attribute { }
    [AttributeUsage(AttributeTargets.Class, AllowMultiple = true)]
    public sealed class RequireComponent : Attribute
    {
        public Type m_Type0, m_Type1, m_Type2;
        public RequireComponent(Type requiredComponent) => m_Type0 = requiredComponent;
        public RequireComponent(Type requiredComponent, Type requiredComponent2) { m_Type0 = requiredComponent; m_Type1 = requiredComponent2; }
        public RequireComponent(Type requiredComponent, Type requiredComponent2, Type requiredComponent3) { m_Type0 = requiredComponent; m_Type1 = requiredComponent2; m_Type2 = requiredComponent3; }
    }
    [AttributeUsage(AttributeTargets.Class, Inherited = false)] public sealed class DisallowMultipleComponent : Attribute { }
    [AttributeUsage(AttributeTargets.Class)] public class SelectionBaseAttribute : Attribute { }
    [AttributeUsage(AttributeTargets.Class)] public class DefaultExecutionOrder : Attribute { public int order { get; } public DefaultExecutionOrder(int order) => this.order = order; }
    public sealed class AddComponentMenu : Attribute { public string componentMenu { get; } public int componentOrder { get; } public AddComponentMenu(string menuName) => componentMenu = menuName; public AddComponentMenu(string menuName, int order) { componentMenu = menuName; componentOrder = order; } }
    [AttributeUsage(AttributeTargets.Method, AllowMultiple = true)] public sealed class ContextMenu : Attribute { public readonly string menuItem; public readonly bool validate; public ContextMenu(string itemName) => menuItem = itemName; public ContextMenu(string itemName, bool isValidateFunction) { menuItem = itemName; validate = isValidateFunction; } }
    [AttributeUsage(AttributeTargets.Class, Inherited = false)] public sealed class CreateAssetMenuAttribute : Attribute { public string menuName { get; set; } public string fileName { get; set; } public int order { get; set; } }
    [AttributeUsage(AttributeTargets.Class)] public class HelpURLAttribute : Attribute { public string URL { get; } public HelpURLAttribute(string url) => URL = url; }
    [AttributeUsage(AttributeTargets.Class)] public class IconAttribute : Attribute { public string path { get; } public IconAttribute(string path) => this.path = path; }
    [AttributeUsage(AttributeTargets.Class)] public sealed class PreferBinarySerialization : Attribute { }
    public enum RuntimeInitializeLoadType { AfterSceneLoad, BeforeSceneLoad, AfterAssembliesLoaded, BeforeSplashScreen, SubsystemRegistration }
    [AttributeUsage(AttributeTargets.Method)] public class RuntimeInitializeOnLoadMethodAttribute : Scripting.PreserveAttribute { public RuntimeInitializeLoadType loadType { get; } public RuntimeInitializeOnLoadMethodAttribute() { } public RuntimeInitializeOnLoadMethodAttribute(RuntimeInitializeLoadType loadType) => this.loadType = loadType; }
    public interface ISerializationCallbackReceiver { void OnBeforeSerialize(); void OnAfterDeserialize(); }
}

namespace UnityEngine.Scripting
{
    [AttributeUsage(AttributeTargets.Assembly | AttributeTargets.Class | AttributeTargets.Struct | AttributeTargets.Enum | AttributeTargets.Constructor | AttributeTargets.Method | AttributeTargets.Property | AttributeTargets.Field | AttributeTargets.Event | AttributeTargets.Interface | AttributeTargets.Delegate, Inherited = false)] public class PreserveAttribute : Attribute { }
    [AttributeUsage(AttributeTargets.Assembly)] public class AlwaysLinkAssemblyAttribute : Attribute { }
}

namespace UnityEngine.Serialization
{
    [AttributeUsage(AttributeTargets.Field, AllowMultiple = true, Inherited = false)] public class FormerlySerializedAsAttribute : Attribute { public string oldName { get; } public FormerlySerializedAsAttribute(string oldName) => this.oldName = oldName; }
}

namespace UnityEngine.Scripting.APIUpdating
{
    [AttributeUsage(AttributeTargets.Class | AttributeTargets.Struct | AttributeTargets.Enum | AttributeTargets.Interface | AttributeTargets.Delegate)]
    public class MovedFromAttribute : Attribute { public MovedFromAttribute(bool autoUpdateAPI, string sourceNamespace = null, string sourceAssembly = null, string sourceClassName = null) { } }
}

namespace AOT
{
    [AttributeUsage(AttributeTargets.Method, AllowMultiple = true)] public class MonoPInvokeCallbackAttribute : Attribute { public MonoPInvokeCallbackAttribute(Type type) { } }
}
