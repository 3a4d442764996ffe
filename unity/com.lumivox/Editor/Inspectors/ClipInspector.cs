using System.Collections.Generic;
using System.Linq;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>Shows a clip shape's properties, and why it cuts nothing.</summary>
    [CustomEditor(typeof(LumivoxClip)), CanEditMultipleObjects]
    sealed class ClipInspector : UnityEditor.Editor
    {
        static readonly string[] properties = { "m_Shape", "m_Inverted" };

        VisualElement warnings;
        string shown = "";

        IEnumerable<LumivoxClip> Clips => targets.OfType<LumivoxClip>();

        public override VisualElement CreateInspectorGUI()
        {
            var root = new VisualElement();
            warnings = new VisualElement { name = "warnings" };
            shown = "";
            root.Add(warnings);
            foreach (var name in properties) root.Add(new PropertyField(serializedObject.FindProperty(name)));
            root.TrackSerializedObjectValue(serializedObject, _ => Show());
            // It is moved, and hung elsewhere, without a change of any property.
            root.schedule.Execute(Show).Every(500);
            Show();
            return root;
        }

        void Show()
        {
            if (targets.Any(one => one == null)) return;
            var lines = Clips.SelectMany(clip => clip.GetWarnings()).Distinct().ToList();
            var all = string.Join("\n", lines);
            if (all == shown) return;
            shown = all;
            warnings.Clear();
            foreach (var line in lines) warnings.Add(new HelpBox(line, HelpBoxMessageType.Warning));
        }
    }
}
