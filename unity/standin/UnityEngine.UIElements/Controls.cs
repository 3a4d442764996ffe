// Controls of UI Toolkit: their values, their change events and what a person does to them.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;

namespace UnityEngine.UIElements
{
    public interface INotifyValueChanged<T>
    {
        T value { get; set; }
        void SetValueWithoutNotify(T newValue);
    }

    public static class INotifyValueChangedExtensions
    {
        public static bool RegisterValueChangedCallback<T>(this INotifyValueChanged<T> control, EventCallback<ChangeEvent<T>> callback)
        {
            (control as CallbackEventHandler).RegisterCallback(callback);
            return true;
        }
        public static bool UnregisterValueChangedCallback<T>(this INotifyValueChanged<T> control, EventCallback<ChangeEvent<T>> callback)
        {
            (control as CallbackEventHandler).UnregisterCallback(callback);
            return true;
        }
    }

    public interface IBindable { string bindingPath { get; set; } }
    public class BindableElement : VisualElement, IBindable { public string bindingPath { get; set; } }

    public class TextElement : BindableElement, INotifyValueChanged<string>
    {
        public virtual string text { get; set; } = "";
        public bool enableRichText { get; set; } = true;
        string INotifyValueChanged<string>.value { get => text; set => text = value; }
        void INotifyValueChanged<string>.SetValueWithoutNotify(string newValue) => text = newValue;
    }

    public class Label : TextElement
    {
        public Label() : this("") { }
        public Label(string text) { this.text = text; }
    }

    public class Button : TextElement
    {
        public Button() : this(null) { }
        public Button(Action clickEvent)
        {
            focusable = true;
            if (clickEvent != null) clicked += clickEvent;
            RegisterCallback<ClickEvent>(_ => clicked?.Invoke());
        }
        public event Action clicked;
    }

    public abstract class BaseField<TValueType> : BindableElement, INotifyValueChanged<TValueType>
    {
        TValueType current;
        protected BaseField(string label, VisualElement visualInput)
        {
            labelElement = new Label(label);
            focusable = true;
            this.label = label;
            if (visualInput != null) hierarchy.Add(visualInput);
        }
        public string label { get => labelElement.text; set => labelElement.text = value; }
        public Label labelElement { get; }
        public bool showMixedValue { get; set; }
        public virtual TValueType value
        {
            get => current;
            set
            {
                if (EqualityComparer<TValueType>.Default.Equals(current, value)) return;
                var before = current;
                SetValueWithoutNotify(value);
                if (panel != null) SendEvent(ChangeEvent<TValueType>.GetPooled(before, current));
            }
        }
        public virtual void SetValueWithoutNotify(TValueType newValue) => current = newValue;
        public static readonly string alignedFieldUssClassName = "unity-base-field__aligned";
    }

    public abstract class BaseBoolField : BaseField<bool>
    {
        public BaseBoolField(string label) : base(label, null) { }
        public string text { get; set; }
    }

    public class Toggle : BaseBoolField
    {
        public Toggle() : this(null) { }
        public Toggle(string label) : base(label) { }
    }

    public abstract class TextInputBaseField<TValueType> : BaseField<TValueType>
    {
        internal TextInputBaseField(string label) : base(label, null) { }
        public bool isDelayed { get; set; }
        public bool isReadOnly { get; set; }
    }

    public class TextField : TextInputBaseField<string>
    {
        public TextField() : this(null) { }
        public TextField(string label) : base(label) { SetValueWithoutNotify(""); }
        public bool multiline { get; set; }
        public override void SetValueWithoutNotify(string newValue) => base.SetValueWithoutNotify(newValue ?? "");
    }

    public abstract class TextValueField<TValueType> : TextInputBaseField<TValueType>
    {
        internal TextValueField(string label) : base(label) { }
        public string formatString { get; set; }
    }

