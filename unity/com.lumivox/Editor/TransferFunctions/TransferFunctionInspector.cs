using Lumivox.Native;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>The transfer-function editor in the inspector, with the lists of points below it.</summary>
    [CustomEditor(typeof(LumivoxTransferFunction)), CanEditMultipleObjects]
    sealed class TransferFunctionInspector : UnityEditor.Editor
    {
        static readonly string[] lists = { "m_OpacityKnots", "m_ColorStops", "m_Shift", "m_WindowScale", "m_Gradients" };

        public override VisualElement CreateInspectorGUI()
        {
            var root = new VisualElement();
            if (targets.Length == 1)
            {
                var function = (LumivoxTransferFunction)target;
                var field = new TransferFunctionField { name = "editor", transferFunction = function, volume = VolumesOf.One(function) };
                field.style.minHeight = 260;
                var undo = new TransferFunctionUndo(field);
                FunctionFiles.AddTo(field);
                root.RegisterCallback<AttachToPanelEvent>(_ => undo.Listen(true));
                root.RegisterCallback<DetachFromPanelEvent>(_ => undo.Listen(false));
                root.Add(field);
            }
            var points = new Foldout { name = "points", text = "Numbers" };
            points.SetValueWithoutNotify(targets.Length > 1);
            foreach (var name in lists) points.Add(new PropertyField(serializedObject.FindProperty(name)));
            root.Add(points);
            return root;
        }

        /// What the project window shows of one.
        public override Texture2D RenderStaticPreview(string assetPath, Object[] subAssets, int width, int height)
        {
            var function = (LumivoxTransferFunction)target;
            return Border.Fault != null || function.opacityKnots.Count == 0 ? null : PresetSwatch.Picture(function, width, height);
        }
    }
}
