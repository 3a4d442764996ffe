using System;
using System.Collections.Generic;
using UnityEngine;

namespace Lumivox
{
    /// <summary>A point of the opacity curve.</summary>
    public struct OpacityPoint : IEquatable<OpacityPoint>
    {
        /// <summary>In the scan's unit.</summary>
        public double value;
        /// <summary>0 to 1.</summary>
        public double opacity;
        /// <summary>Whether the curve leaves it slowly and arrives slowly, instead of going straight.</summary>
        public bool eases;

        public OpacityPoint(double value, double opacity, bool eases = false)
        {
            this.value = value;
            this.opacity = opacity;
            this.eases = eases;
        }

        public bool Equals(OpacityPoint other) => value.Equals(other.value) && opacity.Equals(other.opacity) && eases == other.eases;
        public override bool Equals(object other) => other is OpacityPoint point && Equals(point);
        public override int GetHashCode() => value.GetHashCode() ^ opacity.GetHashCode();
    }

    /// <summary>A point of the colours.</summary>
    public struct ColorPoint : IEquatable<ColorPoint>
    {
        /// <summary>In the scan's unit.</summary>
        public double value;
        /// <summary>As it is picked (sRGB); alpha is not used.</summary>
        public Color color;

        public ColorPoint(double value, Color color)
        {
            this.value = value;
            this.color = color;
        }

        public bool Equals(ColorPoint other) => value.Equals(other.value) && color.Equals(other.color);
        public override bool Equals(object other) => other is ColorPoint point && Equals(point);
        public override int GetHashCode() => value.GetHashCode() ^ color.GetHashCode();
    }

    /// <summary>All that a transfer function is, at one time; it never changes. What undo keeps.</summary>
    public sealed class TransferFunctionState : IEquatable<TransferFunctionState>
    {
        readonly OpacityPoint[] knots;
        readonly ColorPoint[] stops;
        readonly LumivoxTransferFunction.GradientRow[] gradients;

        /// <summary>Points in any order; what is not finite is passed over. Rows for gradients are kept as they are.</summary>
        public TransferFunctionState(IEnumerable<OpacityPoint> knots, IEnumerable<ColorPoint> stops, double shift = 0, double windowScale = 1, IEnumerable<LumivoxTransferFunction.GradientRow> gradients = null)
        {
            // The function's own lists may change.
            var rows = new List<LumivoxTransferFunction.GradientRow>();
            if (gradients != null)
                foreach (var row in gradients) rows.Add(new LumivoxTransferFunction.GradientRow(row.perMm, row.opacityKnots, row.colorStops));
            this.gradients = rows.ToArray();
            this.knots = Sorted(knots, knot => knot.value, knot => IsFinite(knot.value) && IsFinite(knot.opacity));
            this.stops = Sorted(stops, stop => stop.value, stop => IsFinite(stop.value) && IsFinite(stop.color.r + stop.color.g + stop.color.b));
            for (var i = 0; i < this.knots.Length; i++) this.knots[i].opacity = Math.Min(Math.Max(this.knots[i].opacity, 0), 1);
            Shift = IsFinite(shift) ? shift : 0;
            WindowScale = IsFinite(windowScale) ? Math.Min(Math.Max(windowScale, TransferFunctionModel.NarrowestWindow), TransferFunctionModel.WidestWindow) : 1;
        }

        public IReadOnlyList<OpacityPoint> Knots => knots;
        public IReadOnlyList<ColorPoint> Stops => stops;
        public double Shift { get; }
        public double WindowScale { get; }

        /// <summary>What holds where values change steeply: not edited here, and not lost.</summary>
        public IReadOnlyList<LumivoxTransferFunction.GradientRow> Gradients => gradients;

