// Styles of UI Toolkit as its manual lists them: those that the package sets.
using System;

namespace UnityEngine.UIElements
{
    public enum StyleKeyword { Undefined, Null, Auto, None, Initial }
    public enum LengthUnit { Pixel, Percent }
    public enum DisplayStyle { Flex, None }
    public enum Visibility { Visible, Hidden }
    public enum Position { Relative, Absolute }
    public enum Overflow { Visible, Hidden }
    public enum FlexDirection { Column, ColumnReverse, Row, RowReverse }
    public enum Wrap { NoWrap, Wrap, WrapReverse }
    public enum Align { Auto, FlexStart, Center, FlexEnd, Stretch }
    public enum Justify { FlexStart, Center, FlexEnd, SpaceBetween, SpaceAround }
    public enum WhiteSpace { Normal, NoWrap }
    public enum TextOverflow { Clip, Ellipsis }
    public enum PickingMode { Position, Ignore }

    public struct Length
    {
        public float value { get; set; }
        public LengthUnit unit { get; set; }
        public Length(float value) : this(value, LengthUnit.Pixel) { }
        public Length(float value, LengthUnit unit) { this.value = value; this.unit = unit; }
        public static Length Percent(float value) => new Length(value, LengthUnit.Percent);
        public static implicit operator Length(float value) => new Length(value);
    }

    public struct StyleLength
    {
        public Length value { get; set; }
        public StyleKeyword keyword { get; set; }
        public StyleLength(float v) : this(new Length(v)) { }
        public StyleLength(Length v) { this.value = v; keyword = StyleKeyword.Undefined; IsSet = true; }
        public StyleLength(StyleKeyword keyword) { value = default; this.keyword = keyword; IsSet = true; }
        internal bool IsSet { get; }
        internal bool IsPixels => IsSet && keyword == StyleKeyword.Undefined && value.unit == LengthUnit.Pixel;
        internal bool IsPercent => IsSet && keyword == StyleKeyword.Undefined && value.unit == LengthUnit.Percent;
        public static implicit operator StyleLength(float v) => new StyleLength(v);
        public static implicit operator StyleLength(Length v) => new StyleLength(v);
        public static implicit operator StyleLength(StyleKeyword keyword) => new StyleLength(keyword);
    }

    public struct StyleFloat
    {
        public float value { get; set; }
        public StyleKeyword keyword { get; set; }
        public StyleFloat(float v) { this.value = v; keyword = StyleKeyword.Undefined; }
        public StyleFloat(StyleKeyword keyword) { value = 0; this.keyword = keyword; }
        public static implicit operator StyleFloat(float v) => new StyleFloat(v);
        public static implicit operator StyleFloat(StyleKeyword keyword) => new StyleFloat(keyword);
    }

    public struct StyleColor
    {
        public Color value { get; set; }
        public StyleKeyword keyword { get; set; }
        public StyleColor(Color v) { this.value = v; keyword = StyleKeyword.Undefined; }
        public StyleColor(StyleKeyword keyword) { value = default; this.keyword = keyword; }
        public static implicit operator StyleColor(Color v) => new StyleColor(v);
        public static implicit operator StyleColor(StyleKeyword keyword) => new StyleColor(keyword);
    }

    public struct StyleEnum<T> where T : struct, IConvertible
    {
        public T value { get; set; }
        public StyleKeyword keyword { get; set; }
        public StyleEnum(T v) { this.value = v; keyword = StyleKeyword.Undefined; }
        public StyleEnum(StyleKeyword keyword) { value = default; this.keyword = keyword; }
        public static implicit operator StyleEnum<T>(T v) => new StyleEnum<T>(v);
        public static implicit operator StyleEnum<T>(StyleKeyword keyword) => new StyleEnum<T>(keyword);
        public static bool operator ==(StyleEnum<T> lhs, StyleEnum<T> rhs) => lhs.Equals(rhs);
        public static bool operator !=(StyleEnum<T> lhs, StyleEnum<T> rhs) => !lhs.Equals(rhs);
        public bool Equals(StyleEnum<T> other) => keyword == other.keyword && value.Equals(other.value);
        public override bool Equals(object obj) => obj is StyleEnum<T> other && Equals(other);
        public override int GetHashCode() => value.GetHashCode();
    }

    public struct Background
    {
        public Texture2D texture { get; set; }
        public static Background FromTexture2D(Texture2D t) => new Background { texture = t };
    }

    public struct StyleBackground
    {
        public Background value { get; set; }
        public StyleBackground(Texture2D v) { value = Background.FromTexture2D(v); }
        public static implicit operator StyleBackground(Texture2D v) => new StyleBackground(v);
    }

