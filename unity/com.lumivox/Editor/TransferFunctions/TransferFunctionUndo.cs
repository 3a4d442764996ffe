using System;
using UnityEditor;

namespace Lumivox.Editor
{
    /// <summary>Makes the edits of a transfer-function editor steps of Unity's undo: a drag is one, and so is a series of keys.</summary>
    sealed class TransferFunctionUndo
    {
        /// Seconds within which keys that follow each other join one step.
        const double Pause = 1;

        readonly TransferFunctionField field;
        /// The step that is under way, and the first of the series that it may join.
        int group = -1, first = -1;
        string series;
        double lastTime;

        /// <summary>A step begins: what else belongs to it can be recorded.</summary>
        public event Action<string> Begun;

        public TransferFunctionUndo(TransferFunctionField field)
        {
            this.field = field;
            field.keepsHistory = false;
            field.editStarted += Begin;
            field.editFinished += Finish;
        }

        public void Listen(bool listens)
        {
            Undo.undoRedoPerformed -= OnUndo;
            if (listens) Undo.undoRedoPerformed += OnUndo;
        }

        void Begin(string name)
        {
            if (field.transferFunction == null) return;
            Undo.IncrementCurrentGroup();
            Undo.SetCurrentGroupName(name);
            group = Undo.GetCurrentGroup();
            Begun?.Invoke(name);
            // All of it: a drag goes on for many frames, and only what was before it counts.
            Undo.RegisterCompleteObjectUndo(field.transferFunction, name);
        }

        void Finish(TransferFunctionEdit edit)
        {
            if (group < 0) return;
            if (edit.after.Equals(edit.before)) Undo.RevertAllDownToGroup(group);
            else
            {
                var now = EditorApplication.timeSinceStartup;
                if (edit.series == null || edit.series != series || now - lastTime > Pause) first = group;
                (series, lastTime) = (edit.series, now);
                Undo.SetCurrentGroupName(edit.name);
                Undo.CollapseUndoOperations(first);
                if (field.transferFunction != null) EditorUtility.SetDirty(field.transferFunction);
            }
            group = -1;
        }

        void OnUndo()
        {
            series = null;
            field.Refresh();
        }
    }
}
