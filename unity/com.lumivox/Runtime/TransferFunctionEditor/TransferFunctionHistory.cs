using System.Collections.Generic;

namespace Lumivox
{
    /// <summary>Something that was done to a transfer function.</summary>
    public readonly struct TransferFunctionEdit
    {
        /// <summary>What it is called in a menu.</summary>
        public readonly string name;
        public readonly TransferFunctionState before;
        public readonly TransferFunctionState after;
        /// <summary>Edits that follow each other with the same one of these are one to whoever undoes them; null: on its own.</summary>
        public readonly string series;

        public TransferFunctionEdit(string name, TransferFunctionState before, TransferFunctionState after, string series)
        {
            this.name = name;
            this.before = before;
            this.after = after;
            this.series = series;
        }
    }

    /// <summary>Undo and redo of one transfer function in a running game; the editor has its own.</summary>
    public sealed class TransferFunctionHistory
    {
        const int Longest = 200;
        readonly List<TransferFunctionEdit> edits = new List<TransferFunctionEdit>();
        int done;

        public bool CanUndo => done > 0;
        public bool CanRedo => done < edits.Count;
        public int Count => edits.Count;

        public void Add(TransferFunctionEdit edit)
        {
            edits.RemoveRange(done, edits.Count - done);
            var last = edits.Count - 1;
            if (last >= 0 && edit.series != null && edits[last].series == edit.series)
                edits[last] = new TransferFunctionEdit(edit.name, edits[last].before, edit.after, edit.series);
            else
                edits.Add(edit);
            if (edits.Count > Longest) edits.RemoveAt(0);
            done = edits.Count;
        }

        /// <summary>What it was before the last edit; null where there is none.</summary>
        public TransferFunctionState Undo() => CanUndo ? edits[--done].before : null;

        /// <summary>What it was after the edit that was undone; null where there is none.</summary>
        public TransferFunctionState Redo() => CanRedo ? edits[done++].after : null;

        public void Clear()
        {
            edits.Clear();
            done = 0;
        }
    }
}