        public bool Equals(TransferFunctionState other) =>
            other != null && SameGradients(other) && Shift.Equals(other.Shift) && WindowScale.Equals(other.WindowScale) && Same(knots, other.knots) && Same(stops, other.stops);
        public override bool Equals(object other) => Equals(other as TransferFunctionState);
        public override int GetHashCode() => knots.Length ^ stops.Length << 8 ^ Shift.GetHashCode() ^ WindowScale.GetHashCode();

        internal bool SameGradients(TransferFunctionState other)
        {
            if (gradients.Length != other.gradients.Length) return false;
            for (var i = 0; i < gradients.Length; i++)
                if (!gradients[i].Equals(other.gradients[i])) return false;
            return true;
        }

        internal static bool IsFinite(double number) => !double.IsNaN(number) && !double.IsInfinity(number);

        static bool Same<T>(T[] a, T[] b) where T : IEquatable<T>
        {
            if (a.Length != b.Length) return false;
            for (var i = 0; i < a.Length; i++)
                if (!a[i].Equals(b[i])) return false;
            return true;
        }

        /// Points of one value keep their order: there the curve jumps.
        static T[] Sorted<T>(IEnumerable<T> points, Func<T, double> value, Func<T, bool> isUsed)
        {
            var list = new List<T>();
            foreach (var point in points)
            {
                if (!isUsed(point)) continue;
                var at = list.Count;
                while (at > 0 && value(list[at - 1]) > value(point)) at--;
                list.Insert(at, point);
            }
            return list.ToArray();
        }
    }

    /// <summary>
    /// The points of a transfer function and the edits that people make to them; knows neither assets nor an interface.
    /// Opacity and colour are those of the library (<c>lumivox_transfer_function_sample</c>), which a test holds it to.
    /// </summary>
    public sealed class TransferFunctionModel
    {
        public const double NarrowestWindow = 0.01, WidestWindow = 100;
        /// <summary>Distance that stays between a dragged point and its neighbours, as a fraction of the values' range.</summary>
        public const double Gap = 1e-4;

        readonly List<OpacityPoint> knots = new List<OpacityPoint>();
        readonly List<ColorPoint> stops = new List<ColorPoint>();

        public IReadOnlyList<OpacityPoint> Knots => knots;
        public IReadOnlyList<ColorPoint> Stops => stops;
        /// <summary>Moves all values, in the scan's unit.</summary>
        public double Shift { get; private set; }
        /// <summary>Stretches all values about the middle of the points.</summary>
        public double WindowScale { get; private set; } = 1;
        /// <summary>Rows for gradients, which edits of points leave as they are.</summary>
        public IReadOnlyList<LumivoxTransferFunction.GradientRow> Gradients { get; private set; } = Array.Empty<LumivoxTransferFunction.GradientRow>();
        /// <summary>Whether there is nothing that gives opacity.</summary>
        public bool IsEmpty => knots.Count == 0;

        /// <summary>Everything as it is now, and as it shall be.</summary>
        public TransferFunctionState State
        {
            get => new TransferFunctionState(knots, stops, Shift, WindowScale, Gradients);
            set
            {
                knots.Clear();
                stops.Clear();
                knots.AddRange(value.Knots);
                stops.AddRange(value.Stops);
                Shift = value.Shift;
                WindowScale = value.WindowScale;
                Gradients = value.Gradients;
            }
        }

        /// <summary>Smallest and largest value of any point, before the window.</summary>
        public (double low, double high) StoredRange
        {
            get
            {
                if (knots.Count == 0 && stops.Count == 0) return (0, 1);
                double low = double.PositiveInfinity, high = double.NegativeInfinity;
                if (knots.Count > 0) (low, high) = (knots[0].value, knots[knots.Count - 1].value);
                // Without colours the library puts a white one at 0.
                var (first, last) = stops.Count > 0 ? (stops[0].value, stops[stops.Count - 1].value) : (0, 0);
                return (Math.Min(low, first), Math.Max(high, last));
            }
        }

        /// <summary>Smallest and largest value of any point as they are seen.</summary>
        public (double low, double high) ShownRange
        {
            get
            {
                var (low, high) = StoredRange;
                return (Shown(low), Shown(high));
            }
        }

