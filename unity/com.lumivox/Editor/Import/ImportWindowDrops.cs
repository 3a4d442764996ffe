using System.IO;
using System.Linq;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    public sealed partial class ImportWindow
    {
        static readonly Color dropColor = new Color(0.35f, 0.6f, 1f);
        string[] m_SeenPaths;
        string m_SeenDrop;

        /// What is dropped on the window, from the system's file browser or the project window, is looked at.
        void TakeDrops(VisualElement root)
        {
            root.RegisterCallback<DragEnterEvent>(_ =>
            {
                m_SeenPaths = null;
                ShowDrop(Dropped() != null);
            });
            root.RegisterCallback<DragLeaveEvent>(_ => ShowDrop(false));
            root.RegisterCallback<DragExitedEvent>(_ => ShowDrop(false));
            root.RegisterCallback<DragUpdatedEvent>(e =>
            {
                var path = Dropped();
                ShowDrop(path != null);
                DragAndDrop.visualMode = path != null ? DragAndDropVisualMode.Copy : DragAndDropVisualMode.Rejected;
                e.StopPropagation();
            }, TrickleDown.TrickleDown);
            root.RegisterCallback<DragPerformEvent>(e =>
            {
                ShowDrop(false);
                var path = Dropped();
                if (path == null) return;
                DragAndDrop.AcceptDrag();
                // Fields below would take a path as text.
                e.StopPropagation();
                Take(path, m_Receiver);
            }, TrickleDown.TrickleDown);
        }

        void ShowDrop(bool isTaken)
        {
            var style = rootVisualElement.style;
            style.borderLeftWidth = style.borderTopWidth = style.borderRightWidth = style.borderBottomWidth = isTaken ? 2 : 0;
            style.borderLeftColor = style.borderTopColor = style.borderRightColor = style.borderBottomColor = dropColor;
        }

        /// The folder or file that is dragged; the folder of several files, such as the slices of a series. Null where it is
        /// nothing that can be looked at now.
        string Dropped()
        {
            var paths = DragAndDrop.paths;
            if (Works || paths == null || paths.Length == 0) return null;
            // Asked with every movement: a share is not to be asked for each of a thousand slices each time.
            if (m_SeenPaths == null || !paths.SequenceEqual(m_SeenPaths)) (m_SeenPaths, m_SeenDrop) = (paths, FolderOf(paths));
            return m_SeenDrop;
        }

        static string FolderOf(string[] paths)
        {
            string common = null;
            foreach (var one in paths)
            {
                var path = StoredScans.ProjectFile(one);
                var isFile = File.Exists(path);
                if (!isFile && !Directory.Exists(path)) return null;
                if (paths.Length == 1) return path;
                var folder = Path.GetDirectoryName(path);
                if (!isFile || common != null && common != folder) return null;
                common = folder;
            }
            return common;
        }
    }
}