    public class FloatField : TextValueField<float> { public FloatField() : this(null) { } public FloatField(string label, int maxLength = 1000) : base(label) { } }
    public class DoubleField : TextValueField<double> { public DoubleField() : this(null) { } public DoubleField(string label, int maxLength = 1000) : base(label) { } }
    public class IntegerField : TextValueField<int> { public IntegerField() : this(null) { } public IntegerField(string label, int maxLength = 1000) : base(label) { } }

    public enum SliderDirection { Horizontal, Vertical }

    public abstract class BaseSlider<TValueType> : BaseField<TValueType> where TValueType : IComparable<TValueType>
    {
        internal BaseSlider(string label, TValueType start, TValueType end) : base(label, null) { lowValue = start; highValue = end; }
        public TValueType lowValue { get; set; }
        public TValueType highValue { get; set; }
        public bool showInputField { get; set; }
        public float pageSize { get; set; }
        public override void SetValueWithoutNotify(TValueType newValue) => base.SetValueWithoutNotify(newValue.CompareTo(lowValue) < 0 ? lowValue : newValue.CompareTo(highValue) > 0 ? highValue : newValue);
    }

    public class Slider : BaseSlider<float>
    {
        public Slider() : this(null, 0, 10) { }
        public Slider(float start, float end, SliderDirection direction = SliderDirection.Horizontal, float pageSize = 0) : this(null, start, end, direction, pageSize) { }
        public Slider(string label, float start = 0, float end = 10, SliderDirection direction = SliderDirection.Horizontal, float pageSize = 0) : base(label, start, end) { }
    }

    public class SliderInt : BaseSlider<int>
    {
        public SliderInt() : this(null, 0, 10) { }
        public SliderInt(string label, int start = 0, int end = 10, SliderDirection direction = SliderDirection.Horizontal, float pageSize = 0) : base(label, start, end) { }
    }

    public abstract class BasePopupField<TValueType, TValueChoice> : BaseField<TValueType>
    {
        internal BasePopupField(string label) : base(label, null) { }
        internal abstract string Shown { get; }
        public List<TValueChoice> choices { get; set; }
        public string text => Shown;
    }

    public class PopupField<T> : BasePopupField<T, T>
    {
        public PopupField(string label = null) : base(label) { choices = new List<T>(); }
        public PopupField(string label, List<T> choices, int defaultIndex, Func<T, string> formatSelectedValueCallback = null, Func<T, string> formatListItemCallback = null) : base(label)
        {
            this.choices = choices;
            if (defaultIndex >= 0) SetValueWithoutNotify(choices[defaultIndex]);
            this.formatSelectedValueCallback = formatSelectedValueCallback;
            this.formatListItemCallback = formatListItemCallback;
        }
        public Func<T, string> formatSelectedValueCallback { get; set; }
        public Func<T, string> formatListItemCallback { get; set; }
        public int index { get => choices.IndexOf(value); set => this.value = value < 0 ? default : choices[value]; }
        internal override string Shown => formatSelectedValueCallback != null ? formatSelectedValueCallback(value) : value?.ToString();
    }

    public class DropdownField : PopupField<string>
    {
        public DropdownField() : this(null) { }
        public DropdownField(string label) : base(label) { }
        public DropdownField(List<string> choices, int defaultIndex, Func<string, string> formatSelectedValueCallback = null, Func<string, string> formatListItemCallback = null) : this(null, choices, defaultIndex, formatSelectedValueCallback, formatListItemCallback) { }
        public DropdownField(string label, List<string> choices, int defaultIndex, Func<string, string> formatSelectedValueCallback = null, Func<string, string> formatListItemCallback = null) : base(label, choices, defaultIndex, formatSelectedValueCallback, formatListItemCallback) { }
    }

    public class EnumField : BaseField<Enum> { public EnumField(string label, Enum defaultValue = null) : base(label, null) { SetValueWithoutNotify(defaultValue); } }

    public class Box : VisualElement { }

    public class Image : VisualElement
    {
        public Texture image { get; set; }
        public ScaleMode scaleMode { get; set; }
        public Color tintColor { get; set; } = Color.white;
    }

    public enum HelpBoxMessageType { None, Info, Warning, Error }

