// A panel as a picture: places elements by the size of their text and paints them in the editor's dark colours. For manuals:
// what Unity's own layout and style sheets make of the same elements looks alike, and is not the same.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;
using UnityEngine.UIElements;

namespace StandIn
{
    public sealed class PanelPicture
    {
        const float FontSize = 12, LineHeight = 16, FieldHeight = 20, Gap = 2, LabelWidth = 122;
        static readonly Color back = Grey(56), ink = Grey(210), edge = Grey(33), input = Grey(42), button = Grey(88), box = Grey(64), chosen = new Color(44 / 255f, 93 / 255f, 135 / 255f);

        readonly Canvas canvas;
        readonly VisualElement root;

        static Color Grey(int value) => new Color(value / 255f, value / 255f, value / 255f);

        PanelPicture(VisualElement root, int width, int height)
        {
            this.root = root;
            canvas = new Canvas(width, height);
        }

        /// The picture of what a panel shows, at a size of its own.
        public static Picture Of(Panel panel, int width, int height)
        {
            var made = new PanelPicture(panel.visualTree, width, height);
            made.canvas.Fill(new Rect(0, 0, width, height), back);
            made.Place(made.root, new Rect(0, 0, width, height));
            made.Paint(made.root, 0, 0, 1f);
            // Elsewhere, the panel is as events expect it.
            panel.Resize(panel.Size.x, panel.Size.y);
            return made.canvas.ToPicture();
        }

        static bool IsGone(VisualElement one) => one.style.display.value == DisplayStyle.None;
        static float Px(StyleLength length, float otherwise = 0) => length.IsPixels ? length.value.value : otherwise;
        static List<VisualElement> Flowing(VisualElement one) => one.hierarchy.Children().Where(child => !IsGone(child) && child.style.position.value != Position.Absolute).ToList();
        static bool IsRow(VisualElement one) => one.style.flexDirection.value == FlexDirection.Row;
        static bool IsField(VisualElement one) => LabelOf(one) != null;
        static Label LabelOf(VisualElement one) => one?.GetType().GetProperty("labelElement")?.GetValue(one) as Label;
        static bool IsBold(VisualElement one) => one.style.unityFontStyleAndWeight.value == FontStyle.Bold;

        /// Borders between an element's edge and its children: what controls have by themselves, and what is asked for.
        static (float left, float top, float right, float bottom) Padding(VisualElement one)
        {
            // A field's own button fills it.
            var own = one is Button && !IsField(one.hierarchy.parent) ? 4 : 0;
            return (Px(one.style.paddingLeft, own), Px(one.style.paddingTop, own / 2), Px(one.style.paddingRight, own), Px(one.style.paddingBottom, own / 2));
        }

        static float Margin(VisualElement one) => one.hierarchy.parent != null && IsField(one.hierarchy.parent) ? 0 : one is Button || one is TextElement || IsField(one) || one is HelpBox || one is Image || one is ProgressBar ? Gap : 0;

        static string TextOf(VisualElement one) => one is TextElement text ? text.text ?? "" : one is HelpBox help ? help.text ?? "" : "";

        static Vector2 Size(VisualElement one, float most)
        {
            var own = new Vector2(Px(one.style.width, -1), Px(one.style.height, -1));
            var natural = own.x >= 0 && own.y >= 0 ? own : Natural(one, own.x >= 0 ? own.x : most);
            var size = new Vector2(own.x >= 0 ? own.x : Mathf.Max(natural.x, Px(one.style.minWidth)), own.y >= 0 ? own.y : Mathf.Max(natural.y, Px(one.style.minHeight)));
            return size + Vector2.one * 2 * Margin(one);
        }

