using System;
using System.Collections.Generic;

namespace Lumivox
{
    /// <summary>Between a transfer function and the editor's own points.</summary>
    public static class TransferFunctionAccess
    {
        /// <summary>All that a transfer function is now.</summary>
        public static TransferFunctionState GetState(this LumivoxTransferFunction function)
        {
            var knots = new List<OpacityPoint>(function.opacityKnots.Count);
            foreach (var knot in function.opacityKnots) knots.Add(new OpacityPoint(knot.value, knot.opacity, knot.ease == LumivoxTransferFunction.Ease.InOut));
            var stops = new List<ColorPoint>(function.colorStops.Count);
            foreach (var stop in function.colorStops) stops.Add(new ColorPoint(stop.value, stop.color));
            return new TransferFunctionState(knots, stops, function.shift, function.windowScale, function.gradients);
        }

        /// <summary>Makes a transfer function what it was, or shall be; only what differs is set.</summary>
        public static void SetState(this LumivoxTransferFunction function, TransferFunctionState state)
        {
            if (function == null) throw new ArgumentNullException(nameof(function));
            var now = function.GetState();
            if (!Same(now.Knots, state.Knots) || !Same(now.Stops, state.Stops))
            {
                var knots = new List<LumivoxTransferFunction.OpacityKnot>(state.Knots.Count);
                foreach (var knot in state.Knots)
                    knots.Add(new LumivoxTransferFunction.OpacityKnot((float)knot.value, (float)knot.opacity, knot.eases ? LumivoxTransferFunction.Ease.InOut : LumivoxTransferFunction.Ease.Linear));
                var stops = new List<LumivoxTransferFunction.ColorStop>(state.Stops.Count);
                foreach (var stop in state.Stops) stops.Add(new LumivoxTransferFunction.ColorStop((float)stop.value, stop.color));
                function.SetPoints(knots, stops);
            }
            if (!now.SameGradients(state)) function.SetGradients(state.Gradients);
            if (function.shift != (float)state.Shift) function.shift = (float)state.Shift;
            if (function.windowScale != (float)state.WindowScale) function.windowScale = (float)state.WindowScale;
        }

        /// Assets keep single precision.
        static bool Same(IReadOnlyList<OpacityPoint> a, IReadOnlyList<OpacityPoint> b)
        {
            if (a.Count != b.Count) return false;
            for (var i = 0; i < a.Count; i++)
                if ((float)a[i].value != (float)b[i].value || (float)a[i].opacity != (float)b[i].opacity || a[i].eases != b[i].eases) return false;
            return true;
        }

        static bool Same(IReadOnlyList<ColorPoint> a, IReadOnlyList<ColorPoint> b)
        {
            if (a.Count != b.Count) return false;
            for (var i = 0; i < a.Count; i++)
                if ((float)a[i].value != (float)b[i].value || a[i].color != b[i].color) return false;
            return true;
        }

        /// <summary>A preset's name as people read it: `ct-bone` becomes `CT bone`.</summary>
        public static string TitleOfPreset(string preset)
        {
            if (string.IsNullOrEmpty(preset)) return "";
            var words = preset.Split('-');
            words[0] = words[0].Length <= 3 ? words[0].ToUpperInvariant() : char.ToUpperInvariant(words[0][0]) + words[0].Substring(1);
            return string.Join(" ", words);
        }

        /// <summary>Whether a preset can be had: those that are not for CT place themselves by the values of a scan that is open.</summary>
        public static bool IsPresetAvailable(string preset, LumivoxVolumeAsset volume) =>
            preset.StartsWith("ct-", StringComparison.Ordinal) || volume != null && volume.state == LumivoxVolumeState.Ready;
    }
}
