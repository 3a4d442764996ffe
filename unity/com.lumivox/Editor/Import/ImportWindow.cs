using System;
using System.IO;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>
    /// 'Import a Scan': what a folder, archive or file holds, which series of it, and where in the project it goes. Reading
    /// and saving go on in the background; the editor stays usable.
    /// </summary>
    public sealed partial class ImportWindow : EditorWindow
    {
        internal enum Step { Choose, Scanning, Ready, Importing, Saving }

        const int ThumbnailSize = 160;

        [SerializeField] string m_Path = "";
        [SerializeField] LumivoxVolume m_Receiver;
        LumivoxImporter importer;
        /// A reload of the scripts would make an empty one of none, and keep a scan whose voxels are gone.
        [NonSerialized] LumivoxReport report;
        Texture2D picture;
        /// The path that was proposed last, until somebody writes another.
        string suggested = "";
        /// Which picture is waited for.
        int pictureAsked;
        /// Whether the path is to be looked at when the window has its contents, which come later while files are imported.
        [NonSerialized] bool isAwaited;

        internal Step Now { get; private set; }
        internal LumivoxReport Report => report;

        /// <summary>Opens the window and looks at a folder or a file, unless something is under way.</summary>
        public static ImportWindow Open(string path, LumivoxVolume receiver = null)
        {
            var window = GetWindow<ImportWindow>(false, "Import a Scan");
            window.minSize = new Vector2(560, 420);
            window.Take(path, receiver);
            return window;
        }

        bool Works => Now == Step.Scanning || Now == Step.Importing || Now == Step.Saving;

        void Take(string path, LumivoxVolume receiver)
        {
            if (Works)
            {
                AddProblem($"{NameOf(path)} was not opened: one scan at a time. Open it again when this one is done{(Now == Step.Saving ? "" : ", or stopped")}.");
                return;
            }
            (m_Receiver, m_Path) = (receiver, path ?? "");
            isAwaited = pathField == null;
            if (isAwaited) return;
            ShowReceiver();
            pathField.SetValueWithoutNotify(m_Path);
            rawField.SetValueWithoutNotify("");
            Distrust();
            if (m_Path != "") Scan();
            else Go(Step.Choose);
        }

        /// Before scripts are loaded anew, too, which pictures would outlive.
        void OnDisable() => ForgetPicture();

        void OnDestroy()
        {
            // What is being saved is saved all the same: nobody else has it.
            if (importer != null)
            {
                importer.Dispose();
                importer = null;
            }
            ForgetUnsaved();
        }

        /// What a folder or a file is called.
        static string NameOf(string path) => Path.GetFileName((path ?? "").TrimEnd('/', '\\'));

        LumivoxImporter Importer
        {
            get
            {
                if (importer != null) return importer;
                importer = new LumivoxImporter();
                importer.progressed += OnProgress;
                importer.scanned += OnScanned;
                importer.finished += OnFinished;
                importer.failed += OnFailed;
                importer.cancelled += OnCancelled;
                return importer;
            }
        }

        internal void Scan()
        {
            Forget();
            m_Path = pathField.value.Trim();
            if (!Directory.Exists(m_Path) && !File.Exists(m_Path))
            {
                ShowProblem(m_Path == "" ? "Choose a folder or a file." : $"There is no folder or file '{m_Path}'.");
                Go(Step.Choose);
                return;
            }
            rawField.style.display = NeedsDescription(m_Path) ? DisplayStyle.Flex : DisplayStyle.None;
            outsideField.style.display = Path.GetExtension(m_Path).ToLowerInvariant() is ".mhd" or ".nhdr" ? DisplayStyle.Flex : DisplayStyle.None;
            Start(Step.Scanning, $"Looking at {NameOf(m_Path)}", () => EditorWork.Forget(Importer.Scan(new[] { m_Path }, Options())));
        }

        /// Whether a file may say nothing of what it holds.
        static bool NeedsDescription(string path)
        {
            path = path.ToLowerInvariant();
            return path.EndsWith(".raw") || path.EndsWith(".gz") && !path.EndsWith(".nii.gz");
        }

        LumivoxImportOptions Options()
        {
            var options = new LumivoxImportOptions { leaveGaps = gapsField.value, fillDamaged = damagedField.value, keepEverything = everythingField.value };
            if (rawField.style.display == DisplayStyle.Flex && rawField.value.Trim() != "") options.raw = rawField.value.Trim();
            if (outsideField.style.display == DisplayStyle.Flex) options.allowOutsideData = outsideField.value;
            return options;
        }

        void Start(Step step, string text, Action work)
        {
            Go(step);
            stage.text = text;
            bar.value = 0;
            try
            {
                work();
            }
            catch (LumivoxException error)
            {
                OnFailed(error.Message);
            }
        }

        void OnProgress(LumivoxProgress progress)
        {
            stage.text = progress.stage;
            bar.value = progress.fraction * 100;
            bar.title = progress.total > 0 ? $"{progress.done} of {progress.total}" : "";
        }

        void OnScanned(LumivoxReport found)
        {
            report = found;
            list.itemsSource = report.series;
            list.Rebuild();
            Go(Step.Ready);
            stage.text = report.series.Length == 1 ? "One series" : $"{report.series.Length} series";
            list.SetSelection(report.series.Length > 0 ? Mathf.Clamp(report.chosen, 0, report.series.Length - 1) : -1);
            if (report.series.Length == 0) ShowDetails();
        }

        int Selected => report != null && list.selectedIndex >= 0 && list.selectedIndex < report.series.Length ? list.selectedIndex : -1;

        void OnSeriesSelected()
        {
            var place = Selected;
            ForgetPicture();
            if (place >= 0 && targetField.value == suggested)
            {
                suggested = ScanSaver.FreePath(report.series[place].name, "Assets");
                targetField.SetValueWithoutNotify(suggested);
            }
            var phases = place >= 0 ? report.series[place].phases : 1;
            phaseField.highValue = Math.Max(phases, 1);
            phaseField.SetValueWithoutNotify(1);
            phaseField.style.display = phases > 1 ? DisplayStyle.Flex : DisplayStyle.None;
            ShowDetails();
            if (place >= 0) AskForPicture(place);
            Go(Now);
        }

        /// Of a large compressed file it takes long; the one that was asked for before is not waited for.
        void AskForPicture(int place)
        {
            var asked = ++pictureAsked;
            try
            {
                var task = Importer.RequestThumbnail(place, ThumbnailSize);
                task.ContinueWith(done =>
                {
                    if (done.IsCanceled || done.IsFaulted || done.Result == null) return;
                    if (asked != pictureAsked || importer == null)
                    {
                        DestroyImmediate(done.Result);
                        return;
                    }
                    picture = done.Result;
                    thumbnail.image = picture;
                }, System.Threading.Tasks.TaskContinuationOptions.ExecuteSynchronously);
            }
            catch (LumivoxException)
            {
                // A list without pictures is still a list.
            }
        }

        void ForgetPicture()
        {
            pictureAsked++;
            if (thumbnail != null) thumbnail.image = null;
            if (picture != null) DestroyImmediate(picture);
            picture = null;
        }

        internal void Import()
        {
            if (Now != Step.Ready || Selected < 0) return;
            targetField.value = ScanSaver.WithExtension(targetField.value);
            var target = targetField.value;
            if (!ScanSaver.IsTarget(target, out var problem))
            {
                ShowProblem(problem);
                return;
            }
            if (File.Exists(StoredScans.ProjectFile(target)) && !EditorUtility.DisplayDialog("Import a Scan", $"{target} is there already. Replace the scan in it?", "Replace", "Cancel")) return;
            var options = Options();
            if (report.format == "DICOM")
            {
                options.series = (Selected + 1).ToString(System.Globalization.CultureInfo.InvariantCulture);
                if (report.series[Selected].phases > 1) options.phase = phaseField.value;
            }
            savedAs = target;
            var wanted = $"{m_Path}|{options.series}|{options.phase}|{options.raw}|{options.leaveGaps}|{options.fillDamaged}|{options.allowOutsideData}|{options.keepEverything}";
            if (unsaved != null && wanted == imported)
            {
                // It was read already, and could not be written.
                OnFinished(unsaved);
                return;
            }
            ForgetUnsaved();
            imported = wanted;
            ForgetPicture();
            Start(Step.Importing, "Importing", () => EditorWork.Forget(Importer.Load(new[] { m_Path }, options)));
        }

        /// Where the scan that is imported will be saved, whatever the fields say meanwhile, and what was asked for.
        string savedAs = "", imported = "";
        /// What was read and could not be written: it is not read again to be saved elsewhere.
        [NonSerialized] LumivoxVolumeAsset unsaved;

        void ForgetUnsaved()
        {
            if (unsaved != null) DestroyImmediate(unsaved);
            unsaved = null;
        }

        void OnFinished(LumivoxVolumeAsset made)
        {
            Go(Step.Saving);
            stage.text = $"Saving {savedAs}";
            bar.value = 100;
            var path = savedAs;
            ScanSaver.Save(made, path, (asset, problem) => OnSaved(made, asset, problem));
        }

        void OnSaved(LumivoxVolumeAsset made, LumivoxVolumeAsset asset, string problem)
        {
            if (this == null)
            {
                // The window was closed meanwhile.
                if (problem != null) Debug.LogError($"Lumivox: {problem}");
                if (made != null) DestroyImmediate(made);
                return;
            }
            if (problem != null)
            {
                Go(Step.Ready);
                ShowProblem(problem);
                unsaved = made;
                return;
            }
            if (made != null) DestroyImmediate(made);
            unsaved = null;
            if (addField.value && m_Receiver != null) VolumeActions.GiveVolume(m_Receiver, asset);
            else if (addField.value) Selection.activeGameObject = VolumeActions.Create(asset, null).gameObject;
            else Selection.activeObject = asset;
            Forget();
            pathField.SetValueWithoutNotify(m_Path = "");
            m_Receiver = null;
            ShowReceiver();
            Go(Step.Choose);
            stage.text = $"{asset.name} is in the project.";
        }

        /// Stops what is under way, the picture of a series too.
        internal void Stop() => importer?.Cancel();

        void OnCancelled()
        {
            Go(Now == Step.Importing && report != null ? Step.Ready : Step.Choose);
            if (Now == Step.Ready) ShowDetails();
            stage.text = "Stopped";
        }

        void OnFailed(string message)
        {
            Go(Now == Step.Importing && report != null ? Step.Ready : Step.Choose);
            ShowProblem(message);
        }

        void Forget()
        {
            report = null;
            ForgetUnsaved();
            list.itemsSource = Array.Empty<LumivoxSeries>();
            list.Rebuild();
            targetField.SetValueWithoutNotify(suggested = "");
            details.text = "";
            problems.style.display = DisplayStyle.None;
            phaseField.style.display = DisplayStyle.None;
            ForgetPicture();
        }

        /// Trust in one header is none in the next.
        void Distrust() => outsideField.SetValueWithoutNotify(false);
    }
}