        /// <summary>Where the window puts a stored value.</summary>
        public double Shown(double value)
        {
            var (low, high) = StoredRange;
            var middle = (low + high) / 2;
            return middle + (value - middle) * WindowScale + Shift;
        }

        double Stored(double shown)
        {
            var (low, high) = StoredRange;
            var middle = (low + high) / 2;
            return middle + (shown - Shift - middle) / WindowScale;
        }

        /// <summary>Opacity, 0 to 1, of a value in the scan's unit, through the window.</summary>
        public double OpacityAt(double value)
        {
            if (knots.Count == 0) return 0;
            value = Stored(value);
            var next = 0;
            while (next < knots.Count && knots[next].value <= value) next++;
            if (next == 0) return knots[0].opacity;
            var a = knots[next - 1];
            if (next == knots.Count) return a.opacity;
            var t = (value - a.value) / (knots[next].value - a.value);
            if (a.eases) t = t * t / (t * t + (1 - t) * (1 - t));
            return a.opacity + (knots[next].opacity - a.opacity) * t;
        }

        /// <summary>Colour (sRGB) of a value in the scan's unit, through the window; light is mixed linearly.</summary>
        public Color ColorAt(double value)
        {
            if (stops.Count == 0) return Color.white;
            value = Stored(value);
            var next = 0;
            while (next < stops.Count && stops[next].value <= value) next++;
            if (next == 0) return Opaque(stops[0].color);
            var a = stops[next - 1];
            if (next == stops.Count) return Opaque(a.color);
            var t = (float)((value - a.value) / (stops[next].value - a.value));
            return Opaque(Color.Lerp(a.color.linear, stops[next].color.linear, t).gamma);
        }

        static Color Opaque(Color color) => new Color(color.r, color.g, color.b, 1);

        /// <summary>The segment that holds a value as it is seen: the knot it starts at, or -1 outside.</summary>
        public int SegmentAt(double value)
        {
            value = Stored(value);
            for (var i = 0; i + 1 < knots.Count; i++)
                if (value >= knots[i].value && value < knots[i + 1].value) return i;
            return -1;
        }

        /// <summary>Writes the window into the points; nothing looks different. Points are edited as they are seen.</summary>
        public void BakeWindow()
        {
            if (Shift == 0 && WindowScale == 1) return;
            var (low, high) = StoredRange;
            var middle = (low + high) / 2;
            double Moved(double value) => middle + (value - middle) * WindowScale + Shift;
            for (var i = 0; i < knots.Count; i++) knots[i] = new OpacityPoint(Moved(knots[i].value), knots[i].opacity, knots[i].eases);
            for (var i = 0; i < stops.Count; i++) stops[i] = new ColorPoint(Moved(stops[i].value), stops[i].color);
            // Rows lie under the same window.
            var rows = new LumivoxTransferFunction.GradientRow[Gradients.Count];
            for (var i = 0; i < rows.Length; i++)
            {
                rows[i] = new LumivoxTransferFunction.GradientRow(Gradients[i].perMm, Gradients[i].opacityKnots, Gradients[i].colorStops);
                var (knotsThere, stopsThere) = (rows[i].opacityKnots, rows[i].colorStops);
                for (var k = 0; k < knotsThere.Count; k++) knotsThere[k] = new LumivoxTransferFunction.OpacityKnot((float)Moved(knotsThere[k].value), knotsThere[k].opacity, knotsThere[k].ease);
                for (var k = 0; k < stopsThere.Count; k++) stopsThere[k] = new LumivoxTransferFunction.ColorStop((float)Moved(stopsThere[k].value), stopsThere[k].color);
            }
            Gradients = rows;
            Shift = 0;
            WindowScale = 1;
        }