    public class HelpBox : VisualElement
    {
        public HelpBox() : this("", HelpBoxMessageType.None) { }
        public HelpBox(string text, HelpBoxMessageType messageType) { this.text = text; this.messageType = messageType; }
        public string text { get; set; }
        public HelpBoxMessageType messageType { get; set; }
    }

    public class Foldout : BindableElement, INotifyValueChanged<bool>
    {
        bool open = true;
        readonly VisualElement content = new VisualElement();
        public Foldout() { hierarchy.Add(content); }
        public override VisualElement contentContainer => content;
        public string text { get; set; } = "";
        public bool value
        {
            get => open;
            set
            {
                if (open == value) return;
                SetValueWithoutNotify(value);
                if (panel != null) SendEvent(ChangeEvent<bool>.GetPooled(!value, value));
            }
        }
        public void SetValueWithoutNotify(bool newValue)
        {
            open = newValue;
            content.style.display = open ? DisplayStyle.Flex : DisplayStyle.None;
        }
    }

    public enum ScrollViewMode { Vertical, Horizontal, VerticalAndHorizontal }

    public class ScrollView : VisualElement
    {
        readonly VisualElement content = new VisualElement();
        public ScrollView() : this(ScrollViewMode.Vertical) { }
        public ScrollView(ScrollViewMode scrollViewMode) { mode = scrollViewMode; hierarchy.Add(content); }
        public ScrollViewMode mode { get; set; }
        public override VisualElement contentContainer => content;
    }

    public class ProgressBar : AbstractProgressBar { }

    public abstract class AbstractProgressBar : BindableElement, INotifyValueChanged<float>
    {
        public AbstractProgressBar() { }
        public string title { get; set; }
        public float lowValue { get; set; }
        public float highValue { get; set; } = 100;
        public float value { get; set; }
        public void SetValueWithoutNotify(float newValue) => value = newValue;
    }

    public enum SelectionType { None, Single, Multiple }
    public enum CollectionVirtualizationMethod { FixedHeight, DynamicHeight }

    public class ListView : BaseListView
    {
        public Func<VisualElement> makeItem { get; set; }
        public Action<VisualElement, int> bindItem { get; set; }
        internal override VisualElement Make() => makeItem?.Invoke();
        internal override void Bind(VisualElement row, int index) => bindItem?.Invoke(row, index);
    }

    public abstract class BaseListView : BaseVerticalCollectionView { public BaseListView() { } }

    /// Rows of a list; all of them are made.
    public abstract class BaseVerticalCollectionView : BindableElement
    {
        readonly List<VisualElement> rows = new List<VisualElement>();
        int selected = -1;
        public BaseVerticalCollectionView() { }
        internal abstract VisualElement Make();
        internal abstract void Bind(VisualElement row, int index);
        public IList itemsSource { get; set; }
        public float fixedItemHeight { get; set; } = 30;
        public CollectionVirtualizationMethod virtualizationMethod { get; set; }
        public SelectionType selectionType { get; set; } = SelectionType.Single;
        public event Action<IEnumerable<object>> selectionChanged;
        public event Action<IEnumerable<object>> itemsChosen;
        public int selectedIndex { get => selected; set => SetSelection(value); }
        public object selectedItem => selected >= 0 && selected < itemsSource.Count ? itemsSource[selected] : null;
        public void SetSelection(int index)
        {
            SetSelectionWithoutNotify(new[] { index });
            selectionChanged?.Invoke(selectedItem == null ? Enumerable.Empty<object>() : new[] { selectedItem });
        }
        public void SetSelectionWithoutNotify(IEnumerable<int> indices) => selected = indices.DefaultIfEmpty(-1).First();
        public void ClearSelection() => SetSelection(-1);
        public void RefreshItems() => Rebuild();
        public void Rebuild()
        {
            foreach (var row in rows) row.RemoveFromHierarchy();
            rows.Clear();
            for (var i = 0; itemsSource != null && i < itemsSource.Count && Make() is VisualElement row; i++)
            {
                hierarchy.Add(row);
                rows.Add(row);
                Bind(row, i);
            }
        }
        public VisualElement GetRootElementForIndex(int index) => rows[index];
        /// A double click.
        internal void Choose() => itemsChosen?.Invoke(new[] { selectedItem });
    }

