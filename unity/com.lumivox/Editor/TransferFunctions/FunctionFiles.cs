using System.IO;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>Transfer functions as files of other programs: buttons for an editor's toolbar.</summary>
    static class FunctionFiles
    {
        static readonly string[] filters = { "Transfer functions", "json,tf", "All files", "*" };

        public static void AddTo(TransferFunctionField field)
        {
            field.toolbar.Insert(field.toolbar.childCount - 1, new Button(() => Load(field)) { name = "load", text = "Load", tooltip = "Loads a transfer function (.json, .tf)." });
            field.toolbar.Insert(field.toolbar.childCount - 1, new Button(() => Save(field)) { name = "save", text = "Save", tooltip = "Saves the transfer function as a file that the other Lumivox programs read." });
        }

        static void Load(TransferFunctionField field)
        {
            if (field.transferFunction == null) return;
            var path = EditorUtility.OpenFilePanelWithFilters("Load a transfer function", "", filters);
            if (string.IsNullOrEmpty(path)) return;
            try
            {
                var loaded = LumivoxTransferFunction.LoadFile(path);
                field.Take(loaded, "Load Transfer Function");
                Object.DestroyImmediate(loaded);
            }
            catch (LumivoxException error)
            {
                EditorUtility.DisplayDialog("Transfer function", $"{Path.GetFileName(path)} was not loaded: {error.Message}", "OK");
            }
        }

        static void Save(TransferFunctionField field)
        {
            if (field.transferFunction == null) return;
            var path = EditorUtility.SaveFilePanel("Save the transfer function", "", field.transferFunction.name, "json");
            if (string.IsNullOrEmpty(path)) return;
            try
            {
                field.transferFunction.SaveFile(path);
            }
            catch (LumivoxException error)
            {
                EditorUtility.DisplayDialog("Transfer function", $"{Path.GetFileName(path)} was not saved: {error.Message}", "OK");
            }
        }
    }
}
