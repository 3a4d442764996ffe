using System;
using System.Globalization;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>The numbers of the knot and the colour that are chosen, to be typed.</summary>
    sealed class PointRow : VisualElement
    {
        readonly TransferFunctionModel model;
        readonly OpacityGraph graph;
        readonly ColorStrip strip;
        readonly DoubleField knotValue, knotOpacity, stopValue;
        readonly Toggle eases = new Toggle("Ease") { name = "knot-ease", tooltip = "Whether the curve leaves this knot slowly and arrives at the next slowly." };
        readonly VisualElement knot = new VisualElement { name = "knot" }, stop = new VisualElement { name = "stop" };
        readonly Label none = new Label("Choose a knot or a colour to type its numbers.") { name = "none" };
        readonly Button removeKnot, removeStop;
        public readonly ColorMixer mixer = new ColorMixer { name = "mixer" };

        /// An edit by its name: begins, changes the model, ends.
        public Action<string, Action> Edit;

        public PointRow(TransferFunctionModel model, OpacityGraph graph, ColorStrip strip)
        {
            (this.model, this.graph, this.strip) = (model, graph, strip);
            name = "points";
            style.minHeight = 22;
            none.style.opacity = 0.6f;
            knotValue = Number("knot-value", "Knot at", "The value in the scan's unit.");
            knotOpacity = Number("knot-opacity", "Opacity", "0 is not seen at all, 1 is solid.");
            stopValue = Number("stop-value", "Colour at", "The value in the scan's unit.");
            removeKnot = Remover("remove-knot", "Remove this knot (Delete).", graph.RemoveSelected);
            removeStop = Remover("remove-stop", "Remove this colour (Delete).", strip.RemoveSelected);
            eases.labelElement.style.minWidth = 0;
            foreach (var one in new VisualElement[] { knotValue, knotOpacity, eases, removeKnot }) knot.Add(one);
            foreach (var one in new VisualElement[] { stopValue, mixer, removeStop }) stop.Add(one);
            knot.style.flexDirection = stop.style.flexDirection = FlexDirection.Row;
            knot.style.alignItems = stop.style.alignItems = Align.Center;
            stop.style.flexWrap = Wrap.Wrap;
            Add(none);
            Add(knot);
            Add(stop);
            knotValue.RegisterValueChangedCallback(e => Type(e, "Move Knot", graph.Selected, i => model.MoveKnot(i, e.newValue, model.Knots[i].opacity)));
            knotOpacity.RegisterValueChangedCallback(e => Type(e, "Move Knot", graph.Selected, i => model.MoveKnot(i, model.Shown(model.Knots[i].value), e.newValue)));
            stopValue.RegisterValueChangedCallback(e => Type(e, "Move Colour", strip.Selected, i => model.MoveStop(i, e.newValue)));
            eases.RegisterValueChangedCallback(e =>
            {
                e.StopPropagation();
                if (graph.Selected >= 0) graph.SetEase(graph.Selected, e.newValue);
            });
            mixer.Changed += strip.SetColor;
            Refresh();
        }

        public void Refresh()
        {
            var (k, s) = (graph.Selected, strip.Selected);
            if (k >= model.Knots.Count) k = -1;
            if (s >= model.Stops.Count) s = -1;
            none.style.display = k < 0 && s < 0 && !model.IsEmpty ? DisplayStyle.Flex : DisplayStyle.None;
            knot.style.display = k >= 0 ? DisplayStyle.Flex : DisplayStyle.None;
            stop.style.display = s >= 0 ? DisplayStyle.Flex : DisplayStyle.None;
            if (k >= 0)
            {
                knotValue.SetValueWithoutNotify(Rounded(model.Shown(model.Knots[k].value)));
                knotOpacity.SetValueWithoutNotify(Rounded(model.Knots[k].opacity));
                eases.SetValueWithoutNotify(model.Knots[k].eases);
                eases.SetEnabled(k + 1 < model.Knots.Count);
                removeKnot.SetEnabled(model.Knots.Count > 1);
            }
            if (s < 0) return;
            stopValue.SetValueWithoutNotify(Rounded(model.Shown(model.Stops[s].value)));
            mixer.Show(model.Stops[s].color);
            removeStop.SetEnabled(model.Stops.Count > 1);
        }

        void Type(ChangeEvent<double> e, string name, int index, Action<int> edit)
        {
            e.StopPropagation();
            if (index >= 0) Edit?.Invoke(name, () => edit(index));
            Refresh();
        }

        /// As many digits as single precision has; it is what is kept.
        internal static double Rounded(double value) => double.Parse(value.ToString("G6", CultureInfo.InvariantCulture), CultureInfo.InvariantCulture);

        static DoubleField Number(string name, string title, string tooltip)
        {
            var field = new DoubleField(title) { name = name, tooltip = tooltip, isDelayed = true };
            field.style.width = 150;
            field.labelElement.style.minWidth = 0;
            field.labelElement.style.width = 62;
            return field;
        }

        static Button Remover(string name, string tooltip, Action action) => new Button(action) { name = name, text = "Remove", tooltip = tooltip };
    }
}