        static Vector2 Natural(VisualElement one, float most)
        {
            var (left, top, right, bottom) = Padding(one);
            var children = Flowing(one);
            if (one is HelpBox) return new Vector2(most, Mathf.Max(38, 10 + LineHeight * Canvas.Wrapped(TextOf(one), FontSize, false, most - 48).Count));
            if (one is ProgressBar) return new Vector2(100, FieldHeight);
            if (one is ListView list) return new Vector2(100, list.fixedItemHeight * children.Count);
            if (IsField(one))
            {
                var label = LabelOf(one).text;
                var named = string.IsNullOrEmpty(label) ? 0 : Mathf.Max(Px(LabelOf(one).style.minWidth, LabelWidth), Canvas.TextWidth(label, FontSize, false) + 8);
                return new Vector2(named + (one is Toggle toggle ? 20 + (string.IsNullOrEmpty(toggle.text) ? 0 : Canvas.TextWidth(toggle.text, FontSize, false) + 4) : 60), FieldHeight);
            }
            if (one is TextElement && children.Count == 0)
            {
                var text = TextOf(one);
                var lines = one.style.whiteSpace.value == WhiteSpace.Normal && one.style.whiteSpace.keyword == StyleKeyword.Undefined && most > 40 ? Canvas.Wrapped(text, FontSize, IsBold(one), most - left - right) : text.Split('\n').ToList();
                return new Vector2(left + right + lines.Max(line => Canvas.TextWidth(line, FontSize, IsBold(one))), top + bottom + LineHeight * (text == "" && !(one is Button) ? 0 : lines.Count));
            }
            var row = IsRow(one);
            var room = most - left - right;
            if (row && one.style.flexWrap.value == Wrap.Wrap)
            {
                var rows = Rows(children, room);
                return new Vector2(most, top + bottom + rows.Sum(line => line.Max(child => Size(child, room).y)));
            }
            var sizes = children.Select(child => Size(child, room)).ToList();
            if (sizes.Count == 0) return new Vector2(left + right, top + bottom);
            return row ? new Vector2(left + right + sizes.Sum(size => size.x), top + bottom + sizes.Max(size => size.y)) : new Vector2(left + right + sizes.Max(size => size.x), top + bottom + sizes.Sum(size => size.y));
        }

        static List<List<VisualElement>> Rows(List<VisualElement> children, float room)
        {
            var rows = new List<List<VisualElement>>();
            var used = float.MaxValue;
            foreach (var child in children)
            {
                var width = Size(child, room).x;
                if (used + width > room) { rows.Add(new List<VisualElement>()); used = 0; }
                rows[rows.Count - 1].Add(child);
                used += width;
            }
            return rows;
        }

        void Place(VisualElement one, Rect at)
        {
            one.layout = at;
            one.isDirty = true;
            var (left, top, right, bottom) = Padding(one);
            if (IsField(one)) left = string.IsNullOrEmpty(LabelOf(one).text) ? 0 : Mathf.Max(Px(LabelOf(one).style.minWidth, LabelWidth), Canvas.TextWidth(LabelOf(one).text, FontSize, false) + 8);
            var inside = new Rect(left, top, Mathf.Max(0, at.width - left - right), Mathf.Max(0, at.height - top - bottom));
            var children = Flowing(one);
            if (one is ListView list) for (var i = 0; i < children.Count; i++) Place(children[i], new Rect(4, i * list.fixedItemHeight + 2, at.width - 8, list.fixedItemHeight - 2));
            else if (IsRow(one) && one.style.flexWrap.value == Wrap.Wrap)
            {
                var y = inside.y;
                foreach (var row in Rows(children, inside.width))
                {
                    var height = row.Max(child => Size(child, inside.width).y);
                    Line(row, new Rect(inside.x, y, inside.width, height), true, one);
                    y += height;
                }
            }
            else Line(children, inside, IsRow(one) || IsField(one), one);
            foreach (var child in one.hierarchy.Children().Where(child => !IsGone(child) && child.style.position.value == Position.Absolute))
            {
                var size = Size(child, at.width);
                float x = Px(child.style.left), y = Px(child.style.top);
                if (child.style.right.IsPixels && !child.style.width.IsPixels) size.x = at.width - x - Px(child.style.right);
                if (child.style.bottom.IsPixels && child.style.top.IsPixels) size.y = at.height - y - Px(child.style.bottom);
                else if (child.style.bottom.IsPixels) y = at.height - size.y - Px(child.style.bottom);
                Place(child, new Rect(x, y, size.x, size.y));
            }
        }

