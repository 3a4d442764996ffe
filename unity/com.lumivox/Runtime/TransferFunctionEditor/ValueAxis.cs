using System;
using System.Collections.Generic;
using System.Globalization;

namespace Lumivox
{
    /// <summary>The horizontal axis that the strips of the transfer-function editor share: physical values over pixels.</summary>
    public sealed class ValueAxis
    {
        /// Zooming in stops at this part of the full range.
        const double MaxZoom = 500;

        /// <summary>Another part of the values is shown.</summary>
        public event Action ViewChanged;
        /// <summary>All that can be shown: the scan's and the points' values.</summary>
        public (double low, double high) Full { get; private set; } = (0, 1);
        /// <summary>What is shown now.</summary>
        public (double low, double high) View { get; private set; } = (0, 1);
        /// <summary>The values' unit, such as HU; may be empty.</summary>
        public string Unit { get; set; } = "";

        public double Width => View.high - View.low;

        /// <summary>Shows all values.</summary>
        public void ShowAll() => Show(Full.low, Full.high);

        /// <summary>Sets what can be shown; keeps the view where it still makes sense.</summary>
        public void SetFull(double low, double high)
        {
            if (!(high > low)) (low, high) = (low - 0.5, low + 0.5);
            if (Full == (low, high)) return;
            var showedAll = View == Full;
            Full = (low, high);
            if (showedAll || View.high < low || View.low > high) ShowAll();
        }

        /// <summary>Shows these values, within limits.</summary>
        public void Show(double low, double high)
        {
            var extent = Full.high - Full.low;
            var half = Math.Min(Math.Max(high - low, extent / MaxZoom), extent * 2) / 2;
            var middle = Math.Min(Math.Max((low + high) / 2, Full.low), Full.high);
            if (View == (middle - half, middle + half)) return;
            View = (middle - half, middle + half);
            ViewChanged?.Invoke();
        }

        /// <summary>Zooms, keeping a value in its place.</summary>
        public void Zoom(double factor, double value) => Show(value + (View.low - value) / factor, value + (View.high - value) / factor);

        /// <summary>Moves the view by values.</summary>
        public void Pan(double by) => Show(View.low + by, View.high + by);

        /// <summary>The pixel of a value in an element of that width with margins at both sides.</summary>
        public float PixelOf(double value, float width, float margin) => (float)(margin + (value - View.low) / Width * (width - 2 * margin));

        /// <summary>The value at a pixel.</summary>
        public double ValueAt(float pixel, float width, float margin) => View.low + (pixel - margin) / Math.Max(width - 2 * margin, 1) * Width;

        /// <summary>Round values for ticks, at most about so many.</summary>
        public void Ticks(int count, List<double> ticks)
        {
            ticks.Clear();
            var rough = Width / Math.Max(count, 1);
            var decade = Math.Pow(10, Math.Floor(Math.Log10(rough)));
            var step = decade * (rough <= decade ? 1 : rough <= decade * 2 ? 2 : rough <= decade * 5 ? 5 : 10);
            for (var i = Math.Ceiling(View.low / step); i * step <= View.high; i++) ticks.Add(i * step);
        }

        /// <summary>A value as people read it, with as many decimals as the view needs.</summary>
        public string Text(double value, bool withUnit = true)
        {
            var decimals = Math.Min(Math.Max((int)Math.Ceiling(2 - Math.Log10(Width)), 0), 6);
            var number = Math.Round(value, decimals).ToString("0." + new string('#', decimals), CultureInfo.InvariantCulture);
            if (number == "-0") number = "0";
            number = number.Replace('-', '\u2212');
            return withUnit && Unit != "" ? number + " " + Unit : number;
        }
    }
}
