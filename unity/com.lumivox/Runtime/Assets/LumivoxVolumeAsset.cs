using System;
using System.Collections.Generic;
using System.IO;
using System.Runtime.InteropServices;
using System.Text;
using System.Threading.Tasks;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>How far a scan is on its way into memory.</summary>
    public enum LumivoxVolumeState
    {
        /// <summary>Nobody has asked for its voxels.</summary>
        Closed,
        /// <summary>They are being read.</summary>
        Loading,
        /// <summary>They are there.</summary>
        Ready,
        /// <summary>They cannot be had; <see cref="LumivoxVolumeAsset.error"/> says why.</summary>
        Failed,
    }

    /// <summary>
    /// A CT or MR scan: voxels in physical units (Hounsfield units for CT) at their true size and place in the patient.
    /// </summary>
    /// <remarks>
    /// The voxels lie in a file of their own, which is read by another thread when something shows the scan, and in the
    /// native library's memory: never on the managed heap. Scans that an importer or a phantom made at run time have no
    /// file until <see cref="Save"/> writes one, and are lost with the play session.
    /// </remarks>
    [PreferBinarySerialization]
    public sealed unsafe partial class LumivoxVolumeAsset : ScriptableObject
    {
        /// <summary>The folder of scans in StreamingAssets, where players find them.</summary>
        public const string StreamingFolder = "lumivox";

        /// <summary>What the file of a scan is called after.</summary>
        public const string FileExtension = ".lumivox";

        /// <summary>What is known of a scan before its voxels are there.</summary>
        [Serializable]
        struct Summary
        {
            public Vector3Int dimensions;
            public Vector3 spacingMm;
            public Vector2 valueRange;
            public Bounds bounds;
            public Matrix4x4 objectFromClip;
            public Matrix4x4 objectFromPatient;
            public string unit;
            public string modality;
            public bool isHounsfield;
            public bool hasSurroundings;
        }

        [SerializeField, HideInInspector]
        string m_StoredId = "";
        [SerializeField, HideInInspector]
        string m_Phantom = "";
        [SerializeField, HideInInspector]
        int m_PhantomSize;
        [SerializeField, HideInInspector]
        Summary m_Summary;
        [SerializeField, HideInInspector]
        string m_Report = "";

        VolumeHandle handle;
        Job opening;
        TaskCompletionSource<bool> opened;
        LumivoxVolumeState currentState;
        string currentError = "";
        int users;
        float unusedSince;
        /// A reload of the scripts would make an empty one of none.
        [NonSerialized] LumivoxReport report;
        /// What it was made of: when the file is imported again, the text is another.
        [NonSerialized] string reportText;

        /// <summary>Where the editor keeps the stored scan of an id; the editor's half of the package sets it.</summary>
        internal static Func<string, string> EditorFile;

        static readonly List<LumivoxVolumeAsset> unused = new List<LumivoxVolumeAsset>();

        /// <summary>Its state, or what it holds, is another.</summary>
        public event Action changed;

        /// <summary>How far it is.</summary>
        public LumivoxVolumeState state => currentState;

        /// <summary>Why it cannot be shown; empty where nothing is wrong.</summary>
        public string error => currentError;

        /// <summary>Whether there is no scan in it at all.</summary>
        public bool isEmpty => handle == null && m_StoredId == "" && m_Phantom == "";

        /// <summary>Whether it is in a file that it can be read from again.</summary>
        public bool isStored => m_StoredId != "" || m_Phantom != "";

        /// <summary>Voxels along the scan's own x, y and z axes; zeros without a scan.</summary>
        public Vector3Int dimensions => m_Summary.dimensions;

        /// <summary>Distances between neighbouring voxels along the scan's own axes, in millimetres.</summary>
        public Vector3 spacingMm => m_Summary.spacingMm;

        /// <summary>Edge lengths along the scan's own axes, in metres: what it measures in a scene.</summary>
        public Vector3 sizeM => Vector3.Scale(m_Summary.spacingMm, m_Summary.dimensions) * 1e-3f;

        /// <summary>The smallest value as x and the largest as y, in the scan's unit.</summary>
        public Vector2 valueRange => m_Summary.valueRange;

        /// <summary>The unit of the values: `HU` for most CT, `SUV` for most PET; empty where it is not known.</summary>
        public string unit => m_Summary.unit ?? "";

        /// <summary>DICOM's code, such as `CT`; empty where it is not known.</summary>
        public string modality => m_Summary.modality ?? "";

        /// <summary>Whether values are Hounsfield units.</summary>
        public bool isHounsfield => m_Summary.isHounsfield;

        /// <summary>What it fills along an object's axes, in metres.</summary>
        public Bounds localBounds => m_Summary.bounds;

        /// <summary>From clip coordinates, 0 to 1 along each edge of the scan's box, to an object's metres.</summary>
        public Matrix4x4 objectFromClip => dimensions == Vector3Int.zero ? Matrix4x4.identity : m_Summary.objectFromClip;

        /// <summary>
        /// From the patient's millimetres, as DICOM has them (x to the left, y to the back, z to the head), to an object's metres.
        /// The identity before the scan was read, where nothing has told it.
        /// </summary>
        public Matrix4x4 objectFromPatient => IsPlaceKnown ? m_Summary.objectFromPatient : Matrix4x4.identity;

        /// <summary>Whether it is known where it lies in the patient: phantoms and assets of older versions say so once they were read.</summary>
        internal bool IsPlaceKnown => m_Summary.objectFromPatient.m33 == 1f;

        /// <summary>What the scan may be called, such as `CT series 4`. It names neither files nor the patient.</summary>
        public string scanName
        {
            get
            {
                var series = GetReport().chosenSeries;
                return series != null && !string.IsNullOrEmpty(series.name) ? series.name : isLabelMap ? "Labels" : "Scan";
            }
        }

        /// <summary>How the scan was loaded; empty for a phantom.</summary>
        public LumivoxReport GetReport()
        {
            if (report == null || reportText != m_Report) (report, reportText) = (LumivoxReport.OfScan(m_Report), m_Report);
            return report;
        }

        /// <summary>
        /// The number of voxels in each of <paramref name="bins"/> equal parts, 1 to 65536, of the values from x to y of
        /// <paramref name="range"/>. Values outside are not counted; all are 0 while the scan is not open.
        /// </summary>
        public float[] GetHistogram(int bins, Vector2 range)
        {
            var counts = new float[Mathf.Clamp(bins, 1, 1 << 16)];
            if (handle == null) return counts;
            fixed (float* to = counts)
                Border.Checked(Library.lumivox_volume_histogram(handle.Pointer, range.x, range.y, (uint)counts.Length, to));
            return counts;
        }

        /// <summary>
        /// The scan from the front, at most `size` pixels along a side, 1 to 256: as a preset shows it, or the one that suits
        /// it; transparent where nothing is seen. It is made on another thread, in a simple light: for lists of scans and
        /// presets. Whoever asks for it destroys it.
        /// </summary>
        /// <exception cref="LumivoxException">The scan is not open, or there is no such preset.</exception>
        public Task<Texture2D> RequestPicture(int size = 128, string preset = null)
        {
            MainThread.Need("LumivoxVolumeAsset.RequestPicture");
            if (handle == null) throw new LumivoxException("A scan that is not open cannot be pictured: open it first.");
            var pictured = new TaskCompletionSource<Texture2D>();
            fixed (byte* utf8 = Border.Utf8(string.IsNullOrEmpty(preset) ? null : preset))
                Jobs.Follow(Library.lumivox_volume_picture(handle.Pointer, utf8, (uint)Mathf.Clamp(size, 1, 256)), pictured, job => job.Picture());
            return pictured.Task;
        }

        /// <summary>
        /// Reads the voxels on another thread, if they are not there; the task's result is whether they are, and
        /// <see cref="error"/> says why not. They stay while something shows the scan.
        /// </summary>
        public Task<bool> Open()
        {
            MainThread.Need("LumivoxVolumeAsset.Open");
            if (currentState == LumivoxVolumeState.Ready) return Task.FromResult(true);
            if (currentState == LumivoxVolumeState.Loading) return opened.Task;
            opened = new TaskCompletionSource<bool>();
            var task = opened.Task;
            if (Border.Fault != null) Fail(Border.Fault);
            else if (m_Phantom != "") Follow(StartPhantom(m_Phantom, m_PhantomSize));
            else if (m_StoredId != "") OpenStored();
            else Fail("There is no scan in it.");
            return task;
        }

        /// <summary>Writes the scan as a file of Lumivox' own, whole or not at all, on another thread.</summary>
        /// <exception cref="LumivoxException">It is not open, or the file cannot be written.</exception>
        public Task Save(string path)
        {
            MainThread.Need("LumivoxVolumeAsset.Save");
            if (handle == null) throw new LumivoxException("A scan that is not open cannot be saved: open it first.");
            var saved = new TaskCompletionSource<bool>();
            fixed (byte* utf8 = Border.Utf8(path)) Jobs.Follow(Library.lumivox_volume_save(handle.Pointer, utf8), saved, job => true);
            return saved.Task;
        }

        /// <summary>The scan of a file that <see cref="Save"/> or the editor has written.</summary>
        /// <exception cref="LumivoxException">It cannot be read.</exception>
        public static Task<LumivoxVolumeAsset> LoadFile(string path)
        {
            MainThread.Need("LumivoxVolumeAsset.LoadFile");
            Border.Need();
            var loaded = new TaskCompletionSource<LumivoxVolumeAsset>();
            fixed (byte* utf8 = Border.Utf8(path)) Jobs.Follow(Library.lumivox_volume_open(utf8), loaded, job => Of(job.TakeVolume()));
            return loaded.Task;
        }

        /// <summary>
        /// A scan that is computed: "head" is an anatomical CT of a head, "torso" one of a torso (without a table), "cube" a
        /// test body whose values rise from its corners to its centre. `size` is the number of voxels along a side, 8 to 1024; 0 stands for 128. It is made by
        /// another thread when something shows it, and anew whenever it is asked for again.
        /// </summary>
        /// <exception cref="LumivoxException">There is no such kind or size.</exception>
        public static LumivoxVolumeAsset Phantom(string kind, int size = 0)
        {
            if (size == 0) size = 128;
            if (size < 8 || size > 1024) throw new LumivoxException($"A phantom has 8 to 1024 voxels along a side, not {size}.");
            if (kind != "head" && kind != "torso" && kind != "cube") throw new LumivoxException($"There is no phantom '{kind}'. There are \"head\", \"torso\" and \"cube\".");
            var asset = CreateInstance<LumivoxVolumeAsset>();
            asset.name = kind;
            asset.m_Phantom = kind;
            asset.m_PhantomSize = size;
            return asset;
        }

        /// <summary>The same phantom with so many voxels at most; null where it is none.</summary>
        internal LumivoxVolumeAsset SmallPhantom(int size) => m_Phantom != "" ? Phantom(m_Phantom, Mathf.Min(size, m_PhantomSize)) : null;

        /// <summary>A scan of the voxels of a script, copied: x fastest, in the scan's rows and slices.</summary>
        /// <param name="dimensions">Voxels along x, y and z.</param>
        /// <param name="voxels">Bytes, 16-bit numbers or floats.</param>
        /// <param name="slope">Multiplies them to values.</param>
        /// <param name="intercept">Is added to them then.</param>
        /// <param name="patientFromVoxel">Three columns and the translation: millimetres towards left, back and head.</param>
        /// <param name="modality">`CT`, `MR`, `PT` or nothing.</param>
        /// <exception cref="LumivoxException">They are no scan.</exception>
        public static LumivoxVolumeAsset Create<T>(Vector3Int dimensions, ReadOnlySpan<T> voxels, double slope, double intercept, ReadOnlySpan<double> patientFromVoxel, string modality = "") where T : unmanaged
        {
            Border.Need();
            if (patientFromVoxel.Length != 12) throw new LumivoxException($"patientFromVoxel has 12 numbers (three columns and the translation), not {patientFromVoxel.Length}.");
            if (dimensions.x < 1 || dimensions.y < 1 || dimensions.z < 1) throw new LumivoxException($"A scan of {dimensions.x} x {dimensions.y} x {dimensions.z} voxels holds nothing.");
            var dims = stackalloc uint[] { (uint)dimensions.x, (uint)dimensions.y, (uint)dimensions.z };
            var kind = (uint)Math.Max(0, Array.IndexOf(modalities, modality));
            // Not the spans themselves, which Mono's class library for .NET Framework does not let be pinned.
            fixed (T* data = &MemoryMarshal.GetReference(voxels))
            fixed (double* place = &MemoryMarshal.GetReference(patientFromVoxel))
                return Of(new VolumeHandle(Border.Checked(Library.lumivox_volume_new(dims, (uint)sizeof(T), data, (ulong)voxels.Length * (ulong)sizeof(T), slope, intercept, place, kind))));
        }

        /// <summary>Copies the file of a stored scan without what tells where the scan was read from.</summary>
        internal static void CopyNameless(string from, string to)
        {
            Border.Need();
            fixed (byte* source = Border.Utf8(from), target = Border.Utf8(to)) Border.Checked(Library.lumivox_stored_copy_nameless(source, target));
        }

        static readonly string[] modalities = { "", "CT", "MR", "PT" };

        /// <summary>For the native library; zero while it is not open.</summary>
        internal IntPtr Pointer => handle != null ? handle.Pointer : IntPtr.Zero;

        internal VolumeHandle Handle => handle;

        /// <summary>Something shows it from now on.</summary>
        internal void Retain()
        {
            users++;
            unused.Remove(this);
            if (currentState == LumivoxVolumeState.Closed && !isEmpty) Open();
        }

        /// <summary>Something shows it no longer. What can be read again does not stay long.</summary>
        internal void Release()
        {
            users = Math.Max(0, users - 1);
            if (users > 0 || !isStored || handle == null || unused.Contains(this)) return;
            unusedSince = Time.realtimeSinceStartup;
            unused.Add(this);
        }

        /// <summary>Closes what nothing has shown for a while.</summary>
        internal static void CloseUnused(float afterSeconds)
        {
            for (var i = unused.Count - 1; i >= 0; i--)
            {
                var asset = unused[i];
                if (asset != null && asset.users == 0 && Time.realtimeSinceStartup - asset.unusedSince < afterSeconds) continue;
                unused.RemoveAt(i);
                if (asset != null && asset.users == 0) asset.Close();
            }
        }

        /// <summary>A scan that was made at run time.</summary>
        internal static LumivoxVolumeAsset Of(VolumeHandle made)
        {
            var asset = CreateInstance<LumivoxVolumeAsset>();
            asset.Adopt(made);
            asset.name = asset.scanName;
            return asset;
        }

        /// <summary>What the editor keeps of a scan whose file is stored under an id.</summary>
        internal static LumivoxVolumeAsset Stored(string id, VolumeHandle made)
        {
            var asset = CreateInstance<LumivoxVolumeAsset>();
            asset.Describe(made);
            asset.m_StoredId = id;
            asset.name = asset.scanName;
            return asset;
        }

        /// <summary>The id of its file; empty where it has none.</summary>
        internal string StoredId => m_StoredId;

        /// <summary>Reads its file again, which has become another.</summary>
        internal void Reopen()
        {
            Close();
            if (users > 0) Open();
        }

        static IntPtr StartPhantom(string kind, int size)
        {
            fixed (byte* utf8 = Border.Utf8(kind)) return Library.lumivox_phantom_start(utf8, (uint)size);
        }

        void OpenStored()
        {
#if UNITY_EDITOR
            OpenFile(EditorFile != null ? EditorFile(m_StoredId) : Path.Combine("Library", "Lumivox", m_StoredId + FileExtension));
#elif UNITY_ANDROID || UNITY_WEBGL
            OpenPacked($"{Application.streamingAssetsPath}/{StreamingFolder}/{m_StoredId}{FileExtension}");
#else
            OpenFile(Path.Combine(Application.streamingAssetsPath, StreamingFolder, m_StoredId + FileExtension));
#endif
        }

        void OpenFile(string path)
        {
            if (string.IsNullOrEmpty(path))
            {
                Fail("Its file is not in the project any more. Import the scan again.");
                return;
            }
            if (!File.Exists(path))
            {
                Fail($"The scan's file is not there: {path}. Import the scan again, or build the player again.");
                return;
            }
            fixed (byte* utf8 = Border.Utf8(path)) Follow(Library.lumivox_volume_open(utf8));
        }

        void Follow(IntPtr job)
        {
            if (job == IntPtr.Zero)
            {
                Fail(Border.LastError());
                return;
            }
            currentState = LumivoxVolumeState.Loading;
            currentError = "";
            opening = Jobs.Follow(job, Opened);
            changed?.Invoke();
        }

        void Opened(Job job, JobState state)
        {
            if (job != opening) return;
            opening = null;
            if (state != JobState.Done)
            {
                Fail(state == JobState.Cancelled ? "It was stopped while it was read." : job.Error);
                return;
            }
            VolumeHandle made;
            try
            {
                made = job.TakeVolume();
            }
            catch (LumivoxException error)
            {
                Fail(error.Message);
                return;
            }
            Adopt(made);
            if (users == 0) Release();
        }

        void Adopt(VolumeHandle made)
        {
            handle?.Dispose();
            handle = made;
            Describe(made);
            currentState = LumivoxVolumeState.Ready;
            currentError = "";
            LumivoxRuntime.RequestFrames();
            Told(true);
        }

        void Describe(VolumeHandle made)
        {
            var info = made.Info;
            var bounds = new Bounds();
            bounds.SetMinMax(info.boundsMin, info.boundsMax);
            m_Summary = new Summary
            {
                dimensions = new Vector3Int((int)info.dimensions[0], (int)info.dimensions[1], (int)info.dimensions[2]),
                spacingMm = new Vector3((float)info.spacingMm[0], (float)info.spacingMm[1], (float)info.spacingMm[2]),
                valueRange = new Vector2((float)info.valueRange[0], (float)info.valueRange[1]),
                bounds = bounds,
                objectFromClip = info.objectFromClip,
                objectFromPatient = info.objectFromPatient,
                unit = Unit(info),
                modality = info.modality < modalities.Length ? modalities[info.modality] : "",
                isHounsfield = info.isHounsfield != 0,
                hasSurroundings = info.hasSurroundings != 0,
            };
            m_Report = Border.TakeText(Library.lumivox_volume_report(made.Pointer)) ?? "";
            m_Labels = LabelsOf(made.Pointer);
        }

        static string Unit(in VolumeInfo info)
        {
            fixed (byte* unit = info.unit)
            {
                var length = 0;
                while (length < 16 && unit[length] != 0) length++;
                return Encoding.UTF8.GetString(unit, length);
            }
        }

        void Fail(string why)
        {
            currentState = LumivoxVolumeState.Failed;
            currentError = why;
            if (why != Border.Fault) Debug.LogError($"The scan '{name}' cannot be shown: {why}", this);
            Told(false);
        }

        /// <summary>Whoever waits hears of the end, though a listener throws.</summary>
        void Told(bool isOpen)
        {
            var waiting = opened;
            opened = null;
            try
            {
                changed?.Invoke();
            }
            finally
            {
                waiting?.TrySetResult(isOpen);
            }
        }

        void Close()
        {
            opening?.Cancel();
            opening = null;
            ForgetSkin();
            ForgetParts();
            handle?.Dispose();
            handle = null;
            currentState = LumivoxVolumeState.Closed;
            currentError = "";
            var waiting = opened;
            opened = null;
            waiting?.TrySetResult(false);
        }

        void OnDisable()
        {
            users = 0;
            unused.Remove(this);
            Close();
        }
    }
}