        void Line(List<VisualElement> children, Rect inside, bool row, VisualElement parent)
        {
            float Along(Vector2 size) => row ? size.x : size.y;
            var sizes = children.Select(child => Along(Size(child, row ? inside.width / Mathf.Max(1, children.Count) : inside.width))).ToList();
            var spare = (row ? inside.width : inside.height) - sizes.Sum();
            var growing = children.Sum(child => child.style.flexGrow.value);
            // What grows gives way, too, where there is too little room.
            for (var i = 0; i < children.Count && growing > 0; i++) sizes[i] = Mathf.Max(row ? 20 : 0, sizes[i] + spare * children[i].style.flexGrow.value / growing);
            var at = row ? inside.x : inside.y;
            for (var i = 0; i < children.Count; i++)
            {
                var margin = Margin(children[i]);
                var own = Size(children[i], row ? sizes[i] : inside.width);
                var align = parent.style.alignItems.value;
                var across = row ? inside.height : inside.width;
                var length = align == Align.Center || align == Align.FlexStart ? Mathf.Min(across, row ? own.y : own.x) : (row ? children[i].style.height : children[i].style.width).IsPixels ? row ? own.y : own.x : across;
                var start = align == Align.Center ? (across - length) / 2 : 0;
                Place(children[i], row ? new Rect(at + margin, inside.y + start + margin, sizes[i] - 2 * margin, length - 2 * margin) : new Rect(inside.x + start + margin, at + margin, length - 2 * margin, sizes[i] - 2 * margin));
                at += sizes[i];
            }
        }

        void Paint(VisualElement one, float x, float y, float opacity)
        {
            if (IsGone(one) || !one.visible) return;
            x += one.layout.x;
            y += one.layout.y;
            opacity *= one.style.opacity.value * (one.enabledSelf ? 1f : 0.5f);
            var at = new Rect(x, y, one.layout.width, one.layout.height);
            var clip = canvas.Clip;
            Color Faint(Color color) => new Color(color.r, color.g, color.b, color.a * opacity);
            var background = one.resolvedStyle.backgroundColor;
            if (background.a > 0) canvas.Fill(at, Faint(background));
            if (one is Button) canvas.Box(at, Faint(button), Faint(Grey(36)));
            if (one is ListView list)
            {
                canvas.Box(at, Faint(Grey(48)), Faint(edge), 2);
                if (list.selectedIndex >= 0) canvas.Fill(new Rect(x + 1, y + 1 + list.selectedIndex * list.fixedItemHeight, at.width - 2, list.fixedItemHeight), Faint(chosen));
            }
            if (one is HelpBox) canvas.Box(at, Faint(box), Faint(edge));
            if (one is ProgressBar bar)
            {
                canvas.Box(at, Faint(input), Faint(edge), 2);
                canvas.Fill(new Rect(x + 1, y + 1, (at.width - 2) * (bar.value - bar.lowValue) / (bar.highValue - bar.lowValue), at.height - 2), Faint(chosen));
                Write(bar.title ?? "", at, TextAnchor.MiddleCenter, Faint(ink), false);
            }
            if (IsField(one)) Field(one, at, Faint);
            Drawn(one, at, opacity);
            if (one is Image image && image.image is Texture2D picture)
            {
                var texels = picture.GetPixels();
                canvas.Image(at, picture.width, picture.height, (column, row) => Faint(texels[row * picture.width + column]));
            }
            var text = TextOf(one);
            if (text != "")
            {
                var (left, top, right, bottom) = Padding(one);
                var anchor = one is Button ? TextAnchor.MiddleCenter : one.style.unityTextAlign.keyword == StyleKeyword.Undefined ? one.style.unityTextAlign.value : TextAnchor.UpperLeft;
                if (one is HelpBox) left = 40;
                var inside = new Rect(x + left, y + top + (one is HelpBox ? 4 : 0), at.width - left - right, at.height - top - bottom);
                Write(text, inside, anchor, Faint(one.resolvedStyle.color), IsBold(one), one is HelpBox || one.style.whiteSpace.value == WhiteSpace.Normal);
            }
            if (one is ScrollView || one is ListView || one.style.overflow.value == Overflow.Hidden) canvas.Clip = Within(clip, at);
            foreach (var child in one.hierarchy.Children()) Paint(child, x, y, opacity);
            canvas.Clip = clip;
        }

        static Rect Within(Rect a, Rect b)
        {
            float left = Mathf.Max(a.xMin, b.xMin), top = Mathf.Max(a.yMin, b.yMin);
            return new Rect(left, top, Mathf.Max(0, Mathf.Min(a.xMax, b.xMax) - left), Mathf.Max(0, Mathf.Min(a.yMax, b.yMax) - top));
        }

