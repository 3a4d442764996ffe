using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>
    /// The colours of a transfer function: a gradient with stops under it. A click chooses a stop, a drag moves it,
    /// a double click adds one, a right click or Delete removes it.
    /// </summary>
    public sealed class ColorStrip : ValueStrip
    {
        const float BarTop = 2, BarHeight = 16, Slack = 3;

        /// <summary>Another stop is the one that fields act on, or none.</summary>
        internal Action SelectionChanged;

        readonly List<float> columns = new List<float>();
        int selected = -1, pressed = -1;
        bool hasMoved;
        float pressedAt;

        internal ColorStrip(ValueAxis axis, TransferFunctionModel model) : base(axis, model)
        {
            name = "colors";
            focusable = true;
            style.height = 38;
            tooltip = "A click chooses a colour, a drag moves it, a double-click adds one, a right click or Delete removes it.";
            RegisterCallback<KeyDownEvent>(OnKey);
        }

        /// <summary>The stop that fields act on, or -1.</summary>
        public int Selected
        {
            get => selected;
            set
            {
                value = value < model.Stops.Count ? value : -1;
                if (selected == value) return;
                selected = value;
                SelectionChanged?.Invoke();
                MarkDirtyRepaint();
            }
        }

        protected override bool IsDragging => pressed >= 0;
        protected override int HandleCount => model.Stops.Count;
        protected override float DistanceTo(int handle, Vector2 at) => Math.Abs(PlaceOf(handle) - at.x);

        /// <summary>Where a stop is seen.</summary>
        internal float PlaceOf(int stop) => PixelOf(model.Shown(model.Stops[stop].value));

        internal override void Drop()
        {
            base.Drop();
            if (selected >= model.Stops.Count) Selected = -1;
        }

        /// <summary>Paints the stop that is chosen, as part of a series of edits.</summary>
        internal void SetColor(Color color)
        {
            if (selected >= 0) Do("Set Colour", () => model.SetColor(selected, color), "color " + selected);
        }

        /// <summary>Removes the stop that is chosen, unless it is the last.</summary>
        public void RemoveSelected()
        {
            if (selected >= 0) Remove(selected);
        }

        void Remove(int stop)
        {
            if (model.Stops.Count <= 1) return;
            Do("Remove Colour", () => model.RemoveStop(stop));
            Hover(-1);
            if (selected == stop) Selected = -1;
            else if (selected > stop) Selected = selected - 1;
        }

        protected override void Press(PointerDownEvent e, int handle)
        {
            if (e.button == 1)
            {
                if (handle >= 0) Remove(handle);
                return;
            }
            if (e.button != 0) return;
            Focus();
            if (handle < 0 && (e.clickCount == 2 || e.actionKey))
            {
                var value = ValueAt(e.localPosition.x);
                var color = model.ColorAt(value);
                Do("Add Colour", () => handle = model.AddStop(value, color));
            }
            Selected = handle;
            pressed = handle;
            pressedAt = e.localPosition.x;
            hasMoved = false;
            MarkDirtyRepaint();
        }

        protected override void Drag(PointerMoveEvent e)
        {
            if (!hasMoved && Math.Abs(e.localPosition.x - pressedAt) < Slack) return;
            hasMoved = true;
            Begin("Move Colour");
            model.MoveStop(pressed, ValueAt(e.localPosition.x));
            Edited?.Invoke();
            Hinted?.Invoke(axis.Text(model.Shown(model.Stops[pressed].value)));
        }

        protected override void Release() => pressed = -1;

        protected override void PointAt(Vector2 at)
        {
            var value = ValueAt(at.x);
            Hinted?.Invoke($"{axis.Text(value)}    #{ColorUtility.ToHtmlStringRGB(model.ColorAt(value))}");
        }

        void OnKey(KeyDownEvent e)
        {
            if (e.keyCode == KeyCode.Escape && GiveUp()) e.StopPropagation();
            if (e.keyCode != KeyCode.Delete && e.keyCode != KeyCode.Backspace || selected < 0) return;
            RemoveSelected();
            e.StopPropagation();
        }

        protected override void Draw(MeshGenerationContext context)
        {
            if (model.IsEmpty || contentRect.width <= 2 * Margin) return;
            var bar = new Rect(Margin, BarTop, contentRect.width - 2 * Margin, BarHeight);
            columns.Clear();
            // Colours mix in linear light: more samples than stops.
            for (var step = 0; step <= 64; step++) columns.Add(bar.xMin + bar.width * step / 64);
            foreach (var stop in model.Stops)
            {
                var x = PixelOf(model.Shown(stop.value));
                if (x > bar.xMin && x < bar.xMax) columns.Add(x);
            }
            columns.Sort();
            FillBand(context, columns.Count, i =>
            {
                var color = model.ColorAt(ValueAt(columns[i]));
                return (new Vector2(columns[i], bar.yMax), new Vector2(columns[i], bar.yMin), color, color);
            });
            for (var i = 0; i < model.Stops.Count; i++) DrawStop(context.painter2D, i, bar);
        }

        void DrawStop(Painter2D painter, int stop, Rect bar)
        {
            var x = PlaceOf(stop);
            if (x < bar.xMin - 1 || x > bar.xMax + 1) return;
            var isActive = stop == Hovered || stop == pressed || stop == selected;
            float half = isActive ? 6 : 5, top = bar.yMax - 1;
            var color = model.Stops[stop].color;
            painter.fillColor = new Color(color.r, color.g, color.b, 1);
            painter.strokeColor = isActive ? Accent() : Knob;
            painter.lineWidth = 1.4f;
            painter.BeginPath();
            painter.MoveTo(new Vector2(x, top));
            painter.LineTo(new Vector2(x + half, top + half));
            painter.LineTo(new Vector2(x + half, top + half * 2.6f));
            painter.LineTo(new Vector2(x - half, top + half * 2.6f));
            painter.LineTo(new Vector2(x - half, top + half));
            painter.ClosePath();
            painter.Fill();
            painter.Stroke();
        }
    }
}
