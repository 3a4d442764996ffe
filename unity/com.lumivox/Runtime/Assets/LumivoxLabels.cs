using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using System.Threading.Tasks;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>What the parts of a scan are, and how each looks: for <see cref="LumivoxVolume.labels"/>.</summary>
    /// <remarks>
    /// The labels themselves are a label map: a segmentation (DICOM SEG, NIfTI, NRRD, MetaImage), or what was found in a scan
    /// by itself. Each label has a look; what has no label is called `unlabelled`. The map may have another resolution than
    /// the scan; borders between labels are smooth. Several of these may share a map, and many volumes one of these.
    /// </remarks>
    [CreateAssetMenu(menuName = "Lumivox/Labels", fileName = "Labels", order = 311)]
    public sealed class LumivoxLabels : ScriptableObject
    {
        /// <summary>The name of what has no label.</summary>
        public const string Unlabelled = "unlabelled";

        /// <summary>How the voxels of one label look.</summary>
        [Serializable]
        public struct Look
        {
            /// <summary>What the label is called in its map.</summary>
            [Tooltip("What the label is called in its map.")]
            public string name;
            /// <summary>The label's value in its map; 0 is what has no label.</summary>
            [Tooltip("The label's value in its map; 0 is what has no label.")]
            public int value;
            /// <summary>Whether it is seen at all.</summary>
            [Tooltip("Whether it is seen at all.")]
            public bool visible;
            /// <summary>Multiplies its opacity, 0 to 1.</summary>
            [Tooltip("Multiplies its opacity."), Range(0f, 1f)]
            public float opacity;
            /// <summary>Its density in place of the volume's, 0 to 1e9; -1: that.</summary>
            [Tooltip("Its density in place of the volume's, 0 to 1e9; -1: that."), Min(-1f)]
            public float density;
            /// <summary>Whether <see cref="color"/> takes the place of the transfer function's; what that makes clear stays clear.</summary>
            [Tooltip("Whether Color takes the place of the transfer function's; what that makes clear stays clear.")]
            public bool painted;
            /// <summary>Its colour where it is painted; alpha is not used.</summary>
            [Tooltip("Its colour where it is painted."), ColorUsage(false)]
            public Color color;
            /// <summary>Its own, with its colours and without rows for gradients; null: the volume's.</summary>
            [Tooltip("A transfer function of its own, with its colours and without rows for gradients. Empty: the volume's.")]
            public LumivoxTransferFunction transferFunction;
            /// <summary>Whether a <see cref="LumivoxClip"/> cuts it; otherwise it is spared.</summary>
            [Tooltip("Whether a Lumivox Clip cuts it; otherwise it is spared.")]
            public bool clipped;
            /// <summary>Whether the surface below takes the place of the volume's.</summary>
            [Tooltip("Whether the surface below takes the place of the volume's.")]
            public bool ownSurface;
            /// <summary>See <see cref="LumivoxVolume.surfaceStrength"/>.</summary>
            [Tooltip("How strongly boundaries reflect like surfaces: 0 (off) to 1."), Range(0f, 1f)]
            public float surfaceStrength;
            /// <summary>See <see cref="LumivoxVolume.surfaceGradient"/>; 0: the volume's.</summary>
            [Tooltip("How steep a boundary must be, in value units per millimetre. 0: as for the volume."), Min(0f)]
            public float surfaceGradient;
            /// <summary>See <see cref="LumivoxVolume.surfaceRoughness"/>.</summary>
            [Tooltip("Width of the highlights: 0 glossy, 1 matt."), Range(0f, 1f)]
            public float surfaceRoughness;
            /// <summary>See <see cref="LumivoxVolume.surfaceSpecular"/>.</summary>
            [Tooltip("Share of the light that the highlights reflect seen head-on."), Range(0f, 1f)]
            public float surfaceSpecular;
            /// <summary>See <see cref="LumivoxVolume.surfaceMetallic"/>.</summary>
            [Tooltip("How much of the label's own colour the highlights have: 1 of metal."), Range(0f, 1f)]
            public float surfaceMetallic;

            /// <summary>All of the surface.</summary>
            internal Surface Surface
            {
                readonly get => new Surface { strength = surfaceStrength, gradient = surfaceGradient, roughness = surfaceRoughness, specular = surfaceSpecular, metallic = surfaceMetallic };
                set => (surfaceStrength, surfaceGradient, surfaceRoughness, surfaceSpecular, surfaceMetallic) = (value.strength, value.gradient, value.roughness, value.specular, value.metallic);
            }

            /// <summary>A label that looks as the volume says.</summary>
            public Look(int value, string name, Color color)
            {
                this.value = value;
                this.name = name;
                this.color = color;
                visible = true;
                opacity = 1f;
                density = -1f;
                painted = false;
                transferFunction = null;
                clipped = true;
                ownSurface = false;
                surfaceStrength = 1f;
                surfaceGradient = 0f;
                surfaceRoughness = 0.4f;
                surfaceSpecular = 0.04f;
                surfaceMetallic = 0f;
            }

            internal Look Sanitized()
            {
                var look = this;
                look.value = Mathf.Clamp(value, 0, 255);
                look.opacity = Numbers.Within(opacity, 0f, 1f, 1f);
                // -1 is the volume's, and so is all else below 0.
                look.density = Numbers.IsFinite(density) && density >= 0f ? Mathf.Min(density, LumivoxVolume.MaxDensity) : -1f;
                look.surfaceStrength = Numbers.Within(surfaceStrength, 0f, 1f, 1f);
                look.surfaceGradient = Numbers.Within(surfaceGradient, 0f, LumivoxVolume.MaxGradient, 0f);
                look.surfaceRoughness = Numbers.Within(surfaceRoughness, 0f, 1f, 0.4f);
                look.surfaceSpecular = Numbers.Within(surfaceSpecular, 0f, 1f, 0.04f);
                look.surfaceMetallic = Numbers.Within(surfaceMetallic, 0f, 1f, 0f);
                return look;
            }
        }

        [SerializeField, Tooltip("The label map: a segmentation that was imported, or what was found in a scan.")]
        LumivoxVolumeAsset m_Map;
        [SerializeField, Tooltip("How each label looks.")]
        List<Look> m_Looks = new List<Look>();

        LabellingHandle handle;
        /// What the handle was made of: looks have their functions in it, and of an opened map there is another each time.
        VolumeHandle builtMap;
        readonly List<TransferFunctionHandle> builtFunctions = new List<TransferFunctionHandle>();
        int users;
        LumivoxVolumeAsset retained;

        /// <summary>Its map, or a look, is another.</summary>
        public event Action changed;

        /// <summary>The label map: a scan whose <see cref="LumivoxVolumeAsset.isLabelMap"/> says so. Another one leaves the looks of labels of the same name and value.</summary>
        /// <exception cref="LumivoxException">It is a scan, and no label map.</exception>
        public LumivoxVolumeAsset map
        {
            get => m_Map;
            set
            {
                MainThread.Need("LumivoxLabels.map");
                if (value != null && !value.isLabelMap) throw new LumivoxException($"'{value.name}' is a scan and no label map.");
                m_Map = value;
                Touch();
            }
        }

        /// <summary>How each label looks, in the order of their values; what has none comes last.</summary>
        public IReadOnlyList<Look> looks => m_Looks;

        /// <summary>The names of the labels, in the same order.</summary>
        public string[] GetNames()
        {
            var names = new string[m_Looks.Count];
            for (var i = 0; i < names.Length; i++) names[i] = m_Looks[i].name;
            return names;
        }

        /// <summary>The look of the first label of a name, in upper or lower case; false where there is none.</summary>
        public bool TryGetLook(string name, out Look look)
        {
            foreach (var one in m_Looks)
                if (string.Equals(one.name, name, StringComparison.OrdinalIgnoreCase))
                {
                    look = one;
                    return true;
                }
            look = default;
            return false;
        }

        /// <summary>Sets how the label of <see cref="Look.value"/> looks. Numbers beyond the range of their field become the nearest one in it.</summary>
        /// <exception cref="LumivoxException">There is no such label.</exception>
        public void SetLook(Look look)
        {
            MainThread.Need("LumivoxLabels.SetLook");
            var at = m_Looks.FindIndex(one => one.value == look.value);
            if (at < 0) throw new LumivoxException($"There is no label of the value {look.value}. There are {string.Join(", ", GetNames())}.");
            // What it is called is the map's to say.
            look.name = m_Looks[at].name;
            m_Looks[at] = look.Sanitized();
            Touch();
        }

        /// <summary>Labels that all look as their volume says.</summary>
        /// <exception cref="LumivoxException">There is no map, or it is a scan.</exception>
        public static LumivoxLabels Of(LumivoxVolumeAsset map)
        {
            if (map == null) throw new LumivoxException("There is no label map: it is null.");
            if (!map.isLabelMap) throw new LumivoxException($"'{map.name}' is a scan and no label map.");
            var labels = CreateInstance<LumivoxLabels>();
            labels.m_Map = map;
            labels.name = map.name;
            labels.TakeNames();
            return labels;
        }

        /// <summary>
        /// Loads a segmentation on another thread: a DICOM SEG file or a folder with one, a NIfTI, NRRD or MetaImage file of
        /// labels. For progress and a way to stop it, see <see cref="LumivoxImporter.LoadLabels"/>.
        /// </summary>
        /// <exception cref="LumivoxException">From the task: it cannot be read, or holds no labels.</exception>
        public static async Task<LumivoxLabels> LoadFile(string path)
        {
            using (var importer = new LumivoxImporter()) return await importer.LoadLabels(new[] { path });
        }

        /// <summary>
        /// What is found in a scan by itself, on another thread: of a CT the body, lungs, airways and gas, table and clothes;
        /// of an MR the body. The report of the map says how sure that is. For progress and a way to stop it, see
        /// <see cref="LumivoxImporter.FindLabels"/>.
        /// </summary>
        /// <exception cref="LumivoxException">The scan is not open.</exception>
        public static async Task<LumivoxLabels> FoundIn(LumivoxVolumeAsset volume)
        {
            using (var importer = new LumivoxImporter()) return await importer.FindLabels(volume);
        }

        /// <summary>Labels of the voxels of a script, copied: x fastest, the value of a label each, or 0.</summary>
        /// <param name="dimensions">Voxels along x, y and z.</param>
        /// <param name="voxels">Their values.</param>
        /// <param name="patientFromVoxel">Three columns and the translation: millimetres towards left, back and head, as the scan has them.</param>
        /// <param name="labels">What the values mean.</param>
        /// <exception cref="LumivoxException">They do not fit together.</exception>
        public static unsafe LumivoxLabels Create(Vector3Int dimensions, ReadOnlySpan<byte> voxels, ReadOnlySpan<double> patientFromVoxel, IReadOnlyList<LumivoxLabel> labels)
        {
            Border.Need();
            if (patientFromVoxel.Length != 12) throw new LumivoxException($"patientFromVoxel has 12 numbers (three columns and the translation), not {patientFromVoxel.Length}.");
            if (dimensions.x < 1 || dimensions.y < 1 || dimensions.z < 1) throw new LumivoxException($"A label map of {dimensions.x} x {dimensions.y} x {dimensions.z} voxels holds nothing.");
            var count = labels?.Count ?? 0;
            var native = new LabelInfo[count];
            var text = new List<byte>();
            var starts = new int[count];
            for (var i = 0; i < count; i++)
            {
                native[i] = new LabelInfo { value = (uint)Math.Max(0, labels[i].value), color = Numbers.Linear(labels[i].color) };
                starts[i] = text.Count;
                text.AddRange(Border.Utf8(labels[i].name ?? ""));
            }
            var dims = stackalloc uint[] { (uint)dimensions.x, (uint)dimensions.y, (uint)dimensions.z };
            var names = stackalloc byte*[count];
            var all = text.ToArray();
            fixed (byte* characters = all, data = &MemoryMarshal.GetReference(voxels))
            fixed (double* place = &MemoryMarshal.GetReference(patientFromVoxel))
            fixed (LabelInfo* info = native)
            {
                for (var i = 0; i < count; i++) names[i] = characters + starts[i];
                return Of(LumivoxVolumeAsset.Of(new VolumeHandle(Border.Checked(Library.lumivox_labels_new(dims, data, (ulong)voxels.Length, place, info, names, (uint)count)))));
            }
        }

        /// <summary>Takes over a look of the library's; its transfer function is an object of its own.</summary>
        internal void Take(in LabelStyle style, LumivoxTransferFunction transferFunction)
        {
            var value = (int)style.value;
            var at = m_Looks.FindIndex(one => one.value == value);
            if (at < 0) return;
            var look = m_Looks[at];
            look.visible = style.visible != 0;
            look.painted = style.painted != 0;
            look.clipped = style.clipped != 0;
            if (look.painted) look.color = new Color(style.color.x, style.color.y, style.color.z, 1f).gamma;
            look.opacity = style.opacity;
            look.density = style.density;
            look.transferFunction = transferFunction;
            look.ownSurface = style.hasSurface != 0;
            look.Surface = style.surface;
            m_Looks[at] = look.Sanitized();
            Free();
        }

        /// <summary>Whether a volume has to wait for them.</summary>
        internal bool IsComing => m_Map != null && m_Map.isLabelMap && (m_Map.state == LumivoxVolumeState.Loading || m_Map.state == LumivoxVolumeState.Closed && !m_Map.isEmpty);

        /// <summary>For the native library; zero where there are no labels, or not yet.</summary>
        internal IntPtr Pointer
        {
            get
            {
                if (m_Map == null || !m_Map.isLabelMap || m_Map.Pointer == IntPtr.Zero) return IntPtr.Zero;
                if (handle == null || !IsCurrent()) Build();
                return handle.Pointer;
            }
        }

        /// <summary>Why they show nothing of themselves, in sentences for people; null where they do, or will.</summary>
        internal string Problem
        {
            get
            {
                if (m_Map == null) return "The labels have no label map. Set 'Map' of the labels, or find labels in the scan.";
                if (!m_Map.isLabelMap) return $"'{m_Map.name}', the map of the labels, is a scan and no label map.";
                return m_Map.state == LumivoxVolumeState.Failed ? $"The labels cannot be shown: {m_Map.error}" : null;
            }
        }

        /// <summary>A volume shows them from now on.</summary>
        internal void Retain()
        {
            users++;
            RetainMap();
        }

        /// <summary>It shows them no longer.</summary>
        internal void Release()
        {
            users = Math.Max(0, users - 1);
            RetainMap();
        }

        void RetainMap()
        {
            var wanted = users > 0 ? m_Map : null;
            if (wanted == retained) return;
            if (retained != null)
            {
                retained.changed -= OnMapChanged;
                retained.Release();
            }
            retained = wanted;
            if (retained != null)
            {
                retained.changed += OnMapChanged;
                retained.Retain();
            }
        }

        void OnMapChanged()
        {
            // Its file may have become another one.
            TakeNames();
            changed?.Invoke();
        }

        bool IsCurrent()
        {
            if (!ReferenceEquals(builtMap, m_Map.Handle) || builtFunctions.Count != m_Looks.Count) return false;
            for (var i = 0; i < m_Looks.Count; i++)
                if (!ReferenceEquals(builtFunctions[i], FunctionOf(m_Looks[i]))) return false;
            return true;
        }

        static TransferFunctionHandle FunctionOf(in Look look) => look.transferFunction != null ? look.transferFunction.Handle : null;

        unsafe void Build()
        {
            Free();
            var styles = new LabelStyle[m_Looks.Count];
            for (var i = 0; i < styles.Length; i++)
            {
                var look = m_Looks[i].Sanitized();
                var function = FunctionOf(look);
                builtFunctions.Add(function);
                styles[i] = new LabelStyle
                {
                    value = (uint)look.value,
                    visible = look.visible ? 1u : 0u,
                    painted = look.painted ? 1u : 0u,
                    clipped = look.clipped ? 1u : 0u,
                    color = Numbers.Linear(look.color),
                    opacity = look.opacity,
                    density = look.density,
                    hasSurface = look.ownSurface ? 1u : 0u,
                    surface = look.Surface,
                    transferFunction = function != null ? function.Pointer : IntPtr.Zero,
                };
            }
            builtMap = m_Map.Handle;
            fixed (LabelStyle* first = styles)
                handle = new LabellingHandle(Border.Checked(Library.lumivox_labelling_new(builtMap.Pointer, first, (uint)styles.Length)));
        }

        /// <summary>Gives each label of the map a look. Those that it had before keep theirs.</summary>
        void TakeNames()
        {
            if (m_Map == null || !m_Map.isLabelMap || m_Map.labels.Count == 0) return;
            var taken = new List<Look>(m_Map.labels.Count + 1);
            foreach (var label in m_Map.labels) taken.Add(Kept(label.value, label.name, label.color));
            taken.Add(Kept(0, Unlabelled, Color.white));
            m_Looks = taken;
        }

        Look Kept(int value, string name, Color color)
        {
            foreach (var look in m_Looks)
                if (look.value == value && look.name == name) return look;
            return new Look(value, name, color);
        }

        void Touch()
        {
            Free();
            RetainMap();
            TakeNames();
            changed?.Invoke();
            LumivoxRuntime.RequestFrames();
        }

        void Free()
        {
            handle?.Dispose();
            handle = null;
            builtMap = null;
            builtFunctions.Clear();
        }

        void OnValidate()
        {
            for (var i = 0; i < m_Looks.Count; i++) m_Looks[i] = m_Looks[i].Sanitized();
            Touch();
        }

        void OnDisable()
        {
            users = 0;
            RetainMap();
            Free();
        }
    }
}