        /// A field's label, and its value as the kind of field shows it.
        void Field(VisualElement one, Rect at, Func<Color, Color> faint)
        {
            var label = LabelOf(one);
            var named = string.IsNullOrEmpty(label.text) ? 0 : Mathf.Max(Px(label.style.minWidth, LabelWidth), Canvas.TextWidth(label.text, FontSize, false) + 8);
            if (named > 0) Write(label.text, new Rect(at.x, at.y, named, at.height), TextAnchor.MiddleLeft, faint(ink), false);
            if (one.hierarchy.childCount > 0) return;
            var rect = new Rect(at.x + named, at.y, at.width - named, Mathf.Min(at.height, 18));
            var value = one.GetType().GetProperty("value").GetValue(one);
            if (one is Toggle toggle)
            {
                canvas.Box(new Rect(rect.x, rect.y + 2, 14, 14), faint(input), faint(edge), 2);
                if (toggle.value) canvas.Line(new[] { new Vector2(rect.x + 3, rect.y + 9), new Vector2(rect.x + 6, rect.y + 12), new Vector2(rect.x + 11, rect.y + 5) }, faint(ink), 1.6f);
                Write(toggle.text ?? "", new Rect(rect.x + 19, rect.y, rect.width - 19, rect.height), TextAnchor.MiddleLeft, faint(ink), false);
                return;
            }
            if (one is Slider slider)
            {
                canvas.Fill(new Rect(rect.x, rect.y + 8, rect.width, 2), faint(Grey(94)));
                var part = (slider.value - slider.lowValue) / (slider.highValue - slider.lowValue);
                canvas.Fill(new Rect(rect.x + part * (rect.width - 10), rect.y + 4, 10, 10), faint(Grey(153)), 5);
                return;
            }
            var isChoice = value is Enum || one.GetType().Name.StartsWith("Dropdown", StringComparison.Ordinal) || one.GetType().Name.StartsWith("Popup", StringComparison.Ordinal);
            canvas.Box(rect, faint(isChoice ? button : input), faint(edge));
            if (value is Color color) { canvas.Fill(new Rect(rect.x + 1, rect.y + 1, rect.width - 2, rect.height - 2), faint(new Color(color.r, color.g, color.b))); return; }
            var text = value is UnityEngine.Object made ? made != null ? made.name : "None" : value is IFormattable number ? number.ToString(null, System.Globalization.CultureInfo.InvariantCulture) : value?.ToString() ?? "None";
            Write(text, new Rect(rect.x + 4, rect.y, rect.width - 6, rect.height), TextAnchor.MiddleLeft, faint(ink), false);
        }

        void Write(string text, Rect at, TextAnchor anchor, Color color, bool isBold, bool wraps = false)
        {
            var clip = canvas.Clip;
            canvas.Clip = Within(clip, new Rect(at.x, at.y - 2, at.width + 1, at.height + 4));
            var lines = wraps ? Canvas.Wrapped(text, FontSize, isBold, at.width + 1) : text.Split('\n').ToList();
            var row = (int)anchor / 3;
            var y = row == 0 ? at.y : row == 1 ? at.y + (at.height - lines.Count * LineHeight) / 2 : at.yMax - lines.Count * LineHeight;
            foreach (var line in lines)
            {
                var spare = at.width - Canvas.TextWidth(line, FontSize, isBold);
                canvas.Text(line, new Vector2(at.x + Mathf.Max(0, spare) * ((int)anchor % 3) / 2, y + 12), FontSize, color, isBold);
                y += LineHeight;
            }
            canvas.Clip = clip;
        }

        /// What an element draws by itself, at the size that it has here.
        void Drawn(VisualElement one, Rect at, float opacity)
        {
            if (one.generateVisualContent == null) return;
            var context = new MeshGenerationContext(one);
            one.generateVisualContent(context);
            context.Finish();
            foreach (var shape in context.shapes)
            {
                var points = shape.Points.Select(point => point + at.position).ToList();
                var color = new Color(shape.Color.r, shape.Color.g, shape.Color.b, shape.Color.a * opacity);
                if (shape.Vertices.Length == 0 && shape.IsFilled) canvas.Fill(new[] { points }, color);
                else if (shape.Vertices.Length == 0) canvas.Line(points, color, shape.Width);
                for (var i = 0; i + 2 < shape.Indices.Length; i += 3)
                {
                    var corners = Enumerable.Range(i, 3).Select(n => shape.Vertices[shape.Indices[n]]).ToArray();
                    canvas.Triangle(corners.Select(corner => new Vector2(corner.position.x, corner.position.y) + at.position).ToArray(),
                        corners.Select(corner => { Color tint = corner.tint; tint.a *= opacity; return tint; }).ToArray());
                }
            }
        }
    }
}
