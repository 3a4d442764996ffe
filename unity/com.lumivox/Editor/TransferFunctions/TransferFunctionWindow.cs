using System.Collections.Generic;
using System.Linq;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>The transfer-function editor in a window: follows the selected volume, or an asset, with undo.</summary>
    public sealed class TransferFunctionWindow : EditorWindow
    {
        TransferFunctionField field;
        TransferFunctionUndo undo;
        Label notice, message;
        LumivoxVolume volume;
        /// What a volume without a function of its own is shown with. The first edit makes it the volume's own.
        LumivoxTransferFunction suited;
        LumivoxVolumeAsset suitedTo;
        string suitedPreset = "";

        [MenuItem("Window/Lumivox/Transfer Function", false, 2400)]
        public static void Open()
        {
            var window = GetWindow<TransferFunctionWindow>(false, "Transfer Function");
            window.minSize = new Vector2(420, 300);
        }

        internal TransferFunctionField Field => field;

        void CreateGUI()
        {
            var root = rootVisualElement;
            notice = new Label { name = "notice" };
            notice.style.opacity = 0.8f;
            message = new Label { name = "message" };
            message.style.unityTextAlign = TextAnchor.MiddleCenter;
            message.style.whiteSpace = WhiteSpace.Normal;
            message.style.flexGrow = 1;
            field = new TransferFunctionField { appliesPresets = false };
            undo = new TransferFunctionUndo(field);
            undo.Begun += Adopt;
            field.presetChosen += OnPreset;
            FunctionFiles.AddTo(field);
            root.Add(notice);
            root.Add(field);
            root.Add(message);
            // Scan and function may be exchanged in the inspector at any time.
            root.schedule.Execute(Look).Every(200);
            undo.Listen(true);
            Selection.selectionChanged += Follow;
            Follow();
        }

        void OnDestroy()
        {
            Selection.selectionChanged -= Follow;
            undo?.Listen(false);
        }

        /// Also before scripts are loaded anew, which the function would outlive.
        void OnDisable()
        {
            field?.Gallery.Fold();
            if (field != null && suited != null && field.transferFunction == suited) field.transferFunction = null;
            ForgetSuited();
        }

        void Follow()
        {
            var functions = Selection.objects.OfType<LumivoxTransferFunction>().ToList();
            var volumes = Selected();
            if (volumes.Count > 0)
            {
                if (volumes[0] != volume) field.transferFunction = null;
                volume = volumes[0];
            }
            else if (functions.Count > 0)
            {
                volume = null;
                field.volume = VolumesOf.One(functions[0]);
                field.transferFunction = functions[0];
            }
            Look();
        }

        static List<LumivoxVolume> Selected() => Selection.gameObjects.Select(one => one.GetComponent<LumivoxVolume>()).Where(one => one != null).ToList();

        void Look()
        {
            if (field == null) return;
            if (volume == null && !ReferenceEquals(volume, null))
            {
                volume = null;
                field.transferFunction = null;
                field.volume = null;
            }
            if (volume != null)
            {
                var function = InForce();
                if (field.volume != volume.volume) field.volume = volume.volume;
                if (field.transferFunction != function) field.transferFunction = function;
            }
            ShowState();
        }

        /// The function that a volume is shown with: its own, or that of the preset that suits its scan.
        LumivoxTransferFunction InForce()
        {
            if (volume.transferFunction != null) return volume.transferFunction;
            var scan = volume.volume;
            if (scan == null || scan.state != LumivoxVolumeState.Ready) return null;
            if (suited != null && suitedTo == scan) return suited;
            ForgetSuited();
            try
            {
                suitedPreset = LumivoxTransferFunction.PresetFor(scan);
                suited = LumivoxTransferFunction.Preset(suitedPreset, scan);
            }
            catch (LumivoxException error)
            {
                message.text = error.Message;
                return null;
            }
            suited.hideFlags = HideFlags.HideAndDontSave;
            suitedTo = scan;
            return suited;
        }

        void ForgetSuited()
        {
            if (suited != null) DestroyImmediate(suited);
            suited = null;
            suitedTo = null;
        }

        /// The first edit of a function that is nobody's: the picture follows at once, and the whole edit is one step of undo.
        void Adopt(string name)
        {
            if (volume == null || suited == null || field.transferFunction != suited) return;
            var own = suited;
            suited = null;
            suitedTo = null;
            own.hideFlags = HideFlags.None;
            Undo.RegisterCompleteObjectUndo(volume, name);
            volume.transferFunction = own;
            VolumeActions.Keep(volume, name);
            PrefabUtility.RecordPrefabInstancePropertyModifications(volume);
            EditorUtility.SetDirty(volume);
        }

        /// A preset sets the whole medium of all selected volumes; of an asset on its own, the points.
        void OnPreset(string preset)
        {
            if (volume == null)
            {
                var made = LumivoxTransferFunction.Preset(preset, field.volume);
                field.Take(made, "Apply Preset");
                DestroyImmediate(made);
                return;
            }
            var selected = Selected();
            VolumeActions.ApplyPreset(selected.Contains(volume) ? selected : new List<LumivoxVolume> { volume }, preset);
            Look();
            field.ShowPoints();
        }

        void ShowState()
        {
            var editable = field.transferFunction != null;
            field.style.display = editable ? DisplayStyle.Flex : DisplayStyle.None;
            message.style.display = editable ? DisplayStyle.None : DisplayStyle.Flex;
            notice.style.display = editable && volume != null ? DisplayStyle.Flex : DisplayStyle.None;
            if (volume == null)
            {
                message.text = "Select a Lumivox Volume, or a transfer function, to edit it.";
                return;
            }
            var scan = volume.volume;
            if (scan == null) message.text = $"{volume.name} has no volume yet.";
            else if (scan.state == LumivoxVolumeState.Failed) message.text = scan.error;
            else if (scan.state != LumivoxVolumeState.Ready) message.text = $"The scan of {volume.name} is being read.";
            if (editable && volume.transferFunction == null)
                notice.text = $"{volume.name}: {TransferFunctionAccess.TitleOfPreset(suitedPreset)}, which suits its scan, until you choose or edit";
            else
                notice.text = volume.preset != "" ? $"{volume.name}: begun with {TransferFunctionAccess.TitleOfPreset(volume.preset)}" : $"{volume.name}: no preset";
        }
    }
}
