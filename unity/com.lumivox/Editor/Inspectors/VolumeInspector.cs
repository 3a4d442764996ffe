using System.Collections.Generic;
using System.Linq;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>Shows a volume's properties with its presets, ways to a scan, and what is wrong; and its handles in the scene.</summary>
    [CustomEditor(typeof(LumivoxVolume)), CanEditMultipleObjects]
    sealed class VolumeInspector : UnityEditor.Editor
    {
        static readonly string[] medium = { "m_Density", "m_Albedo", "m_Anisotropy", "m_MaxBounces", "m_Filter", "m_ExtinctionSpace" };
        static readonly string[] surface = { "m_SurfaceStrength", "m_SurfaceGradient", "m_SurfaceRoughness", "m_SurfaceSpecular", "m_SurfaceMetallic" };
        static readonly string[] parts = { "m_Labels", "m_KeepEverything", "m_PeelMm" };
        static readonly string[] clip = { "m_ClipMin", "m_ClipMax" };

        readonly ClipHandles handles = new ClipHandles();
        VisualElement warnings, start;
        Button find, looks;
        Label finding;
        PresetField preset;
        string shown = "";

        List<LumivoxVolume> Volumes => targets.OfType<LumivoxVolume>().ToList();

        public override VisualElement CreateInspectorGUI()
        {
            var root = new VisualElement();
            warnings = new VisualElement { name = "warnings" };
            shown = "";
            root.Add(warnings);
            start = Start();
            root.Add(start);
            root.Add(new PropertyField(serializedObject.FindProperty("m_Volume")));
            root.Add(new PropertyField(serializedObject.FindProperty("m_TransferFunction")));
            var edit = new Button(() => TransferFunctionWindow.Open()) { name = "edit", text = "Edit Transfer Function", tooltip = "Opens the window that follows the selected volume." };
            root.Add(edit);
            preset = Presets();
            root.Add(preset);
            root.Add(preset.gallery);
            foreach (var group in new[] { medium, surface, parts })
                foreach (var name in group) root.Add(new PropertyField(serializedObject.FindProperty(name)));
            root.Add(Parts());
            foreach (var name in clip) root.Add(new PropertyField(serializedObject.FindProperty(name)));
            root.TrackSerializedObjectValue(serializedObject, _ => Show());
            // The scan arrives, and the GPU runs short, without a change of any property.
            root.schedule.Execute(Show).Every(500);
            Show();
            return root;
        }

        /// For one that has nothing to show yet.
        VisualElement Start()
        {
            var row = new VisualElement { name = "start" };
            row.style.flexDirection = FlexDirection.Row;
            var scan = new Button(ImportScan) { name = "import", text = "Import a Scan...", tooltip = "A folder of DICOM files. Other files: Assets > Lumivox > Import Scan File." };
            var phantom = new Button(UsePhantom) { name = "phantom", text = "Try a Phantom", tooltip = "The CT of a head, which is computed." };
            scan.style.flexGrow = phantom.style.flexGrow = 1;
            row.Add(scan);
            row.Add(phantom);
            return row;
        }

        /// Ways to labels and to clips.
        VisualElement Parts()
        {
            var all = new VisualElement { name = "parts" };
            var row = new VisualElement();
            row.style.flexDirection = FlexDirection.Row;
            find = new Button(Find) { name = "find", text = "Find Labels", tooltip = "Finds the parts of the scan by itself (of a CT the body, lungs, airways and gas, table and clothes; of an MR the body), and saves them beside it." };
            looks = new Button(EditLooks) { name = "looks", text = "Edit Looks", tooltip = "The looks of imported labels are made anew with each import: this makes an asset of them that can be edited." };
            var cut = new Button(AddClip) { name = "add-clip", text = "Add Clip", tooltip = "Adds a plane that cuts the volume open; its object can be moved and turned." };
            foreach (var button in new[] { find, looks, cut })
            {
                button.style.flexGrow = 1;
                row.Add(button);
            }
            finding = new Label { name = "finding" };
            finding.style.whiteSpace = WhiteSpace.Normal;
            finding.style.opacity = 0.7f;
            all.Add(row);
            all.Add(finding);
            return all;
        }

        void Find()
        {
            if (LabelActions.IsFinding) LabelActions.Cancel();
            else LabelActions.Find(Volumes[0], problem => { if (problem != null) Debug.LogWarning($"No labels were found: {problem}"); });
            Show();
        }

        void EditLooks()
        {
            LabelActions.EditLooks(Volumes);
            Show();
        }

        void AddClip()
        {
            foreach (var volume in Volumes) VolumeActions.CreateClip(volume.gameObject);
        }

        void ImportScan()
        {
            var path = EditorUtility.OpenFolderPanel("Import a DICOM folder", "", "");
            if (!string.IsNullOrEmpty(path)) ImportWindow.Open(path, Volumes[0]);
        }

        void UsePhantom()
        {
            var scan = VolumeActions.Phantom();
            foreach (var volume in Volumes) VolumeActions.GiveVolume(volume, scan);
            Show();
        }

        PresetField Presets()
        {
            var field = new PresetField("Preset", () => Volumes.Select(volume => volume.volume).FirstOrDefault(scan => scan != null))
            {
                tooltip = serializedObject.FindProperty("m_Preset").tooltip,
            };
            field.RegisterValueChangedCallback(e =>
            {
                if (e.target != field) return;
                VolumeActions.ApplyPreset(Volumes, e.newValue);
                serializedObject.Update();
                Show();
            });
            return field;
        }

        void Show()
        {
            if (targets.Any(one => one == null)) return;
            var property = serializedObject.FindProperty("m_Preset");
            if (property.hasMultipleDifferentValues) preset.ShowSeveral();
            else preset.SetValueWithoutNotify(property.stringValue);
            start.style.display = Volumes.All(volume => volume.volume == null || volume.volume.isEmpty) ? DisplayStyle.Flex : DisplayStyle.None;
            ShowParts();
            ShowWarnings();
        }

        void ShowParts()
        {
            var isOpen = Volumes.Count == 1 && Volumes[0].volume != null && Volumes[0].volume.state == LumivoxVolumeState.Ready;
            find.text = LabelActions.IsFinding ? "Stop" : "Find Labels";
            find.SetEnabled(LabelActions.IsFinding || isOpen);
            looks.style.display = Volumes.Any(volume => LabelActions.AreImported(volume.labels)) ? DisplayStyle.Flex : DisplayStyle.None;
            finding.text = LabelActions.State.Length > 0 ? LabelActions.State : Volumes.Select(volume => volume.Preparing).FirstOrDefault(text => text.Length > 0) ?? "";
            finding.style.display = finding.text.Length > 0 ? DisplayStyle.Flex : DisplayStyle.None;
        }

        void ShowWarnings()
        {
            var lines = Volumes.SelectMany(volume => volume.GetWarnings().Select(text => targets.Length > 1 ? $"{volume.name}: {text}" : text)).ToList();
            var all = string.Join("\n", lines);
            if (all == shown) return;
            shown = all;
            warnings.Clear();
            foreach (var line in lines) warnings.Add(new HelpBox(line, HelpBoxMessageType.Warning));
        }

        /// Before scripts are loaded anew, which pictures would outlive.
        void OnDisable() => preset?.gallery.Fold();

        void OnSceneGUI() => handles.Draw((LumivoxVolume)target);
    }
}
