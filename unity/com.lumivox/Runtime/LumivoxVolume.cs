using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>
    /// A scan in a scene, path traced: it scatters the scene's light, hides meshes behind it and is hidden by those before
    /// it. Any number may overlap.
    /// </summary>
    /// <remarks>
    /// The scan stands upright at its true size (one unit is a metre), its centre at the object's origin. The patient's head
    /// is up (+y), the face looks along -z, at a camera that was not turned, and the patient's left is +x, on that camera's
    /// right, as when facing somebody.
    /// How the image converges is set by a <see cref="LumivoxEffect"/>; without one, the project's defaults hold. The
    /// object's layer decides which cameras see it and which lights light it. Numbers beyond the range of their property
    /// become the nearest one in it; NaN and infinity are refused with an error, and the property stays as it was.
    /// </remarks>
    [ExecuteAlways, DisallowMultipleComponent, AddComponentMenu("Lumivox/Lumivox Volume"), SelectionBase]
    public sealed partial class LumivoxVolume : MonoBehaviour
    {
        /// <summary>Largest <see cref="density"/>.</summary>
        public const float MaxDensity = 1e9f;

        /// <summary>Largest <see cref="peelMm"/>: what depths are told apart to.</summary>
        public const float MaxPeelMm = 60f;

        /// <summary>Largest <see cref="surfaceGradient"/>.</summary>
        public const float MaxGradient = 1e12f;

        /// <summary>How values between voxels are found.</summary>
        public enum Filter
        {
            /// <summary>Shows the voxels: each value reaches to the middle between two.</summary>
            Nearest = 0,
            /// <summary>Goes straight from voxel to voxel, which shows as terraces on smooth surfaces.</summary>
            Trilinear = 1,
            /// <summary>Cubic B-splines: hardly any terraces, about as sharp as <see cref="Smooth"/>, and slow.</summary>
            Tricubic = 2,
            /// <summary>Averages voxels with their neighbours and goes straight from one to the next: as fast as <see cref="Trilinear"/>, with hardly any terraces, and a little softer.</summary>
            Smooth = 3,
        }

        /// <summary>What a millimetre of extinction is measured in.</summary>
        public enum ExtinctionSpace
        {
            /// <summary>The scan's own: scaling the object never changes its look.</summary>
            Volume = 0,
            /// <summary>The scene's: twice as large is twice as opaque.</summary>
            World = 1,
        }

        [SerializeField, Tooltip("The scan.")]
        LumivoxVolumeAsset m_Volume;
        [SerializeField, Tooltip("Opacity and colour of the scan's values. Empty: those of the preset that suits the scan. Volumes may share it.")]
        LumivoxTransferFunction m_TransferFunction;
        [SerializeField, Tooltip("A look that suits a kind of scan at once. Choosing one replaces the transfer function, density, albedo, anisotropy, max bounces and the surface; what is changed afterwards stays changed. While it is ct-airways or ct-lung-vessels, that organ of the scan is seen alone.")]
        string m_Preset = "";
        [Header("Medium")]
        [SerializeField, Range(0f, 100f), Tooltip("Multiplies the extinction, which is 1 per millimetre at an opacity of 1: 0 (nothing is seen) to 1e9. Low: glass and mist; high: solid.")]
        float m_Density = 2f;
        [SerializeField, Range(0f, 1f), Tooltip("Fraction of the light that survives each scattering.")]
        float m_Albedo = 1f;
        [SerializeField, Range(-0.99f, 0.99f), Tooltip("Where light goes when it scatters: 0 in all directions alike, towards 0.99 onwards, towards -0.99 back.")]
        float m_Anisotropy;
        [SerializeField, Range(1, 1000), Tooltip("Scatterings after which light is no longer followed. 1 is single scattering: fast and dark.")]
        int m_MaxBounces = 100;
        [SerializeField, Tooltip("How values between voxels are found.")]
        Filter m_Filter = Filter.Smooth;
        [SerializeField, Tooltip("What a millimetre of extinction is measured in: the scan's own, so that scaling the object never changes its look, or the scene's.")]
        ExtinctionSpace m_ExtinctionSpace = ExtinctionSpace.Volume;
        [Header("Surface")]
        [SerializeField, Range(0f, 1f), Tooltip("How strongly boundaries inside the scan, such as that of bone, reflect like surfaces: 0 (off) to 1.")]
        float m_SurfaceStrength = 1f;
        [SerializeField, Min(0f), Tooltip("How steep a boundary must be, in value units (HU for CT) per millimetre. 0: as suits the scan.")]
        float m_SurfaceGradient;
        [SerializeField, Range(0f, 1f), Tooltip("Width of the highlights: 0 glossy, 1 matt.")]
        float m_SurfaceRoughness = 0.4f;
        [SerializeField, Range(0f, 1f), Tooltip("Share of the light that the highlights reflect seen head-on. Skin and bone have about 0.04.")]
        float m_SurfaceSpecular = 0.04f;
        [SerializeField, Range(0f, 1f), Tooltip("How much of the scan's own colour the highlights have: 0 of skin and bone, 1 of metal, such as implants and fillings, which want a high Specular, too.")]
        float m_SurfaceMetallic;
        [Header("Parts")]
        [SerializeField, Tooltip("What the scan's parts are, and how each looks. Volumes may share it.")]
        LumivoxLabels m_Labels;
        [SerializeField, Tooltip("Whether what lies around the patient in a CT is seen, too: the table, clothes, cables, where the import has put them aside. They come back within a moment, from another thread. With it, a preset that shows one organ shows all, and Peel Mm takes them off with the skin.")]
        bool m_KeepEverything;
        [SerializeField, Range(0f, MaxPeelMm), Tooltip("Millimetres below the skin that are taken off. The skin of a CT or MR is found on another thread, which takes a few seconds the first time; where none is found for sure, nothing is taken off.")]
        float m_PeelMm;
        [Header("Clip")]
        [SerializeField, Tooltip("The corner of what is kept of the scan with the smallest coordinates, as fractions of its box, 0 to 1. Where it lies beyond Clip Max, what is between them is kept.")]
        Vector3 m_ClipMin = Vector3.zero;
        [SerializeField, Tooltip("The opposite corner of what is kept. Where it is as large as Clip Min along an axis, nothing is.")]
        Vector3 m_ClipMax = Vector3.one;

        static readonly List<LumivoxVolume> all = new List<LumivoxVolume>();

        LumivoxVolumeAsset retained;
        LumivoxLabels retainedLabels;
        /// Those that cut it; each sees to it that it is here.
        readonly List<LumivoxClip> clips = new List<LumivoxClip>();
        /// The labels and the scan that were compared last: to look at all labels takes a while.
        [NonSerialized] VolumeHandle comparedMap, comparedScan;
        [NonSerialized] double share;

        internal List<LumivoxClip> Clips => clips;

        /// <summary>Those that are enabled, in the order in which they came.</summary>
        internal static List<LumivoxVolume> All => all;

        /// <summary>Something that is seen, or warned of, is another.</summary>
        public event Action changed;

        /// <summary>The scan.</summary>
        public LumivoxVolumeAsset volume
        {
            get => m_Volume;
            set
            {
                MainThread.Need("LumivoxVolume.volume");
                m_Volume = value;
                Retain();
                Change();
            }
        }

        /// <summary>Opacity and colour of the scan's values; null: those of the preset that suits the scan.</summary>
        public LumivoxTransferFunction transferFunction
        {
            get => m_TransferFunction;
            set
            {
                MainThread.Need("LumivoxVolume.transferFunction");
                m_TransferFunction = value;
                Change();
            }
        }

        /// <summary>
        /// The preset that was applied last. Setting one applies it: see <see cref="ApplyPreset"/>. While it is `ct-airways` or
        /// `ct-lung-vessels`, that organ of the scan is seen alone: it is looked for on another thread, and where it is not found
        /// for sure all is seen, and a warning says so.
        /// </summary>
        public string preset
        {
            get => m_Preset;
            set
            {
                if (!string.IsNullOrEmpty(value)) ApplyPreset(value);
                else
                {
                    m_Preset = "";
                    Change();
                }
            }
        }

        /// <summary>Multiplies the extinction, which is 1 per millimetre at an opacity of 1: 0 (nothing is seen) to 1e9.</summary>
        public float density { get => m_Density; set => Put("density", ref m_Density, value, 0f, MaxDensity); }

        /// <summary>Fraction of the light that survives each scattering, 0 to 1.</summary>
        public float albedo { get => m_Albedo; set => Put("albedo", ref m_Albedo, value, 0f, 1f); }

        /// <summary>Where light goes when it scatters: 0 in all directions alike, towards 0.99 onwards, towards -0.99 back.</summary>
        public float anisotropy { get => m_Anisotropy; set => Put("anisotropy", ref m_Anisotropy, value, -0.99f, 0.99f); }

        /// <summary>Scatterings after which light is no longer followed, 1 to 1000. 1 is single scattering: fast and dark.</summary>
        public int maxBounces
        {
            get => m_MaxBounces;
            set
            {
                m_MaxBounces = Mathf.Clamp(value, 1, 1000);
                Change();
            }
        }

        /// <summary>How values between voxels are found.</summary>
        public Filter filter
        {
            get => m_Filter;
            set
            {
                m_Filter = (Filter)Mathf.Clamp((int)value, (int)Filter.Nearest, (int)Filter.Smooth);
                Change();
            }
        }

        /// <summary>What a millimetre of extinction is measured in.</summary>
        public ExtinctionSpace extinctionSpace
        {
            get => m_ExtinctionSpace;
            set
            {
                m_ExtinctionSpace = (ExtinctionSpace)Mathf.Clamp((int)value, (int)ExtinctionSpace.Volume, (int)ExtinctionSpace.World);
                Change();
            }
        }

        /// <summary>How strongly boundaries inside the scan, such as that of bone, reflect like surfaces: 0 (off) to 1.</summary>
        public float surfaceStrength { get => m_SurfaceStrength; set => Put("surfaceStrength", ref m_SurfaceStrength, value, 0f, 1f); }

        /// <summary>How steep a boundary must be, in value units (HU for CT) per millimetre. 0: as suits the scan.</summary>
        public float surfaceGradient { get => m_SurfaceGradient; set => Put("surfaceGradient", ref m_SurfaceGradient, value, 0f, MaxGradient); }

        /// <summary>Width of the highlights: 0 glossy, 1 matt.</summary>
        public float surfaceRoughness { get => m_SurfaceRoughness; set => Put("surfaceRoughness", ref m_SurfaceRoughness, value, 0f, 1f); }

        /// <summary>Share of the light, 0 to 1, that the highlights reflect seen head-on. Skin and bone have about 0.04.</summary>
        public float surfaceSpecular { get => m_SurfaceSpecular; set => Put("surfaceSpecular", ref m_SurfaceSpecular, value, 0f, 1f); }

        /// <summary>How much of the scan's own colour the highlights have: 0 of skin and bone, 1 of metal, such as implants and fillings, which want a high <see cref="surfaceSpecular"/>, too.</summary>
        public float surfaceMetallic { get => m_SurfaceMetallic; set => Put("surfaceMetallic", ref m_SurfaceMetallic, value, 0f, 1f); }

        /// <summary>All of the surface.</summary>
        Surface OwnSurface
        {
            get => new Surface { strength = m_SurfaceStrength, gradient = m_SurfaceGradient, roughness = m_SurfaceRoughness, specular = m_SurfaceSpecular, metallic = m_SurfaceMetallic };
            set => (m_SurfaceStrength, m_SurfaceGradient, m_SurfaceRoughness, m_SurfaceSpecular, m_SurfaceMetallic) = (value.strength, value.gradient, value.roughness, value.specular, value.metallic);
        }

        /// <summary>What the scan's parts are, and how each looks; null: it has none.</summary>
        public LumivoxLabels labels
        {
            get => m_Labels;
            set
            {
                MainThread.Need("LumivoxVolume.labels");
                m_Labels = value;
                Retain();
                Change();
            }
        }

        /// <summary>
        /// Millimetres below the skin that are taken off, up to 60. The skin of a CT or MR is found on another thread, which
        /// takes a few seconds the first time; where none is found for sure, nothing is taken off. May be animated.
        /// </summary>
        public float peelMm { get => m_PeelMm; set => Put("peelMm", ref m_PeelMm, value, 0f, MaxPeelMm); }

        /// <summary>
        /// The corner of what is kept of the scan with the smallest coordinates, as fractions of its box, 0 to 1: x to the
        /// right, y up, z along the object's. Where it lies beyond <see cref="clipMax"/>, what is between them is kept.
        /// </summary>
        public Vector3 clipMin { get => m_ClipMin; set => Put("clipMin", ref m_ClipMin, value); }

        /// <summary>The opposite corner of what is kept. Where it is as large as <see cref="clipMin"/> along an axis, nothing is.</summary>
        public Vector3 clipMax { get => m_ClipMax; set => Put("clipMax", ref m_ClipMax, value); }

        /// <summary>What the scan fills along the object's axes, in metres; empty without a scan.</summary>
        public Bounds localBounds => m_Volume != null ? m_Volume.localBounds : default;

        /// <summary>From clip coordinates, 0 to 1 along each edge of the scan's box, to the object's metres. The identity without a scan.</summary>
        public Matrix4x4 clipTransform => m_Volume != null ? m_Volume.objectFromClip : Matrix4x4.identity;

        /// <summary>
        /// Takes over the look of a preset: its transfer function (a new one), density, albedo, anisotropy, max bounces
        /// and the surface. Filter, extinction space, parts and clips stay. Presets for MR place themselves by the scan's
        /// values and need the volume to be open. Returns whether it could; if not, an error says why, and nothing changes.
        /// </summary>
        public bool ApplyPreset(string name)
        {
            MainThread.Need("LumivoxVolume.ApplyPreset");
            Medium look;
            LumivoxTransferFunction curve;
            try
            {
                curve = LumivoxTransferFunction.Preset(name, m_Volume, out look);
            }
            catch (LumivoxException error)
            {
                Debug.LogError($"LumivoxVolume.preset: {error.Message}", this);
                return false;
            }
            m_Preset = name;
            m_Density = look.density;
            m_Albedo = look.albedo;
            m_Anisotropy = look.anisotropy;
            m_MaxBounces = (int)look.maxBounces;
            OwnSurface = look.surface;
            m_TransferFunction = curve;
            Change();
            return true;
        }

        /// <summary>The names of all presets.</summary>
        public static IReadOnlyList<string> PresetNames => LumivoxTransferFunction.PresetNames;

        /// <summary>Why less is seen than there is, or nothing, in sentences for people; empty where all is well.</summary>
        public List<string> GetWarnings()
        {
            var warnings = new List<string>();
            if (m_Volume == null || m_Volume.isEmpty) warnings.Add("There is no scan to show. Set 'Volume', or import a DICOM folder: Assets > Lumivox > Import DICOM Folder.");
            else if (m_Volume.state == LumivoxVolumeState.Failed) warnings.Add($"The scan cannot be shown: {m_Volume.error}");
            if (m_TransferFunction != null && m_TransferFunction.IsWithoutKnots) warnings.Add("The transfer function has no opacity knots: it shows nothing. Choose a preset, or add knots.");
            if (m_Density == 0f) warnings.Add("'Density' is 0: nothing is seen.");
            // Of what is no number, nothing is larger than 0.
            var size = Mathf.Abs(transform.localToWorldMatrix.determinant);
            if (!(size > 0f) || float.IsInfinity(size)) warnings.Add("The object's scale is 0 along an axis, or not finite: nothing is seen.");
            var extent = m_ClipMax - m_ClipMin;
            if (extent.x * extent.y * extent.z == 0f) warnings.Add("The clip box is flat: nothing is seen. 'Clip Min' must be smaller than 'Clip Max'.");
            else if (Mathf.Min(extent.x, Mathf.Min(extent.y, extent.z)) < 0f) warnings.Add("'Clip Min' lies beyond 'Clip Max': what is between them is kept.");
            if (QualitySettings.activeColorSpace == ColorSpace.Gamma) warnings.Add("The project's colour space is Gamma: volumes are too dark in it. Set Project Settings > Player > Color Space to Linear.");
            AddWarningsOfParts(warnings);
            var error = LumivoxRenderer.LastError;
            if (error.Length > 0) warnings.Add($"Volumes cannot be drawn: {error}");
            var factor = LumivoxRuntime.ReductionOf(shown != null && shown.Pointer != IntPtr.Zero ? shown.Pointer : m_Volume != null ? m_Volume.Pointer : IntPtr.Zero);
            if (factor > 1) warnings.Add($"The GPU has no room for all voxels of this scan: it is shown at 1/{factor} of its resolution. Free others, or crop it.");
            return warnings;
        }

        void AddWarningsOfParts(List<string> warnings)
        {
            if (m_Labels != null)
            {
                var problem = m_Labels.Problem;
                if (problem != null) warnings.Add(problem);
                else if (m_Labels.Pointer != IntPtr.Zero && m_Volume != null && m_Volume.Pointer != IntPtr.Zero) AddWarningsOfShare(warnings);
            }
            AddWarningsOfShown(warnings);
            if (m_PeelMm > 0f && m_Volume != null && m_Volume.SkinProblem.Length > 0) warnings.Add($"Nothing is peeled off the scan: {m_Volume.SkinProblem}");
        }

        void AddWarningsOfShare(List<string> warnings)
        {
            var (map, scan) = (m_Labels.map.Handle, m_Volume.Handle);
            if (!ReferenceEquals(map, comparedMap) || !ReferenceEquals(scan, comparedScan))
                (comparedMap, comparedScan, share) = (map, scan, Library.lumivox_labels_share_in(map.Pointer, scan.Pointer));
            if (share < 0) warnings.Add("Nothing is labelled in the map of the labels.");
            else if (share == 0) warnings.Add("None of the labels lies in the scan: they are of another patient, or of another place. Take the labels of this scan.");
            else if (share < 0.5) warnings.Add($"{100 * (1 - share):0}% of what is labelled lies beyond the scan: are they of the same patient?");
        }

        /// <summary>As it stands in the world; false where there is nothing to show.</summary>
        internal bool TryGetInstance(ref Instance instance)
        {
            if (m_Volume == null) return false;
            instance.volume = m_Volume.Pointer;
            if (instance.volume == IntPtr.Zero) return false;
            // What labels hide must not be seen until they are there.
            if (m_Labels != null && m_Labels.IsComing) return false;
            instance.part = ShownPointer();
            instance.labelling = m_Labels != null ? m_Labels.Pointer : IntPtr.Zero;
            // When the skin was found, that is another instance.
            instance.peelMm = m_PeelMm > 0f && m_Volume.NeedSkin() ? m_PeelMm : 0f;
            instance.transferFunction = m_TransferFunction != null ? m_TransferFunction.Pointer : IntPtr.Zero;
            instance.worldFromObject = transform.localToWorldMatrix;
            instance.clipMin = m_ClipMin;
            instance.clipMax = m_ClipMax;
            instance.layers = 1u << gameObject.layer;
            instance.medium.density = m_Density;
            instance.medium.albedo = m_Albedo;
            instance.medium.anisotropy = m_Anisotropy;
            instance.medium.maxBounces = (uint)m_MaxBounces;
            instance.medium.filter = (uint)m_Filter;
            instance.medium.extinctionSpace = (uint)m_ExtinctionSpace;
            instance.medium.surface = OwnSurface;
            return true;
        }

        /// <summary>Takes over all of an instance but its handles and its place.</summary>
        internal void Take(in Instance instance, LumivoxVolumeAsset scan, LumivoxTransferFunction function, LumivoxLabels of)
        {
            (m_Volume, m_TransferFunction, m_Labels) = (scan, function, of);
            m_Preset = "";
            m_Density = instance.medium.density;
            m_Albedo = instance.medium.albedo;
            m_Anisotropy = instance.medium.anisotropy;
            m_MaxBounces = (int)instance.medium.maxBounces;
            m_Filter = (Filter)instance.medium.filter;
            m_ExtinctionSpace = (ExtinctionSpace)instance.medium.extinctionSpace;
            OwnSurface = instance.medium.surface;
            m_PeelMm = Mathf.Min(instance.peelMm, MaxPeelMm);
            m_ClipMin = instance.clipMin;
            m_ClipMax = instance.clipMax;
            OnValidate();
        }

        void Put(string property, ref float field, float value, float low, float high)
        {
            if (!Numbers.IsFinite(value))
            {
                Numbers.Takes($"LumivoxVolume.{property}", false, this);
                return;
            }
            field = Mathf.Clamp(value, low, high);
            Change();
        }

        void Put(string property, ref Vector3 field, Vector3 value)
        {
            if (!Numbers.IsFinite(value))
            {
                Numbers.Takes($"LumivoxVolume.{property}", false, this);
                return;
            }
            field = Numbers.Clamp01(value);
            Change();
        }

        void Change()
        {
            changed?.Invoke();
            LumivoxRuntime.RequestFrames();
        }

        void Retain()
        {
            RetainLabels(isActiveAndEnabled ? m_Labels : null);
            var wanted = isActiveAndEnabled ? m_Volume : null;
            if (wanted == retained) return;
            LeavePart();
            if (retained != null)
            {
                retained.changed -= Change;
                retained.Release();
            }
            retained = wanted;
            if (retained != null)
            {
                retained.changed += Change;
                retained.Retain();
            }
        }

        void RetainLabels(LumivoxLabels wanted)
        {
            // One that was destroyed is left, too.
            if (ReferenceEquals(wanted, retainedLabels)) return;
            if (!ReferenceEquals(retainedLabels, null))
            {
                retainedLabels.changed -= Change;
                retainedLabels.Release();
            }
            retainedLabels = wanted != null ? wanted : null;
            if (ReferenceEquals(retainedLabels, null)) return;
            retainedLabels.changed += Change;
            retainedLabels.Retain();
        }

        void OnEnable()
        {
            if (LumivoxRuntime.IsMakingAssets) return;
            all.Add(this);
            LumivoxClip.FindVolumes();
            Retain();
            LumivoxRuntime.Need();
            Change();
        }

        void OnDisable()
        {
            all.Remove(this);
            RetainLabels(null);
            LeavePart();
            if (!ReferenceEquals(retained, null))
            {
                if (retained != null)
                {
                    retained.changed -= Change;
                    retained.Release();
                }
                retained = null;
            }
            Change();
        }

        void OnValidate()
        {
            m_Density = Numbers.Within(m_Density, 0f, MaxDensity, 2f);
            m_Albedo = Numbers.Within(m_Albedo, 0f, 1f, 1f);
            m_Anisotropy = Numbers.Within(m_Anisotropy, -0.99f, 0.99f, 0f);
            m_MaxBounces = Mathf.Clamp(m_MaxBounces, 1, 1000);
            m_SurfaceStrength = Numbers.Within(m_SurfaceStrength, 0f, 1f, 1f);
            m_SurfaceGradient = Numbers.Within(m_SurfaceGradient, 0f, MaxGradient, 0f);
            m_SurfaceRoughness = Numbers.Within(m_SurfaceRoughness, 0f, 1f, 0.4f);
            m_SurfaceSpecular = Numbers.Within(m_SurfaceSpecular, 0f, 1f, 0.04f);
            m_SurfaceMetallic = Numbers.Within(m_SurfaceMetallic, 0f, 1f, 0f);
            m_PeelMm = Numbers.Within(m_PeelMm, 0f, MaxPeelMm, 0f);
            m_ClipMin = Numbers.IsFinite(m_ClipMin) ? Numbers.Clamp01(m_ClipMin) : Vector3.zero;
            m_ClipMax = Numbers.IsFinite(m_ClipMax) ? Numbers.Clamp01(m_ClipMax) : Vector3.one;
            // The inspector and undo set fields, not properties. OnDisable has the last word on what is held.
            if (isActiveAndEnabled) Retain();
            Change();
        }

#if UNITY_EDITOR
        void OnDrawGizmos()
        {
            if (m_Volume == null) return;
            // Nothing is seen of it, but a click on the scan selects it.
            Gizmos.matrix = transform.localToWorldMatrix;
            Gizmos.color = Color.clear;
            Gizmos.DrawCube(localBounds.center, localBounds.size);
        }

        void OnDrawGizmosSelected()
        {
            if (m_Volume == null) return;
            Gizmos.matrix = transform.localToWorldMatrix * clipTransform;
            Gizmos.color = new Color(0.35f, 0.75f, 1f, 0.35f);
            Gizmos.DrawWireCube(Vector3.one * 0.5f, Vector3.one);
            if (m_ClipMin == Vector3.zero && m_ClipMax == Vector3.one) return;
            Gizmos.color = new Color(1f, 0.75f, 0.25f, 0.9f);
            var size = m_ClipMax - m_ClipMin;
            Gizmos.DrawWireCube((m_ClipMin + m_ClipMax) * 0.5f, new Vector3(Mathf.Abs(size.x), Mathf.Abs(size.y), Mathf.Abs(size.z)));
        }
#endif
    }
}
