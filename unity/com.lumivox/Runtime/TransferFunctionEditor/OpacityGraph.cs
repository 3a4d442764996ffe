using System;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>
    /// Opacity over physical values: the scan's histogram, the curve in its colours, and knots to drag.
    /// A double click adds a knot, Delete or a right click removes it, a right click on the curve changes its ease.
    /// </summary>
    public sealed partial class OpacityGraph : ValueStrip
    {
        const float Top = 10, Bottom = 20;

        /// <summary>Another knot is the one that keys and fields act on, or none.</summary>
        internal Action SelectionChanged;
        /// <summary>Keys that act on the whole editor.</summary>
        internal Action ShowAllAsked, ShowPointsAsked;

        int selected = -1, dragged = -1;
        Vector2 grabOffset;
        float emphasis = 1;

        internal OpacityGraph(ValueAxis axis, TransferFunctionModel model) : base(axis, model)
        {
            name = "opacity";
            focusable = true;
            style.minHeight = 110;
            style.flexGrow = 1;
            tooltip = "Double-click adds a knot, a right click removes one or changes a segment's ease.\n"
                + "The wheel zooms, the middle button pans. Keys: arrows move the knot (Shift: more), comma and full stop choose another, "
                + "E eases, Delete removes, F shows the points, A shows all, Escape gives up a drag.";
            RegisterCallback<KeyDownEvent>(OnKey);
            RegisterCallback<NavigationMoveEvent>(KeepFocus);
            RegisterCallback<FocusInEvent>(_ => MarkDirtyRepaint());
            RegisterCallback<FocusOutEvent>(_ => MarkDirtyRepaint());
            RegisterCallback<GeometryChangedEvent>(_ => PlaceTicks());
            axis.ViewChanged += PlaceTicks;
        }

        /// <summary>Opacities shown larger than they are, so that thin tissue can be edited: the height is opacity to the power of 1 / this.</summary>
        public float Emphasis
        {
            get => emphasis;
            set
            {
                emphasis = value;
                MarkDirtyRepaint();
            }
        }

        /// <summary>The knot that keys and fields act on, or -1.</summary>
        public int Selected
        {
            get => selected;
            set
            {
                value = value < model.Knots.Count ? value : -1;
                if (selected == value) return;
                selected = value;
                SelectionChanged?.Invoke();
                MarkDirtyRepaint();
            }
        }

        /// <summary>Whether there is something to edit; a function without points can be given some.</summary>
        internal bool HasFunction { get; set; }

        protected override bool IsUsable => HasFunction;
        protected override bool IsDragging => dragged >= 0;
        protected override int HandleCount => model.Knots.Count;
        protected override float DistanceTo(int handle, Vector2 at) => (PlaceOf(handle) - at).magnitude;

        Rect Plot => new Rect(Margin, Top, Math.Max(contentRect.width - 2 * Margin, 1), Math.Max(contentRect.height - Top - Bottom, 1));

        float HeightOf(double opacity) => Plot.yMax - (float)Math.Pow(opacity, 1 / emphasis) * Plot.height;

        double OpacityAt(float y) => Math.Pow(Math.Min(Math.Max((Plot.yMax - y) / Plot.height, 0), 1), emphasis);

        /// <summary>Where a knot is seen.</summary>
        internal Vector2 PlaceOf(int knot) => new Vector2(PixelOf(model.Shown(model.Knots[knot].value)), HeightOf(model.Knots[knot].opacity));

        internal override void Drop()
        {
            base.Drop();
            if (selected >= model.Knots.Count) Selected = -1;
        }

        /// <summary>Removes the knot that keys act on, unless it is the last.</summary>
        public void RemoveSelected()
        {
            if (selected >= 0) Remove(selected);
        }

        void Remove(int knot)
        {
            if (model.Knots.Count <= 1) return;
            Do("Remove Knot", () => model.RemoveKnot(knot));
            Hover(-1);
            // The one that was selected has another index now, or is no more.
            if (selected == knot) Selected = -1;
            else if (selected > knot) Selected = selected - 1;
        }

        internal void Add(double value, double opacity) => Do("Add Knot", () =>
        {
            Selected = model.AddKnot(value, opacity);
        });

        /// <summary>Whether the curve eases from a knot to the next.</summary>
        public void SetEase(int knot, bool eases) => Do("Set Ease", () => model.SetEase(knot, eases));

        protected override void Press(PointerDownEvent e, int handle)
        {
            Vector2 at = e.localPosition;
            if (e.button == 1)
            {
                if (handle >= 0) Remove(handle);
                else OpenMenu(at);
                return;
            }
            if (e.button != 0) return;
            Focus();
            if (handle < 0 && (e.clickCount == 2 || e.actionKey))
            {
                Begin("Add Knot");
                handle = model.AddKnot(ValueAt(at.x), OpacityAt(at.y));
                Edited?.Invoke();
            }
            if (handle >= 0)
            {
                dragged = handle;
                grabOffset = PlaceOf(handle) - at;
            }
            Selected = handle;
            MarkDirtyRepaint();
        }

        protected override void Drag(PointerMoveEvent e)
        {
            if (e.deltaPosition.x == 0 && e.deltaPosition.y == 0) return;
            Begin("Move Knot");
            var target = (Vector2)e.localPosition + grabOffset;
            var knot = model.Knots[dragged];
            // Shift keeps the value, Control the opacity.
            model.MoveKnot(dragged, e.shiftKey ? model.Shown(knot.value) : ValueAt(target.x), e.actionKey && !e.shiftKey ? knot.opacity : OpacityAt(target.y));
            Edited?.Invoke();
            Tell(dragged);
        }

        protected override void Release() => dragged = -1;

        protected override void PointAt(Vector2 at)
        {
            var value = ValueAt(at.x);
            Hinted?.Invoke($"{axis.Text(value)}    opacity {model.OpacityAt(value):0.000}");
        }

        void Tell(int knot) => Hinted?.Invoke($"{axis.Text(model.Shown(model.Knots[knot].value))}    opacity {model.Knots[knot].opacity:0.000}");

        void OnKey(KeyDownEvent e)
        {
            if (e.keyCode == KeyCode.Escape)
            {
                if (GiveUp() || selected >= 0) e.StopPropagation();
                if (!IsDragging) Selected = -1;
                return;
            }
            if (e.actionKey || e.altKey || IsDragging) return;
            double value = 0, opacity = 0;
            var by = axis.Width / 400 * (e.shiftKey ? 5 : 1);
            switch (e.keyCode)
            {
                case KeyCode.A: ShowAllAsked?.Invoke(); e.StopPropagation(); return;
                case KeyCode.F: ShowPointsAsked?.Invoke(); e.StopPropagation(); return;
                case KeyCode.Comma: Step(-1); e.StopPropagation(); return;
                case KeyCode.Period: Step(1); e.StopPropagation(); return;
            }
            if (selected < 0 || selected >= model.Knots.Count) return;
            switch (e.keyCode)
            {
                case KeyCode.Delete:
                case KeyCode.Backspace: RemoveSelected(); e.StopPropagation(); return;
                case KeyCode.E: SetEase(selected, !model.Knots[selected].eases); e.StopPropagation(); return;
                case KeyCode.LeftArrow: value = -by; break;
                case KeyCode.RightArrow: value = by; break;
                case KeyCode.UpArrow: opacity = e.shiftKey ? 0.05 : 0.01; break;
                case KeyCode.DownArrow: opacity = e.shiftKey ? -0.05 : -0.01; break;
                default: return;
            }
            e.StopPropagation();
            var knot = model.Knots[selected];
            Do("Move Knot", () => model.MoveKnot(selected, model.Shown(knot.value) + value, knot.opacity + opacity), "keys " + selected);
            Tell(selected);
        }

        void Step(int by)
        {
            if (model.Knots.Count == 0) return;
            Selected = selected < 0 ? by > 0 ? 0 : model.Knots.Count - 1 : (selected + by + model.Knots.Count) % model.Knots.Count;
            Tell(selected);
        }

        /// Arrow keys would take the focus to another element.
        void KeepFocus(NavigationMoveEvent e)
        {
            if (selected < 0 || e.direction == NavigationMoveEvent.Direction.Next || e.direction == NavigationMoveEvent.Direction.Previous) return;
            e.StopPropagation();
#if UNITY_6000_0_OR_NEWER
            focusController?.IgnoreEvent(e);
#else
            e.PreventDefault();
#endif
        }

        void OpenMenu(Vector2 at)
        {
            var value = ValueAt(at.x);
            var opacity = OpacityAt(at.y);
            var segment = model.SegmentAt(value);
            var menu = new GenericDropdownMenu();
            menu.AddItem("Add knot here", false, () => Add(value, opacity));
            menu.AddSeparator("");
            void Ease(string title, bool eases)
            {
                if (segment < 0) menu.AddDisabledItem(title, false);
                else menu.AddItem(title, model.Knots[segment].eases == eases, () => { if (segment < model.Knots.Count) SetEase(segment, eases); });
            }
            Ease("Straight segment", false);
            Ease("Ease in and out", true);
            menu.AddSeparator("");
            menu.AddItem("Straight everywhere", false, () => Do("Set Ease", () => model.SetEaseEverywhere(false)));
            menu.AddItem("Ease everywhere", false, () => Do("Set Ease", () => model.SetEaseEverywhere(true)));
            DropdownMenus.Open(menu, new Rect(this.LocalToWorld(at), Vector2.zero), this);
        }
    }
}
