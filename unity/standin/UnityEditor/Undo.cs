// Undo and redo in groups, over what Unity would serialise of the objects.
using System;
using System.Collections.Generic;
using System.Linq;
using StandIn;
using UnityEngine;
using Object = UnityEngine.Object;

namespace UnityEditor
{
    public class Undo
    {
        sealed class Record
        {
            public Object target;
            public Node state;
            /// Of an object that was created: whether it is there.
            public bool isCreation;
        }

        sealed class Group
        {
            public int number;
            public string name = "";
            public List<Record> records = new List<Record>();
        }

        static readonly List<Group> past = new List<Group>(), future = new List<Group>();
        static readonly List<Record> pending = new List<Record>();
        static int current = 1;
        static string currentName = "";

        public delegate void UndoRedoCallback();
        public static UndoRedoCallback undoRedoPerformed;

        public static int GetCurrentGroup() => current;
        public static string GetCurrentGroupName() => currentName;
        public static void SetCurrentGroupName(string name)
        {
            currentName = name;
            var group = past.LastOrDefault();
            if (group != null && group.number == current) group.name = name;
        }
        public static void IncrementCurrentGroup()
        {
            FlushUndoRecordObjects();
            current++;
            currentName = "";
        }

        public static void RecordObject(Object objectToUndo, string name)
        {
            Check(objectToUndo);
            currentName = name;
            if (!pending.Exists(record => ReferenceEquals(record.target, objectToUndo))) pending.Add(new Record { target = objectToUndo, state = Node.Of(objectToUndo) });
        }
        public static void RecordObjects(Object[] objectsToUndo, string name) { foreach (var one in objectsToUndo) RecordObject(one, name); }

        public static void FlushUndoRecordObjects()
        {
            foreach (var record in pending.ToList()) if (record.target != null && !record.state.Same(Node.Of(record.target))) Add(record);
            pending.Clear();
        }

        public static void RegisterCompleteObjectUndo(Object objectToUndo, string name)
        {
            Check(objectToUndo);
            currentName = name;
            Add(new Record { target = objectToUndo, state = Node.Of(objectToUndo) });
        }
        public static void RegisterCompleteObjectUndo(Object[] objectsToUndo, string name) { foreach (var one in objectsToUndo) RegisterCompleteObjectUndo(one, name); }

        public static void RegisterCreatedObjectUndo(Object objectToUndo, string name)
        {
            Check(objectToUndo);
            currentName = name;
            Add(new Record { target = objectToUndo, isCreation = true });
        }

        public static T AddComponent<T>(GameObject gameObject) where T : Component
        {
            var component = gameObject.AddComponent<T>();
            RegisterCreatedObjectUndo(component, "Add Component");
            return component;
        }

        public static void CollapseUndoOperations(int groupIndex)
        {
            FlushUndoRecordObjects();
            var collapsed = past.Where(group => group.number >= groupIndex).ToList();
            if (collapsed.Count == 0) return;
            foreach (var later in collapsed.Skip(1))
            {
                collapsed[0].records.AddRange(later.records);
                past.Remove(later);
            }
            collapsed[0].number = current;
        }

        public static void RevertAllDownToGroup(int group)
        {
            FlushUndoRecordObjects();
            while (past.Count > 0 && past[past.Count - 1].number >= group)
            {
                Move(past, future, true);
                future.Clear();
            }
        }

        public static void PerformUndo()
        {
            FlushUndoRecordObjects();
            Move(past, future, true);
        }
        public static void PerformRedo() => Move(future, past, false);
        public static void ClearAll() { past.Clear(); future.Clear(); pending.Clear(); }
        public static void ClearUndo(Object identifier) { foreach (var group in past.Concat(future)) group.records.RemoveAll(record => ReferenceEquals(record.target, identifier)); }

        /// Names of the steps that can be undone, the last first.
        internal static string[] Names
        {
            get
            {
                FlushUndoRecordObjects();
                return past.AsEnumerable().Reverse().Select(group => group.name).ToArray();
            }
        }

        static void Check(Object target)
        {
            if (target == null) throw new ArgumentNullException(nameof(target), "The object to undo is null or was destroyed.");
        }

        static void Add(Record record)
        {
            future.Clear();
            var group = past.LastOrDefault();
            if (group == null || group.number != current) past.Add(group = new Group { number = current });
            if (group.name == "" || currentName != "") group.name = currentName;
            group.records.Add(record);
        }

        static void Move(List<Group> from, List<Group> to, bool back)
        {
            if (from.Count == 0) return;
            var group = from[from.Count - 1];
            from.RemoveAt(from.Count - 1);
            var moved = new Group { number = group.number, name = group.name };
            foreach (var record in Enumerable.Reverse(group.records))
            {
                if (record.isCreation)
                {
                    if (!back) throw new NotImplementedException("the stand-in does not bring back what was destroyed");
                    Object.DestroyImmediate(record.target);
                    continue;
                }
                if (record.target == null) continue;
                moved.records.Add(new Record { target = record.target, state = Node.Of(record.target) });
                record.state.WriteTo(record.target);
                Messages.Send(record.target, "OnValidate");
            }
            to.Add(moved);
            current++;
            currentName = "";
            undoRedoPerformed?.Invoke();
            Bindings.Refresh();
        }
    }
}
