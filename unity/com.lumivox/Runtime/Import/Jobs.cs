// Long work of the native library's threads, asked for news on the main thread.
using System;
using System.Collections.Generic;
using System.Threading.Tasks;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>Work on another thread. Its end is told once, on the main thread.</summary>
    internal sealed unsafe class Job
    {
        public readonly JobHandle Handle;
        /// <summary>A phrase for people, and how far that is.</summary>
        public string Stage = "";
        public long Done, Total;
        public event Action<Job> Progressed;
        readonly Action<Job, JobState> ended;

        internal Job(IntPtr pointer, Action<Job, JobState> ended)
        {
            Handle = new JobHandle(Border.Checked(pointer));
            this.ended = ended;
        }

        public IntPtr Pointer => Handle.Pointer;

        public string Error => Border.TakeText(Library.lumivox_job_error(Pointer));

        public string Report => Border.TakeText(Library.lumivox_job_report(Pointer));

        /// <summary>What it has pictured, which is whose who asks; null where that is nothing.</summary>
        public Texture2D Picture()
        {
            Native.Picture made;
            if (Library.lumivox_job_picture(Pointer, &made) < 0 || made.width == 0 || made.height == 0) return null;
            var (width, height) = ((int)made.width, (int)made.height);
            var pixels = new Color32[width * height];
            // Unity's rows go up.
            for (var y = 0; y < height; y++)
                for (var x = 0; x < width; x++)
                {
                    var from = made.rgba + 4L * (y * width + x);
                    pixels[(height - 1 - y) * width + x] = new Color32(from[0], from[1], from[2], from[3]);
                }
            var texture = new Texture2D(width, height, TextureFormat.RGBA32, false) { hideFlags = HideFlags.DontSave };
            texture.SetPixels32(pixels);
            texture.Apply();
            return texture;
        }

        public VolumeHandle TakeVolume() => new VolumeHandle(Border.Checked(Library.lumivox_job_take_volume(Pointer)));

        /// <summary>From any thread.</summary>
        public void Cancel()
        {
            var isHeld = false;
            try
            {
                Handle.DangerousAddRef(ref isHeld);
                Library.lumivox_job_cancel(Handle.DangerousGetHandle());
            }
            catch (ObjectDisposedException)
            {
                // It has ended meanwhile.
            }
            finally
            {
                if (isHeld) Handle.DangerousRelease();
            }
        }

        /// <summary>Asks for news. Returns whether it has ended.</summary>
        internal bool Poll()
        {
            if (Handle.IsClosed) return true;
            Native.Progress progress;
            var state = Library.lumivox_job_poll(Pointer, &progress);
            Tell(progress);
            if (state == JobState.Running) return false;
            try
            {
                ended(this, state);
            }
            finally
            {
                Handle.Dispose();
            }
            return true;
        }

        IntPtr stageText;

        void Tell(in Native.Progress progress)
        {
            var stage = (IntPtr)progress.stage;
            if (stage == stageText && (long)progress.done == Done && (long)progress.total == Total) return;
            if (stage != stageText)
            {
                stageText = stage;
                Stage = Border.Text(stageText);
            }
            Done = (long)progress.done;
            Total = (long)progress.total;
            // Before its first stage there is nothing to tell.
            if (Stage.Length > 0) Progressed?.Invoke(this);
        }
    }

    /// <summary>All that is under way.</summary>
    internal static class Jobs
    {
        static readonly List<Job> running = new List<Job>();
        static readonly List<Job> polled = new List<Job>();

        public static int Count => running.Count;

        /// <summary>Follows a job whose end is a task's: what is taken of it, why that cannot be, or that it was stopped.</summary>
        public static Job Follow<T>(IntPtr pointer, TaskCompletionSource<T> task, Func<Job, T> take) => Follow(pointer, (job, state) =>
        {
            if (state == JobState.Cancelled) task.TrySetCanceled();
            else if (state != JobState.Done) task.TrySetException(new LumivoxException(job.Error));
            else if (Try(task, () => take(job), out var taken)) task.TrySetResult(taken);
        });

        /// <summary>Takes what a task waits for. What that throws is the task's: whoever waits would never hear of it otherwise.</summary>
        public static bool Try<T, TTask>(TaskCompletionSource<TTask> task, Func<T> take, out T taken)
        {
            try
            {
                taken = take();
                return true;
            }
            catch (Exception error)
            {
                taken = default;
                task.TrySetException(error);
                return false;
            }
        }

        /// <summary>Follows a job of the library's. What ends it is called on the main thread.</summary>
        public static Job Follow(IntPtr pointer, Action<Job, JobState> ended)
        {
            var job = new Job(pointer, ended);
            running.Add(job);
            Ticker.Need();
            return job;
        }

        /// <summary>Tells what has happened since the last time.</summary>
        public static void Poll()
        {
            if (running.Count == 0) return;
            // Whoever hears of an end may start the next job.
            polled.Clear();
            polled.AddRange(running);
            foreach (var job in polled)
            {
                bool isOver;
                try
                {
                    isOver = job.Poll();
                }
                catch (Exception error)
                {
                    UnityEngine.Debug.LogException(error);
                    // Who hears of its progress may fail before it has ended.
                    isOver = job.Handle.IsClosed;
                }
                if (isOver) running.Remove(job);
            }
            polled.Clear();
        }

        /// <summary>Waits for a job here and now, as editors' importers must; `step` is called meanwhile and may cancel it.</summary>
        public static void Wait(Job job, Action<Job> step = null)
        {
            running.Remove(job);
            while (!job.Poll())
            {
                step?.Invoke(job);
                System.Threading.Thread.Sleep(5);
            }
        }

        /// <summary>Stops everything, silently, and waits for its threads: they must not outlive what they would tell.</summary>
        public static void StopAll()
        {
            foreach (var job in running)
            {
                job.Cancel();
                job.Handle.Dispose();
            }
            running.Clear();
            if (Border.Fault == null) Library.lumivox_jobs_stop_all();
        }
    }
}
