using System;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>The window of a transfer function as a bar: drag it to shift all values, drag its ends to widen or narrow it.</summary>
    public sealed class WindowStrip : ValueStrip
    {
        enum Part { None = -1, Low, High, Body }

        Part pressed = Part.None;
        double startValue;
        (double low, double high) start;

        internal WindowStrip(ValueAxis axis, TransferFunctionModel model) : base(axis, model)
        {
            name = "window";
            focusable = true;
            style.height = 16;
            tooltip = "The window: drag to shift all values, drag an end to widen or narrow it, double-click to reset it.";
            RegisterCallback<KeyDownEvent>(e => { if (e.keyCode == KeyCode.Escape && GiveUp()) e.StopPropagation(); });
        }

        protected override bool IsDragging => pressed != Part.None;
        protected override int HandleCount => 2;
        protected override float DistanceTo(int handle, Vector2 at) => Math.Abs(at.x - PixelOf(handle == 0 ? model.ShownRange.low : model.ShownRange.high));

        protected override void Press(PointerDownEvent e, int handle)
        {
            if (e.button != 0) return;
            Focus();
            if (e.clickCount == 2)
            {
                if (model.Shift != 0 || model.WindowScale != 1) Do("Reset Window", model.ResetWindow);
                return;
            }
            start = model.ShownRange;
            startValue = ValueAt(e.localPosition.x);
            var isInside = startValue > start.low && startValue < start.high;
            pressed = handle >= 0 ? (Part)handle : isInside ? Part.Body : Part.None;
            MarkDirtyRepaint();
        }

        protected override void Drag(PointerMoveEvent e)
        {
            if (e.deltaPosition.x == 0) return;
            Begin("Set Window");
            var by = ValueAt(e.localPosition.x) - startValue;
            var (low, high) = start;
            var least = (axis.Full.high - axis.Full.low) * 1e-3;
            if (pressed != Part.High) low += by;
            if (pressed != Part.Low) high += by;
            if (pressed == Part.Low) low = Math.Min(low, high - least);
            if (pressed == Part.High) high = Math.Max(high, low + least);
            model.SetWindow((low + high) / 2, high - low);
            Edited?.Invoke();
            Hinted?.Invoke($"{axis.Text(low)} to {axis.Text(high)}");
        }

        protected override void Release() => pressed = Part.None;

        protected override void Draw(MeshGenerationContext context)
        {
            if (model.IsEmpty || contentRect.width <= 2 * Margin) return;
            var painter = context.painter2D;
            float left = Margin, right = contentRect.width - Margin, y = contentRect.height / 2;
            var (low, high) = (PixelOf(model.ShownRange.low), PixelOf(model.ShownRange.high));
            Line(painter, new Vector2(left, y), new Vector2(right, y), Ink(0.14f), 2);
            float from = Math.Min(Math.Max(low, left), right), to = Math.Min(Math.Max(high, left), right);
            Line(painter, new Vector2(from, y), new Vector2(to, y), Accent(Hovered >= 0 || IsDragging ? 1 : 0.75f), 4);
            foreach (var x in new[] { low, high })
                if (x >= left - 1 && x <= right + 1)
                    Fill(painter, new Rect(x - 2.5f, y - 6, 5, 12), Knob);
        }
    }
}