    public interface IStyle
    {
        StyleLength width { get; set; }
        StyleLength height { get; set; }
        StyleLength minWidth { get; set; }
        StyleLength minHeight { get; set; }
        StyleLength maxWidth { get; set; }
        StyleLength maxHeight { get; set; }
        StyleLength left { get; set; }
        StyleLength top { get; set; }
        StyleLength right { get; set; }
        StyleLength bottom { get; set; }
        StyleLength marginLeft { get; set; }
        StyleLength marginTop { get; set; }
        StyleLength marginRight { get; set; }
        StyleLength marginBottom { get; set; }
        StyleLength paddingLeft { get; set; }
        StyleLength paddingTop { get; set; }
        StyleLength paddingRight { get; set; }
        StyleLength paddingBottom { get; set; }
        StyleFloat flexGrow { get; set; }
        StyleFloat flexShrink { get; set; }
        StyleLength flexBasis { get; set; }
        StyleEnum<FlexDirection> flexDirection { get; set; }
        StyleEnum<Wrap> flexWrap { get; set; }
        StyleEnum<Align> alignItems { get; set; }
        StyleEnum<Align> alignSelf { get; set; }
        StyleEnum<Justify> justifyContent { get; set; }
        StyleEnum<Position> position { get; set; }
        StyleEnum<DisplayStyle> display { get; set; }
        StyleEnum<Visibility> visibility { get; set; }
        StyleEnum<Overflow> overflow { get; set; }
        StyleEnum<WhiteSpace> whiteSpace { get; set; }
        StyleEnum<TextOverflow> textOverflow { get; set; }
        StyleEnum<TextAnchor> unityTextAlign { get; set; }
        StyleEnum<FontStyle> unityFontStyleAndWeight { get; set; }
        StyleEnum<ScaleMode> unityBackgroundScaleMode { get; set; }
        StyleLength fontSize { get; set; }
        StyleFloat opacity { get; set; }
        StyleColor color { get; set; }
        StyleColor backgroundColor { get; set; }
        StyleBackground backgroundImage { get; set; }
        StyleColor borderLeftColor { get; set; }
        StyleColor borderTopColor { get; set; }
        StyleColor borderRightColor { get; set; }
        StyleColor borderBottomColor { get; set; }
        StyleFloat borderLeftWidth { get; set; }
        StyleFloat borderTopWidth { get; set; }
        StyleFloat borderRightWidth { get; set; }
        StyleFloat borderBottomWidth { get; set; }
        StyleLength borderTopLeftRadius { get; set; }
        StyleLength borderTopRightRadius { get; set; }
        StyleLength borderBottomLeftRadius { get; set; }
        StyleLength borderBottomRightRadius { get; set; }
    }

    public interface IResolvedStyle
    {
        float width { get; }
        float height { get; }
        Color color { get; }
        Color backgroundColor { get; }
        DisplayStyle display { get; }
        Visibility visibility { get; }
        float fontSize { get; }
    }

    sealed class InlineStyle : IStyle
    {
        public StyleLength width { get; set; }
        public StyleLength height { get; set; }
        public StyleLength minWidth { get; set; }
        public StyleLength minHeight { get; set; }
        public StyleLength maxWidth { get; set; }
        public StyleLength maxHeight { get; set; }
        public StyleLength left { get; set; }
        public StyleLength top { get; set; }
        public StyleLength right { get; set; }
        public StyleLength bottom { get; set; }
        public StyleLength marginLeft { get; set; }
        public StyleLength marginTop { get; set; }
        public StyleLength marginRight { get; set; }
        public StyleLength marginBottom { get; set; }
        public StyleLength paddingLeft { get; set; }
        public StyleLength paddingTop { get; set; }
        public StyleLength paddingRight { get; set; }
        public StyleLength paddingBottom { get; set; }
        public StyleFloat flexGrow { get; set; }
        public StyleFloat flexShrink { get; set; }
        public StyleLength flexBasis { get; set; }
        public StyleEnum<FlexDirection> flexDirection { get; set; }
        public StyleEnum<Wrap> flexWrap { get; set; }
        public StyleEnum<Align> alignItems { get; set; }
        public StyleEnum<Align> alignSelf { get; set; }
        public StyleEnum<Justify> justifyContent { get; set; }
        public StyleEnum<Position> position { get; set; }
        public StyleEnum<DisplayStyle> display { get; set; }
        public StyleEnum<Visibility> visibility { get; set; }
        public StyleEnum<Overflow> overflow { get; set; }
        public StyleEnum<WhiteSpace> whiteSpace { get; set; }
        public StyleEnum<TextOverflow> textOverflow { get; set; }
        public StyleEnum<TextAnchor> unityTextAlign { get; set; }
        public StyleEnum<FontStyle> unityFontStyleAndWeight { get; set; }
        public StyleEnum<ScaleMode> unityBackgroundScaleMode { get; set; }
        public StyleLength fontSize { get; set; }
        public StyleFloat opacity { get; set; } = 1;
        public StyleColor color { get; set; } = StyleKeyword.Null;
        public StyleColor backgroundColor { get; set; } = StyleKeyword.Null;
        public StyleBackground backgroundImage { get; set; }
        public StyleColor borderLeftColor { get; set; }
        public StyleColor borderTopColor { get; set; }
        public StyleColor borderRightColor { get; set; }
        public StyleColor borderBottomColor { get; set; }
        public StyleFloat borderLeftWidth { get; set; }
        public StyleFloat borderTopWidth { get; set; }
        public StyleFloat borderRightWidth { get; set; }
        public StyleFloat borderBottomWidth { get; set; }
        public StyleLength borderTopLeftRadius { get; set; }
        public StyleLength borderTopRightRadius { get; set; }
        public StyleLength borderBottomLeftRadius { get; set; }
        public StyleLength borderBottomRightRadius { get; set; }
    }

    /// What the inline style, and that of the elements above for what is inherited, comes to.
    sealed class ResolvedStyle : IResolvedStyle
    {
        readonly VisualElement element;
        public ResolvedStyle(VisualElement element) { this.element = element; }
        public float width => element.layout.width;
        public float height => element.layout.height;
        public Color backgroundColor => element.style.backgroundColor.keyword == StyleKeyword.Undefined ? element.style.backgroundColor.value : new Color(0, 0, 0, 0);
        public DisplayStyle display => element.style.display.value;
        public Visibility visibility => element.style.visibility.value;
        public float fontSize => element.style.fontSize.IsPixels ? element.style.fontSize.value.value : 12;
        public Color color
        {
            get
            {
                for (var at = element; at != null; at = at.hierarchy.parent)
                    if (at.style.color.keyword == StyleKeyword.Undefined) return at.style.color.value;
                return new Color(0.82f, 0.82f, 0.82f, 1);
            }
        }
    }
}
