// Work of the library's threads that the editor waits for, or asks about in each of its turns.
using System;
using System.IO;
using System.Threading;
using System.Threading.Tasks;
using UnityEditor;
using UnityEngine;

namespace Lumivox.Editor
{
    static class EditorWork
    {
        const string Lost = "It ended without a result; the console says why.";

        /// <summary>
        /// Whether an exception is of what lies outside, files, the GPU, or work that was stopped: such are told where they
        /// are met. All others are faults of the code, and thrown on.
        /// </summary>
        public static bool IsOutside(Exception error) =>
            error is LumivoxException || error is IOException || error is UnauthorizedAccessException || error is InvalidOperationException
            || error is UnityException || error is OperationCanceledException;

        /// <summary>Waits here and now, as importers must. `step` is called meanwhile.</summary>
        public static T Wait<T>(Task<T> task, Action step = null)
        {
            Wait((Task)task, step);
            return task.Result;
        }

        /// <summary>Waits here and now. Throws what the work came to, where that is nothing.</summary>
        public static void Wait(Task task, Action step = null)
        {
            while (!task.IsCompleted)
            {
                Jobs.Poll();
                step?.Invoke();
                if (task.IsCompleted) break;
                if (Jobs.Count == 0) throw new LumivoxException(Lost);
                Thread.Sleep(5);
            }
            task.GetAwaiter().GetResult();
        }

        /// <summary>Tells in one of the editor's turns, whatever windows are open then, that work has ended; null, or why it came to nothing.</summary>
        public static void WhenDone(Task task, Action<string> told)
        {
            void Look()
            {
                // What is told of a job's end may itself fail: then nobody would ever hear of it.
                var isLost = !task.IsCompleted && Jobs.Count == 0;
                if (!task.IsCompleted && !isLost) return;
                EditorApplication.update -= Look;
                told(isLost ? Lost : task.IsCanceled ? "It was stopped." : task.IsFaulted ? task.Exception.GetBaseException().Message : null);
            }
            EditorApplication.update += Look;
        }

        /// <summary>For tasks whose end is told by events: what they throw was said already.</summary>
        public static void Forget(Task task) => task.ContinueWith(done => done.Exception, TaskContinuationOptions.OnlyOnFaulted | TaskContinuationOptions.ExecuteSynchronously);
    }
}
