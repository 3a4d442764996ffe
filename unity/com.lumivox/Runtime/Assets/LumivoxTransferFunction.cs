using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>
    /// Opacity and colour of a scan's physical values (Hounsfield units for CT), so that it means the same on every scan.
    /// </summary>
    /// <remarks>
    /// Opacity knots and colours are apart: one shapes what is seen, the other how it is painted. Before the first and
    /// after the last point the end's value holds; at two points of the same value the curve jumps. Without knots nothing
    /// is seen, without colours it is white; points that are not finite are passed over. Rows for gradients make it a
    /// function of value and gradient. Every change raises
    /// <see cref="changed"/>, and what is on screen follows.
    /// </remarks>
    [CreateAssetMenu(menuName = "Lumivox/Transfer Function", fileName = "Transfer Function", order = 310)]
    public sealed unsafe class LumivoxTransferFunction : ScriptableObject
    {
        /// <summary>Narrowest and widest <see cref="windowScale"/>.</summary>
        public const float NarrowestWindow = 0.01f, WidestWindow = 100f;

        /// <summary>How an opacity curve leaves a knot towards the next.</summary>
        public enum Ease
        {
            /// <summary>Along a straight line.</summary>
            Linear = 0,
            /// <summary>Slowly at both ends.</summary>
            InOut = 1,
        }

        /// <summary>A point of the opacity curve.</summary>
        [Serializable]
        public struct OpacityKnot
        {
            /// <summary>In the scan's unit (HU for CT).</summary>
            [Tooltip("The value in the scan's unit (HU for CT).")]
            public float value;
            /// <summary>0 to 1.</summary>
            [Tooltip("Opacity of that value."), Range(0f, 1f)]
            public float opacity;
            /// <summary>How the curve leaves towards the next knot.</summary>
            [Tooltip("How the curve leaves towards the next knot: straight, or slowly at both ends.")]
            public Ease ease;

            /// <summary>A knot.</summary>
            public OpacityKnot(float value, float opacity, Ease ease = Ease.Linear)
            {
                this.value = value;
                this.opacity = opacity;
                this.ease = ease;
            }
        }

        /// <summary>A point of the colour ramp.</summary>
        [Serializable]
        public struct ColorStop
        {
            /// <summary>In the scan's unit (HU for CT).</summary>
            [Tooltip("The value in the scan's unit (HU for CT).")]
            public float value;
            /// <summary>Its colour; alpha is not used. Between colours light is mixed linearly.</summary>
            [Tooltip("Colour of that value. Between colours light is mixed linearly."), ColorUsage(false)]
            public Color color;

            /// <summary>A stop.</summary>
            public ColorStop(float value, Color color)
            {
                this.value = value;
                this.color = color;
            }
        }

        /// <summary>What holds where values change steeply: a row of a function of value and gradient.</summary>
        [Serializable]
        public struct GradientRow : IEquatable<GradientRow>
        {
            /// <summary>How much values change per millimetre there, in their unit (HU for CT); above 0.</summary>
            [Tooltip("How much values change per millimetre where this holds, in their unit (HU for CT).")]
            public float perMm;
            /// <summary>The points of the opacity curve there.</summary>
            [Tooltip("Points of the opacity curve there.")]
            public List<OpacityKnot> opacityKnots;
            /// <summary>The colours there.</summary>
            [Tooltip("Colours of values there.")]
            public List<ColorStop> colorStops;

            /// <summary>A row; its points are sorted by value.</summary>
            public GradientRow(float perMm, IEnumerable<OpacityKnot> knots, IEnumerable<ColorStop> stops)
            {
                this.perMm = perMm;
                opacityKnots = knots != null ? new List<OpacityKnot>(knots) : new List<OpacityKnot>();
                colorStops = stops != null ? new List<ColorStop>(stops) : new List<ColorStop>();
            }

            /// <summary>Whether another says the same.</summary>
            public bool Equals(GradientRow other) => perMm.Equals(other.perMm) && Same(opacityKnots, other.opacityKnots) && Same(colorStops, other.colorStops);

            /// <inheritdoc/>
            public override bool Equals(object other) => other is GradientRow row && Equals(row);

            /// <inheritdoc/>
            public override int GetHashCode() => perMm.GetHashCode();

            static bool Same<T>(List<T> a, List<T> b) where T : struct
            {
                if (a == null || b == null) return (a?.Count ?? 0) == (b?.Count ?? 0);
                if (a.Count != b.Count) return false;
                for (var i = 0; i < a.Count; i++)
                    if (!EqualityComparer<T>.Default.Equals(a[i], b[i])) return false;
                return true;
            }
        }

        /// <summary>Rows for gradients at most.</summary>
        public const int MostGradients = 32;

        [SerializeField, Tooltip("Points of the opacity curve, kept sorted by value.")]
        List<OpacityKnot> m_OpacityKnots = new List<OpacityKnot>();
        [SerializeField, Tooltip("Colours of values, kept sorted by value.")]
        List<ColorStop> m_ColorStops = new List<ColorStop>();
        [SerializeField, Tooltip("Moves the whole function along the values, in their unit (HU for CT).")]
        float m_Shift;
        [SerializeField, Tooltip("Widens (above 1) or narrows (below 1) the whole function about its centre."), Min(NarrowestWindow)]
        float m_WindowScale = 1f;
        [SerializeField, Tooltip("What holds where values change steeply, which makes it a function of value and gradient: between rows it goes straight from one to the next, beyond the last that holds. What stands outside of the rows is for where values do not change.")]
        List<GradientRow> m_Gradients = new List<GradientRow>();

        TransferFunctionHandle handle;

        /// <summary>Something in it is another: points, shift or scale.</summary>
        public event Action changed;

        /// <summary>The points of the opacity curve, sorted by value.</summary>
        public IReadOnlyList<OpacityKnot> opacityKnots => m_OpacityKnots;

        /// <summary>The colours, sorted by value.</summary>
        public IReadOnlyList<ColorStop> colorStops => m_ColorStops;

        /// <summary>What holds where values change steeply, by rising gradient; empty for a function of the value alone.</summary>
        public IReadOnlyList<GradientRow> gradients => m_Gradients;

        /// <summary>Moves the whole function along the values, in their unit (HU for CT).</summary>
        public float shift
        {
            get => m_Shift;
            set
            {
                MainThread.Need("LumivoxTransferFunction.shift");
                if (!Numbers.Takes("LumivoxTransferFunction.shift", Numbers.IsFinite(value), this)) return;
                m_Shift = value;
                Touch();
            }
        }

        /// <summary>Widens (above 1) or narrows (below 1) the whole function about its centre: a factor, 0.01 to 100.</summary>
        public float windowScale
        {
            get => m_WindowScale;
            set
            {
                MainThread.Need("LumivoxTransferFunction.windowScale");
                if (!Numbers.Takes("LumivoxTransferFunction.windowScale", Numbers.IsFinite(value), this)) return;
                m_WindowScale = Mathf.Clamp(value, NarrowestWindow, WidestWindow);
                Touch();
            }
        }

        /// <summary>Replaces all points at once, with a single <see cref="changed"/>; null leaves a list as it is.</summary>
        public void SetPoints(IEnumerable<OpacityKnot> knots, IEnumerable<ColorStop> stops)
        {
            // What a frame has of it would go while it is drawn.
            MainThread.Need("LumivoxTransferFunction.SetPoints");
            if (knots != null)
            {
                var list = new List<OpacityKnot>(knots);
                m_OpacityKnots = list;
            }
            if (stops != null)
            {
                var list = new List<ColorStop>(stops);
                m_ColorStops = list;
            }
            Sort();
            Touch();
        }

        /// <summary>
        /// Replaces all rows for gradients, at most <see cref="MostGradients"/>; null or none leaves a function of the value
        /// alone. Rows whose gradient is no number above 0 say nothing.
        /// </summary>
        public void SetGradients(IEnumerable<GradientRow> rows)
        {
            var list = rows != null ? new List<GradientRow>(rows) : new List<GradientRow>();
            if (list.Count > MostGradients) throw new LumivoxException($"A transfer function has at most {MostGradients} rows for gradients, not {list.Count}.");
            m_Gradients = Copies(list);
            Sort();
            Touch();
        }

        /// <summary>Takes over what another one is.</summary>
        public void CopyFrom(LumivoxTransferFunction other)
        {
            if (other == null) throw new LumivoxException("There is no transfer function to copy: it is null.");
            MainThread.Need("LumivoxTransferFunction.CopyFrom");
            m_Shift = other.m_Shift;
            m_WindowScale = other.m_WindowScale;
            m_Gradients = Copies(other.m_Gradients);
            SetPoints(other.m_OpacityKnots, other.m_ColorStops);
        }

        /// <summary>The opacity, 0 to 1, of a value in the scan's unit, with shift and scale applied.</summary>
        public float GetOpacity(float value) => At(value).w;

        /// <summary>The colour of a value in the scan's unit, with shift and scale applied.</summary>
        public Color GetColor(float value)
        {
            var light = At(value);
            return new Color(light.x, light.y, light.z, 1f).gamma;
        }

        /// <summary>Linear RGB and opacity at as many values, evenly from low to high, as the array holds.</summary>
        public void Sample(float low, float high, Vector4[] into)
        {
            if (into == null) throw new LumivoxException("There is no array to sample into: it is null.");
            if (into.Length == 0) return;
            Border.Need();
            fixed (Vector4* rgba = into)
                Border.Checked(Library.lumivox_transfer_function_sample(Pointer, low, high, (uint)into.Length, (float*)rgba));
        }

        /// <summary>Writes it as a Lumivox transfer function file (JSON), which the other Lumivox programs read too, with shift and scale applied.</summary>
        /// <exception cref="LumivoxException">It cannot be written.</exception>
        public void SaveFile(string path)
        {
            Border.Need();
            fixed (byte* utf8 = Border.Utf8(path)) Border.Checked(Library.lumivox_transfer_function_save(Pointer, utf8));
        }

        /// <summary>Reads a transfer function of Lumivox's or of UnityVolumeRendering's making.</summary>
        /// <exception cref="LumivoxException">It cannot be read.</exception>
        public static LumivoxTransferFunction LoadFile(string path)
        {
            Border.Need();
            fixed (byte* utf8 = Border.Utf8(path))
                using (var loaded = new TransferFunctionHandle(Border.Checked(Library.lumivox_transfer_function_load(utf8))))
                    return Of(loaded);
        }

        static string[] presetNames;

        /// <summary>The names of all presets.</summary>
        public static IReadOnlyList<string> PresetNames
        {
            get
            {
                if (presetNames != null) return presetNames;
                Border.Need();
                var names = new string[Library.lumivox_preset_count()];
                for (uint i = 0; i < names.Length; i++) names[i] = Border.Text(Library.lumivox_preset_name(i));
                return presetNames = names;
            }
        }

        /// <summary>What a preset is for; empty where there is none of that name.</summary>
        public static string PresetDescription(string name)
        {
            for (var i = 0; i < PresetNames.Count; i++)
                if (PresetNames[i] == name) return Border.Text(Library.lumivox_preset_description((uint)i));
            return "";
        }

        /// <summary>The name of the preset that suits a scan.</summary>
        /// <exception cref="LumivoxException">The scan is not there.</exception>
        public static string PresetFor(LumivoxVolumeAsset volume)
        {
            Border.Need();
            var pointer = volume != null ? volume.Pointer : IntPtr.Zero;
            if (pointer == IntPtr.Zero) throw new LumivoxException("No preset can be told to suit a scan that is not open yet.");
            return Border.Text(Border.Checked(Library.lumivox_preset_for(pointer)));
        }

        /// <summary>
        /// The transfer function of a preset (see <see cref="PresetNames"/>). Presets for MR place themselves by the values
        /// of the volume; those for CT need none.
        /// </summary>
        /// <exception cref="LumivoxException">There is no such preset, or it needs a volume.</exception>
        public static LumivoxTransferFunction Preset(string name, LumivoxVolumeAsset volume = null) =>
            Preset(name, volume, out _);

        internal static LumivoxTransferFunction Preset(string name, LumivoxVolumeAsset volume, out Medium medium)
        {
            Border.Need();
            Medium look;
            var scan = volume != null ? volume.Pointer : IntPtr.Zero;
            fixed (byte* utf8 = Border.Utf8(name ?? ""))
                using (var made = new TransferFunctionHandle(Border.Checked(Library.lumivox_preset(utf8, scan, &look))))
                {
                    medium = look;
                    var function = Of(made);
                    function.name = name;
                    return function;
                }
        }

        /// <summary>For the native library; null where there is none.</summary>
        internal IntPtr Pointer => Handle.Pointer;

        /// <summary>For the native library: another one after each change.</summary>
        internal TransferFunctionHandle Handle => handle ?? (handle = Build());

        /// <summary>Whether there is nothing that gives opacity.</summary>
        internal bool IsWithoutKnots => m_OpacityKnots.Count == 0;

        static LumivoxTransferFunction Of(TransferFunctionHandle made) => Of(made.Pointer);

        /// <summary>What the library has, which stays whose it is.</summary>
        internal static LumivoxTransferFunction Of(IntPtr made)
        {
            var function = CreateInstance<LumivoxTransferFunction>();
            Read(made, function.m_OpacityKnots, function.m_ColorStops);
            var rows = Library.lumivox_transfer_function_gradient_count(made);
            for (uint i = 0; i < rows; i++)
            {
                double perMm;
                using (var row = new TransferFunctionHandle(Border.Checked(Library.lumivox_transfer_function_gradient(made, i, &perMm))))
                {
                    var read = new GradientRow((float)perMm, null, null);
                    Read(row.Pointer, read.opacityKnots, read.colorStops);
                    function.m_Gradients.Add(read);
                }
            }
            return function;
        }

        static void Read(IntPtr made, List<OpacityKnot> opacityKnots, List<ColorStop> colorStops)
        {
            var knots = new Native.OpacityKnot[Library.lumivox_transfer_function_knots(made, null, 0)];
            fixed (Native.OpacityKnot* to = knots) Library.lumivox_transfer_function_knots(made, to, (uint)knots.Length);
            var stops = new Native.ColorStop[Library.lumivox_transfer_function_stops(made, null, 0)];
            fixed (Native.ColorStop* to = stops) Library.lumivox_transfer_function_stops(made, to, (uint)stops.Length);
            foreach (var knot in knots)
                opacityKnots.Add(new OpacityKnot((float)knot.value, (float)knot.opacity, knot.ease == 1 ? Ease.InOut : Ease.Linear));
            foreach (var stop in stops)
                colorStops.Add(new ColorStop((float)stop.value, new Color((float)stop.red, (float)stop.green, (float)stop.blue, 1f).gamma));
        }

        TransferFunctionHandle Build()
        {
            Native.OpacityKnot[] knots = Knots(m_OpacityKnots);
            Native.ColorStop[] stops = Stops(m_ColorStops);
            TransferFunctionHandle made;
            fixed (Native.OpacityKnot* knot = knots)
            fixed (Native.ColorStop* stop = stops)
                made = new TransferFunctionHandle(Border.Checked(Library.lumivox_transfer_function_new(knot, (uint)knots.Length, stop, (uint)stops.Length, m_Shift, m_WindowScale)));
            foreach (var row in m_Gradients)
            {
                // The inspector adds rows that say nothing yet.
                if (!(row.perMm > 0f && row.perMm < 1e12f)) continue;
                (knots, stops) = (Knots(row.opacityKnots), Stops(row.colorStops));
                fixed (Native.OpacityKnot* knot = knots)
                fixed (Native.ColorStop* stop = stops)
                    Border.Checked(Library.lumivox_transfer_function_add_gradient(made.Pointer, row.perMm, knot, (uint)knots.Length, stop, (uint)stops.Length));
            }
            return made;
        }

        static Native.OpacityKnot[] Knots(List<OpacityKnot> of)
        {
            var knots = new Native.OpacityKnot[of?.Count ?? 0];
            for (var i = 0; i < knots.Length; i++)
            {
                var knot = of[i];
                knots[i] = new Native.OpacityKnot { value = knot.value, opacity = Mathf.Clamp01(knot.opacity), ease = (uint)knot.ease };
                // The library passes over what is not finite; to clamp must not hide it.
                if (!Numbers.IsFinite(knot.opacity)) knots[i].opacity = double.NaN;
            }
            return knots;
        }

        static Native.ColorStop[] Stops(List<ColorStop> of)
        {
            var stops = new Native.ColorStop[of?.Count ?? 0];
            for (var i = 0; i < stops.Length; i++)
            {
                var light = Numbers.Linear(of[i].color);
                stops[i] = new Native.ColorStop { value = of[i].value, red = light.x, green = light.y, blue = light.z };
            }
            return stops;
        }

        static List<GradientRow> Copies(List<GradientRow> rows)
        {
            var copies = new List<GradientRow>(rows.Count);
            foreach (var row in rows) copies.Add(new GradientRow(row.perMm, row.opacityKnots, row.colorStops));
            return copies;
        }

        Vector4 At(float value)
        {
            Border.Need();
            // Both ends are the value.
            var rgba = stackalloc float[8];
            Border.Checked(Library.lumivox_transfer_function_sample(Pointer, value, value, 2, rgba));
            return new Vector4(rgba[0], rgba[1], rgba[2], rgba[3]);
        }

        void Touch()
        {
            Free();
            changed?.Invoke();
            LumivoxRuntime.RequestFrames();
        }

        void Free()
        {
            handle?.Dispose();
            handle = null;
        }

        void Sort()
        {
            // Stable: of two points of the same value the order says which way the curve jumps.
            Sort(m_OpacityKnots, knot => knot.value);
            Sort(m_ColorStops, stop => stop.value);
            Sort(m_Gradients, row => row.perMm);
            foreach (var row in m_Gradients)
            {
                if (row.opacityKnots != null) Sort(row.opacityKnots, knot => knot.value);
                if (row.colorStops != null) Sort(row.colorStops, stop => stop.value);
            }
        }

        static void Sort<T>(List<T> points, Func<T, float> value)
        {
            for (var i = 1; i < points.Count; i++)
            {
                var point = points[i];
                var at = i;
                for (; at > 0 && value(points[at - 1]) > value(point); at--) points[at] = points[at - 1];
                points[at] = point;
            }
        }

        void OnValidate()
        {
            m_Shift = Numbers.IsFinite(m_Shift) ? m_Shift : 0f;
            m_WindowScale = Numbers.Within(m_WindowScale, NarrowestWindow, WidestWindow, 1f);
            if (m_Gradients.Count > MostGradients) m_Gradients.RemoveRange(MostGradients, m_Gradients.Count - MostGradients);
            Sort();
            Touch();
        }

        void OnDisable() => Free();
    }
}
