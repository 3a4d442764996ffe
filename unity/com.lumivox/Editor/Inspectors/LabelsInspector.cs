using System.Collections.Generic;
using System.Linq;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>The labels of a map, and how each looks.</summary>
    [CustomEditor(typeof(LumivoxLabels)), CanEditMultipleObjects]
    sealed class LabelsInspector : UnityEditor.Editor
    {
        /// Each label's own; its name and whether it is seen stand in the row that folds them.
        static readonly string[] own =
        {
            "opacity", "density", "painted", "color", "transferFunction", "clipped", "ownSurface", "surfaceStrength", "surfaceGradient", "surfaceRoughness", "surfaceSpecular", "surfaceMetallic",
        };

        VisualElement list;
        TextField search;
        HelpBox note;
        string shown;

        List<LumivoxLabels> All => targets.OfType<LumivoxLabels>().ToList();

        public override VisualElement CreateInspectorGUI()
        {
            var root = new VisualElement();
            note = new HelpBox("", HelpBoxMessageType.Info) { name = "note" };
            root.Add(note);
            root.Add(new PropertyField(serializedObject.FindProperty("m_Map")));
            var row = new VisualElement();
            row.style.flexDirection = FlexDirection.Row;
            search = new TextField { name = "search", tooltip = "Shows labels with this in their names." };
            search.style.flexGrow = 1;
            search.RegisterValueChangedCallback(_ => Filter());
            row.Add(search);
            row.Add(new Button(() => ShowLabels(true)) { name = "show-all", text = "Show All", tooltip = "All labels in the list are seen." });
            row.Add(new Button(() => ShowLabels(false)) { name = "hide-all", text = "Hide All", tooltip = "No label in the list is seen." });
            root.Add(row);
            list = new VisualElement { name = "labels" };
            root.Add(list);
            shown = null;
            Show();
            root.TrackSerializedObjectValue(serializedObject, _ => Show());
            return root;
        }

        /// The list is made anew where its labels are others; their looks are bound.
        void Show()
        {
            if (targets.Any(one => one == null)) return;
            ShowNote();
            var names = string.Join("\n", All.Select(Names).Distinct());
            if (names == shown) return;
            shown = names;
            list.Clear();
            // Only where all have the same labels do looks belong together.
            if (All.Select(Names).Distinct().Count() > 1) return;
            serializedObject.Update();
            var looks = serializedObject.FindProperty("m_Looks");
            for (var i = 0; i < looks.arraySize; i++) list.Add(Row(looks.GetArrayElementAtIndex(i), All[0].looks[i]));
            list.Bind(serializedObject);
            Filter();
        }

        static string Names(LumivoxLabels labels) => string.Join("/", labels.looks.Select(look => $"{look.value} {look.name}"));

        void ShowNote()
        {
            var all = All;
            var text = "";
            if (all.Select(Names).Distinct().Count() > 1) text = $"{all.Count} assets with different labels: their looks are edited one by one.";
            else if (all.Any(LabelActions.AreImported)) text = "These looks are made anew with each import. 'Edit Looks' in the inspector of a Lumivox Volume makes an asset of them that can be edited.";
            else if (all.Count == 1 && all[0].Problem != null) text = all[0].Problem;
            note.text = text;
            note.style.display = text.Length > 0 ? DisplayStyle.Flex : DisplayStyle.None;
        }

        VisualElement Row(SerializedProperty look, LumivoxLabels.Look of)
        {
            var row = new VisualElement { name = of.name };
            row.style.flexDirection = FlexDirection.Row;
            var visible = new PropertyField(look.FindPropertyRelative("visible"), "");
            visible.style.width = 24;
            row.Add(visible);
            var fold = new Foldout { text = Title(of) };
            fold.style.flexGrow = 1;
            fold.SetValueWithoutNotify(false);
            foreach (var name in own) fold.Add(new PropertyField(look.FindPropertyRelative(name)));
            row.Add(fold);
            return row;
        }

        /// Its name, with how much there is of it.
        string Title(LumivoxLabels.Look look)
        {
            var map = All[0].map;
            foreach (var label in map != null ? map.labels : new LumivoxLabel[0])
                if (label.value == look.value) return $"{look.name}  ({ReportText.Number((float)label.milliliters)} ml)";
            return look.name;
        }

        void Filter()
        {
            foreach (var row in list.Children())
                row.style.display = IsListed(row.name) ? DisplayStyle.Flex : DisplayStyle.None;
        }

        bool IsListed(string name) => name.IndexOf(search.value ?? "", System.StringComparison.OrdinalIgnoreCase) >= 0;

        void ShowLabels(bool visible)
        {
            serializedObject.Update();
            var looks = serializedObject.FindProperty("m_Looks");
            for (var i = 0; i < looks.arraySize; i++)
            {
                var look = looks.GetArrayElementAtIndex(i);
                if (IsListed(look.FindPropertyRelative("name").stringValue)) look.FindPropertyRelative("visible").boolValue = visible;
            }
            serializedObject.ApplyModifiedProperties();
        }
    }
}
