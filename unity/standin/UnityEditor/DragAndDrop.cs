// What is dragged, and how tests drag it.
using System;
using System.Collections.Generic;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace UnityEditor
{
    public enum DragAndDropVisualMode { None = 0, Copy = 1, Link = 2, Generic = 4, Move = 16, Rejected = 32 }

    public class DragAndDrop
    {
        public static UnityEngine.Object[] objectReferences { get; set; } = Array.Empty<UnityEngine.Object>();
        public static string[] paths { get; set; } = Array.Empty<string>();
        public static DragAndDropVisualMode visualMode { get; set; }
        public static void AcceptDrag() => StandIn.Drags.IsAccepted = true;
    }
}

namespace StandIn
{
    /// Files that a person drags over a window and lets go of.
    public static class Drags
    {
        static VisualElement under;

        /// Whether what was let go of was taken.
        public static bool IsAccepted;

        /// Drags files to a place of a window; returns what the pointer says would become of them.
        public static DragAndDropVisualMode Over(EditorWindow window, Vector2 at, params string[] paths)
        {
            DragAndDrop.paths = paths;
            DragAndDrop.visualMode = DragAndDropVisualMode.None;
            IsAccepted = false;
            var over = window.panel.Pick(at) ?? window.rootVisualElement;
            for (var left = under; left != null; left = left.hierarchy.parent)
                if (left != over && !left.Contains(over)) left.SendEvent(new DragLeaveEvent { mousePosition = at });
            foreach (var entered in Path(over))
                if (under == null || entered != under && !entered.Contains(under)) entered.SendEvent(new DragEnterEvent { mousePosition = at });
            under = over;
            over.SendEvent(new DragUpdatedEvent { mousePosition = at });
            window.panel.Update();
            return DragAndDrop.visualMode;
        }

        /// Lets go of files where they are dragged to. As in Unity, nothing hears of what nothing would take.
        public static void Drop(EditorWindow window, Vector2 at, params string[] paths)
        {
            if (Over(window, at, paths) is var mode && mode != DragAndDropVisualMode.None && mode != DragAndDropVisualMode.Rejected) under.SendEvent(new DragPerformEvent { mousePosition = at });
            Leave(window);
        }

        /// Drags them out of the window, or gives up.
        public static void Leave(EditorWindow window)
        {
            under?.SendEvent(new DragExitedEvent());
            under = null;
            DragAndDrop.paths = Array.Empty<string>();
            window.panel.Update();
        }

        static IEnumerable<VisualElement> Path(VisualElement element)
        {
            for (; element != null; element = element.hierarchy.parent) yield return element;
        }
    }
}
