using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>Whether a file is a scan, or a map of labels.</summary>
    public enum LumivoxLabelMaps
    {
        /// <summary>A scan.</summary>
        No = 0,
        /// <summary>A map of labels; one that is none is an error.</summary>
        Yes = 1,
        /// <summary>What it looks like: nothing says what made it, and its values are few whole numbers, mostly those of their neighbours.</summary>
        Automatic = 2,
    }

    /// <summary>What to load where there is a choice.</summary>
    public sealed class LumivoxImportOptions
    {
        /// <summary>Which series of a DICOM study: its position from 1, its SeriesInstanceUID or its number.</summary>
        public string series;
        /// <summary>Which volume of a series with several, counted from 1; 0: the first that is whole.</summary>
        public int phase;
        /// <summary>Whether slices that are missing stay empty.</summary>
        public bool leaveGaps;
        /// <summary>Whether slices that are damaged are filled in.</summary>
        public bool fillDamaged;
        /// <summary>Whether a header such as .mhd may name data files anywhere, not only beside it or below.</summary>
        public bool allowOutsideData;
        /// <summary>
        /// Whether what lies around the patient in a CT is a part of the scan: the table, clothes, cables. Otherwise it is put
        /// aside, where it can be told from the patient for sure, and the report says so:
        /// <see cref="LumivoxVolume.keepEverything"/> shows it.
        /// </summary>
        public bool keepEverything;
        /// <summary>Whether the file is a label map, which then is a scan whose <see cref="LumivoxVolumeAsset.isLabelMap"/> says so.</summary>
        public LumivoxLabelMaps labelMaps;
        /// <summary>What a RAW file holds, such as `256x256x108:i16le:spacing=1,1,2`.</summary>
        public string raw;
    }

    /// <summary>How far an import is.</summary>
    public readonly struct LumivoxProgress
    {
        /// <summary>A phrase for people; stages follow each other, and each counts anew.</summary>
        public readonly string stage;
        /// <summary>Steps of this stage that are done, and how many there are.</summary>
        public readonly long done, total;

        internal LumivoxProgress(string stage, long done, long total)
        {
            this.stage = stage;
            this.done = done;
            this.total = total;
        }

        /// <summary>The part of this stage that is done, from 0 to 1.</summary>
        public float fraction => total > 0 ? Mathf.Clamp01((float)((double)done / total)) : 0f;
    }

    /// <summary>
    /// Loads scans without holding up the game: DICOM files, folders and zip archives, NIfTI, NRRD, MetaImage and RAW.
    /// </summary>
    /// <remarks>
    /// Events are raised on the main thread, outside of rendering. One importer does one thing at a time; a load of what
    /// it has scanned before does not read the headers again.
    /// <code>
    /// using (var importer = new LumivoxImporter())
    ///     GetComponent&lt;LumivoxVolume&gt;().volume = await importer.Load(new[] { path });
    /// </code>
    /// </remarks>
    public sealed unsafe class LumivoxImporter : IDisposable
    {
        Job job;
        Job picture;
        StudyHandle study;
        string[] studied = Array.Empty<string>();
        string studiedRaw;
        int seriesCount;

        /// <summary>How far it is, at most once per frame.</summary>
        public event Action<LumivoxProgress> progressed;

        /// <summary>What <see cref="Scan"/> was asked for is known.</summary>
        public event Action<LumivoxReport> scanned;

        /// <summary>What <see cref="Load"/> was asked for is loaded; it is saved nowhere yet.</summary>
        public event Action<LumivoxVolumeAsset> finished;

        /// <summary>A scan or an import came to nothing; the message names files, but no patient.</summary>
        public event Action<string> failed;

        /// <summary>A scan or an import was stopped by <see cref="Cancel"/>.</summary>
        public event Action cancelled;

        /// <summary>Whether a scan or an import is under way.</summary>
        public bool isRunning => job != null;

        /// <summary>Finds out what paths hold, from the headers of DICOM files alone.</summary>
        /// <exception cref="LumivoxException">It is busy, there are no paths, or, from the task, they cannot be read.</exception>
        public Task<LumivoxReport> Scan(IEnumerable<string> paths, LumivoxImportOptions options = null, CancellationToken cancel = default)
        {
            var (list, chosen) = Begin(paths, options);
            var task = new TaskCompletionSource<LumivoxReport>();
            Start(list, chosen, isScan: true, (ended, state) =>
            {
                if (Gave(task, ended, state) || !Took(task, () => LumivoxReport.FromJson(ended.Report), out var report)) return;
                if (!Took(task, () => new StudyHandle(Border.Checked(Library.lumivox_job_take_study(ended.Pointer))), out study)) return;
                (studied, studiedRaw, seriesCount) = (list, chosen.raw, report.series.Length);
                // Whoever waits hears of the end, though a listener throws.
                try
                {
                    scanned?.Invoke(report);
                }
                finally
                {
                    task.TrySetResult(report);
                }
            }, cancel);
            return task.Task;
        }

        /// <summary>Loads the scan in paths: one file, one folder, one archive, or several DICOM files.</summary>
        /// <exception cref="LumivoxException">It is busy, there are no paths, or, from the task, they cannot be read.</exception>
        public Task<LumivoxVolumeAsset> Load(IEnumerable<string> paths, LumivoxImportOptions options = null, CancellationToken cancel = default)
        {
            var (list, chosen) = Begin(paths, options);
            var task = new TaskCompletionSource<LumivoxVolumeAsset>();
            Start(list, chosen, isScan: false, (ended, state) =>
            {
                if (Gave(task, ended, state) || !Took(task, () => LumivoxVolumeAsset.Of(ended.TakeVolume()), out var volume)) return;
                try
                {
                    finished?.Invoke(volume);
                }
                finally
                {
                    task.TrySetResult(volume);
                }
            }, cancel);
            return task.Task;
        }

        /// <summary>Loads a segmentation: a DICOM SEG file or a folder with one, a NIfTI, NRRD or MetaImage file of labels.</summary>
        /// <exception cref="LumivoxException">It is busy, there are no paths, or, from the task, they cannot be read or hold no labels.</exception>
        public Task<LumivoxLabels> LoadLabels(IEnumerable<string> paths, LumivoxImportOptions options = null, CancellationToken cancel = default)
        {
            var (list, chosen) = Begin(paths, options);
            var task = new TaskCompletionSource<LumivoxLabels>();
            Start(list, chosen, isScan: false, (ended, state) => TakeLabels(task, ended, state), cancel, LumivoxLabelMaps.Yes);
            return task.Task;
        }

        /// <summary>
        /// Finds the parts of a scan by itself: of a CT the body, lungs, airways and gas, table and clothes; of an MR the body.
        /// The report of the map says how sure that is.
        /// </summary>
        /// <exception cref="LumivoxException">It is busy, or the scan is not open.</exception>
        public Task<LumivoxLabels> FindLabels(LumivoxVolumeAsset volume, CancellationToken cancel = default)
        {
            MainThread.Need("A LumivoxImporter");
            if (job != null) throw new LumivoxException("This importer is busy: wait for it, cancel it, or take another.");
            if (volume == null || volume.Pointer == IntPtr.Zero) throw new LumivoxException("Labels cannot be found in a scan that is not open: open it first.");
            var task = new TaskCompletionSource<LumivoxLabels>();
            Follow(Library.lumivox_labels_find(volume.Pointer), (ended, state) => TakeLabels(task, ended, state), cancel);
            return task.Task;
        }

        void TakeLabels(TaskCompletionSource<LumivoxLabels> task, Job ended, JobState state)
        {
            if (Gave(task, ended, state) || !Took(task, () => LumivoxLabels.Of(LumivoxVolumeAsset.Of(ended.TakeVolume())), out var labels)) return;
            task.TrySetResult(labels);
        }

        /// <summary>
        /// The middle slice of a series that <see cref="Scan"/> has found, as a grey picture of at most `size` pixels
        /// along a side, 1 to 4096; `series` is its place in the report, from 0. Null if the slice cannot be decoded. A
        /// picture that is not done gives way to the next: its task is cancelled.
        /// </summary>
        /// <exception cref="LumivoxException">There is no such series: before a scan there is none.</exception>
        public Task<Texture2D> RequestThumbnail(int series, int size = 128)
        {
            MainThread.Need("LumivoxImporter.RequestThumbnail");
            if (study == null || series < 0 || series >= seriesCount) throw new LumivoxException($"There is no series {series} to picture: scan first, and count from 0.");
            picture?.Cancel();
            var task = new TaskCompletionSource<Texture2D>();
            picture = Jobs.Follow(Library.lumivox_study_thumbnail(study.Pointer, (uint)series, (uint)Mathf.Clamp(size, 1, 4096)), (ended, state) =>
            {
                if (picture == ended) picture = null;
                if (state == JobState.Cancelled) task.TrySetCanceled();
                else if (state != JobState.Done) task.TrySetResult(null);
                else if (Jobs.Try(task, ended.Picture, out var made)) task.TrySetResult(made);
            });
            return task.Task;
        }

        /// <summary>Stops what is under way; <see cref="cancelled"/> follows in a later frame.</summary>
        public void Cancel()
        {
            picture?.Cancel();
            job?.Cancel();
        }

        /// <summary>Stops what is under way, and forgets what was scanned.</summary>
        public void Dispose()
        {
            Cancel();
            study?.Dispose();
            study = null;
        }

        /// <summary>Waits for what is under way, here and now: for importers of the editor.</summary>
        internal void Wait(Action<Job> step = null)
        {
            if (job != null) Jobs.Wait(job, step);
        }

        (string[], LumivoxImportOptions) Begin(IEnumerable<string> paths, LumivoxImportOptions options)
        {
            MainThread.Need("A LumivoxImporter");
            if (job != null) throw new LumivoxException("This importer is busy: wait for it, cancel it, or take another.");
            Border.Need();
            var list = new List<string>();
            foreach (var path in paths ?? Array.Empty<string>())
                if (!string.IsNullOrEmpty(path)) list.Add(path);
            if (list.Count == 0) throw new LumivoxException("There is nothing to read: name a file, a folder or an archive.");
            return (list.ToArray(), options ?? new LumivoxImportOptions());
        }

        void Start(string[] paths, LumivoxImportOptions options, bool isScan, Action<Job, JobState> ended, CancellationToken cancel, LumivoxLabelMaps? labelMaps = null)
        {
            picture?.Cancel();
            if (study != null && !IsStudied(paths, options)) ForgetStudy();
            if (isScan) ForgetStudy();
            var texts = Array.ConvertAll(paths, Border.Utf8);
            var pins = new System.Runtime.InteropServices.GCHandle[texts.Length];
            var pointers = new IntPtr[texts.Length];
            try
            {
                for (var i = 0; i < texts.Length; i++)
                {
                    pins[i] = System.Runtime.InteropServices.GCHandle.Alloc(texts[i], System.Runtime.InteropServices.GCHandleType.Pinned);
                    pointers[i] = pins[i].AddrOfPinnedObject();
                }
                fixed (byte* series = Border.Utf8(options.series), raw = Border.Utf8(options.raw))
                fixed (IntPtr* list = pointers)
                {
                    var native = new ImportOptions
                    {
                        series = series,
                        phase = (uint)Math.Max(0, options.phase),
                        leaveGaps = options.leaveGaps ? 1u : 0u,
                        fillDamaged = options.fillDamaged ? 1u : 0u,
                        allowOutsideData = options.allowOutsideData ? 1u : 0u,
                        keepEverything = options.keepEverything ? 1u : 0u,
                        labels = (uint)(labelMaps ?? options.labelMaps),
                        raw = raw,
                    };
                    var pointer = isScan
                        ? Library.lumivox_import_scan((byte**)list, (uint)texts.Length, &native)
                        : Library.lumivox_import_load((byte**)list, (uint)texts.Length, &native, study != null ? study.Pointer : IntPtr.Zero);
                    Follow(pointer, ended, cancel);
                }
            }
            finally
            {
                foreach (var pin in pins)
                    if (pin.IsAllocated) pin.Free();
            }
        }

        void Follow(IntPtr pointer, Action<Job, JobState> ended, CancellationToken cancel)
        {
            // A token may live for ever, and would hold what was loaded.
            CancellationTokenRegistration registration = default;
            var started = job = Jobs.Follow(pointer, (of, state) =>
            {
                registration.Dispose();
                ended(of, state);
            });
            started.Progressed += of => progressed?.Invoke(new LumivoxProgress(of.Stage, of.Done, of.Total));
            if (cancel.CanBeCanceled) registration = cancel.Register(() => started.Cancel());
        }

        bool IsStudied(string[] paths, LumivoxImportOptions options) =>
            options.raw == studiedRaw && System.Linq.Enumerable.SequenceEqual(paths, studied);

        void ForgetStudy()
        {
            study?.Dispose();
            study = null;
            seriesCount = 0;
        }

        /// <summary>Whether what a job gave could be taken; if not, that is told here.</summary>
        bool Took<T, TTask>(TaskCompletionSource<TTask> task, Func<T> take, out T taken)
        {
            if (Jobs.Try(task, take, out taken)) return true;
            failed?.Invoke(task.Task.Exception.GetBaseException().Message);
            return false;
        }

        /// <summary>Whether a job came to nothing, which is told here.</summary>
        bool Gave<T>(TaskCompletionSource<T> task, Job ended, JobState state)
        {
            job = null;
            if (state == JobState.Done) return false;
            if (state == JobState.Cancelled)
            {
                try
                {
                    cancelled?.Invoke();
                }
                finally
                {
                    task.TrySetCanceled();
                }
                return true;
            }
            var message = ended.Error;
            try
            {
                failed?.Invoke(message);
            }
            finally
            {
                task.TrySetException(new LumivoxException(message));
            }
            return true;
        }
    }
}
