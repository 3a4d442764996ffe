using UnityEditor;
using UnityEditor.IMGUI.Controls;
using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>A volume's clip box with a handle on each face, and the patient's directions.</summary>
    sealed class ClipHandles
    {
        /// What is kept is never thinner than this part of the scan.
        const float Least = 0.002f;
        /// An object without a scan, in metres: about a head.
        static readonly Vector3 placeholder = Vector3.one * 0.24f;
        static readonly Color box = new Color(0.96f, 0.60f, 0.42f, 0.45f), clip = new Color(0.96f, 0.72f, 0.30f);
        /// Ends of the object's axes: a patient stands upright and looks along -z.
        static readonly (string letter, Vector3 direction)[] letters =
        {
            ("L", Vector3.right), ("R", Vector3.left), ("H", Vector3.up), ("F", Vector3.down), ("A", Vector3.back), ("P", Vector3.forward),
        };

        readonly BoxBoundsHandle handle = new BoxBoundsHandle();

        public void Draw(LumivoxVolume volume)
        {
            if (volume == null) return;
            var world = volume.transform.localToWorldMatrix;
            var bounds = volume.localBounds;
            if (bounds.size == Vector3.zero)
            {
                // There is something to see, though there is no scan yet.
                using (new Handles.DrawingScope(box, world)) Handles.DrawWireCube(Vector3.zero, placeholder);
                return;
            }
            // An oblique scan's box is turned against the object.
            using (new Handles.DrawingScope(clip, world * volume.clipTransform)) DrawClip(volume);
            using (new Handles.DrawingScope(box, world))
                foreach (var (letter, direction) in letters)
                    Handles.Label(bounds.center + Vector3.Scale(bounds.extents, direction) * 1.08f, letter);
        }

        void DrawClip(LumivoxVolume volume)
        {
            var low = Vector3.Min(volume.clipMin, volume.clipMax);
            var high = Vector3.Max(volume.clipMin, volume.clipMax);
            handle.center = (low + high) * 0.5f;
            handle.size = high - low;
            handle.SetColor(clip);
            EditorGUI.BeginChangeCheck();
            handle.DrawHandle();
            if (!EditorGUI.EndChangeCheck()) return;
            low = handle.center - handle.size * 0.5f;
            high = handle.center + handle.size * 0.5f;
            for (var axis = 0; axis < 3; axis++)
            {
                low[axis] = Mathf.Clamp(low[axis], 0, 1 - Least);
                high[axis] = Mathf.Clamp(high[axis], low[axis] + Least, 1);
            }
            Undo.RecordObject(volume, "Clip Volume");
            volume.clipMin = low;
            volume.clipMax = high;
            PrefabUtility.RecordPrefabInstancePropertyModifications(volume);
        }
    }
}