        /// <summary>Sets the window so that the points' middle and extent come to lie there.</summary>
        public void SetWindow(double middle, double width)
        {
            if (!TransferFunctionState.IsFinite(middle) || !TransferFunctionState.IsFinite(width)) return;
            var (low, high) = StoredRange;
            Shift = middle - (low + high) / 2;
            WindowScale = high > low ? Clamped(width / (high - low), NarrowestWindow, WidestWindow) : 1;
        }

        /// <summary>Shows the points where they are stored.</summary>
        public void ResetWindow()
        {
            Shift = 0;
            WindowScale = 1;
        }

        /// <summary>Adds a knot where it is seen and returns its index. It takes over the ease of the segment that it parts.</summary>
        public int AddKnot(double value, double opacity)
        {
            BakeWindow();
            var index = 0;
            while (index < knots.Count && knots[index].value <= value) index++;
            var eases = knots.Count > 0 && knots[Math.Max(index - 1, 0)].eases;
            knots.Insert(index, new OpacityPoint(value, Clamped(opacity, 0, 1), eases));
            if (stops.Count == 0) AddStop(value, Color.white);
            return index;
        }

        /// <summary>Moves a knot to where it is seen, between its neighbours.</summary>
        public void MoveKnot(int index, double value, double opacity)
        {
            if (!TransferFunctionState.IsFinite(value) || !TransferFunctionState.IsFinite(opacity)) return;
            BakeWindow();
            var low = index > 0 ? knots[index - 1].value + Distance : double.NegativeInfinity;
            var high = index + 1 < knots.Count ? knots[index + 1].value - Distance : double.PositiveInfinity;
            knots[index] = new OpacityPoint(Between(value, low, high), Clamped(opacity, 0, 1), knots[index].eases);
        }

        /// <summary>Removes a knot, unless it is the last. Returns whether it did.</summary>
        public bool RemoveKnot(int index)
        {
            if (knots.Count <= 1) return false;
            BakeWindow();
            knots.RemoveAt(index);
            return true;
        }

        /// <summary>How the curve goes from a knot to the next.</summary>
        public void SetEase(int index, bool eases) => knots[index] = new OpacityPoint(knots[index].value, knots[index].opacity, eases);

        /// <summary>How the curve goes from each knot to the next.</summary>
        public void SetEaseEverywhere(bool eases)
        {
            for (var i = 0; i < knots.Count; i++) SetEase(i, eases);
        }

        /// <summary>Adds a colour where it is seen and returns its index.</summary>
        public int AddStop(double value, Color color)
        {
            BakeWindow();
            var index = 0;
            while (index < stops.Count && stops[index].value <= value) index++;
            stops.Insert(index, new ColorPoint(value, Opaque(color)));
            return index;
        }

        /// <summary>Moves a colour to where it is seen, between its neighbours.</summary>
        public void MoveStop(int index, double value)
        {
            if (!TransferFunctionState.IsFinite(value)) return;
            BakeWindow();
            var low = index > 0 ? stops[index - 1].value + Distance : double.NegativeInfinity;
            var high = index + 1 < stops.Count ? stops[index + 1].value - Distance : double.PositiveInfinity;
            stops[index] = new ColorPoint(Between(value, low, high), stops[index].color);
        }

        /// <summary>Paints a colour stop.</summary>
        public void SetColor(int index, Color color) => stops[index] = new ColorPoint(stops[index].value, Opaque(color));

        /// <summary>Removes a colour, unless it is the last. Returns whether it did.</summary>
        public bool RemoveStop(int index)
        {
            if (stops.Count <= 1) return false;
            BakeWindow();
            stops.RemoveAt(index);
            return true;
        }

        double Distance
        {
            get
            {
                var (low, high) = StoredRange;
                return (high - low) * Gap;
            }
        }

        static double Clamped(double value, double low, double high) => Math.Min(Math.Max(value, low), high);

        /// Points that were loaded may lie closer than the gap.
        static double Between(double value, double low, double high) => low <= high ? Clamped(value, low, high) : (low + high) / 2;
    }
}