    public enum DropdownMenuSizeMode { Auto, Fixed, Content }
    public abstract class AbstractGenericMenu { }

    /// A menu over everything. The last that was opened can be asked for its items.
    public class GenericDropdownMenu
#if UNITY_6000_3_OR_NEWER
        : AbstractGenericMenu
#endif
    {
        internal sealed class Item { public string name; public bool isChecked, isEnabled; public Action action; }
        internal readonly List<Item> items = new List<Item>();
        public void AddItem(string itemName, bool isChecked, Action action) => items.Add(new Item { name = itemName, isChecked = isChecked, isEnabled = true, action = action });
        public void AddDisabledItem(string itemName, bool isChecked) => items.Add(new Item { name = itemName, isChecked = isChecked });
        public void AddSeparator(string path) { }
        public VisualElement contentContainer { get; } = new VisualElement();
#if UNITY_6000_3_OR_NEWER
        public void DropDown(Rect position, VisualElement targetElement, bool anchored = false) => Open(targetElement);
        public void DropDown(Rect position, VisualElement targetElement, DropdownMenuSizeMode dropdownMenuSizeMode = DropdownMenuSizeMode.Auto) => Open(targetElement);
#else
        public void DropDown(Rect position, VisualElement targetElement = null, bool anchored = false) => Open(targetElement);
#endif
        void Open(VisualElement targetElement)
        {
            if (targetElement == null) { Debug.LogError("VisualElement Generic Menu needs a target to find a root to attach to."); return; }
            if (targetElement.panel == null) { Debug.LogError("Could not find rootVisualContainer..."); return; }
            StandIn.Menus.Last = this;
        }
    }

    public sealed class UIDocument : MonoBehaviour
    {
        internal UIDocument() { }
        [SerializeField] PanelSettings m_PanelSettings;
        [SerializeField] float m_SortingOrder;
        public PanelSettings panelSettings { get => m_PanelSettings; set => m_PanelSettings = value; }
        public VisualElement rootVisualElement { get; } = new VisualElement();
        public float sortingOrder { get => m_SortingOrder; set => m_SortingOrder = value; }
    }

    public enum PanelScaleMode { ConstantPixelSize, ConstantPhysicalSize, ScaleWithScreenSize }
    public class StyleSheet : ScriptableObject { }
    public class ThemeStyleSheet : StyleSheet { }
    public class PanelSettings : ScriptableObject
    {
        internal PanelSettings() { }
        [SerializeField] ThemeStyleSheet themeUss;
        [SerializeField] PanelScaleMode m_ScaleMode;
        [SerializeField] float m_Scale = 1;
        public ThemeStyleSheet themeStyleSheet { get => themeUss; set => themeUss = value; }
        public PanelScaleMode scaleMode { get => m_ScaleMode; set => m_ScaleMode = value; }
        public float scale { get => m_Scale; set => m_Scale = value; }
    }
}

namespace StandIn
{
    /// The menu that was opened last.
    public static class Menus
    {
        public static UnityEngine.UIElements.GenericDropdownMenu Last;
        public static string[] Names => Last.items.Select(item => item.name).ToArray();
        public static bool IsEnabled(string name) => Find(name).isEnabled;
        public static bool IsChecked(string name) => Find(name).isChecked;
        public static void Choose(string name)
        {
            var item = Find(name);
            if (!item.isEnabled) throw new InvalidOperationException($"'{name}' is disabled");
            Last = null;
            item.action();
        }
        static UnityEngine.UIElements.GenericDropdownMenu.Item Find(string name) => Last.items.First(item => item.name == name);
        /// Double-clicks the row that is selected.
        public static void Choose(UnityEngine.UIElements.ListView list) => list.Choose();
    }
}
