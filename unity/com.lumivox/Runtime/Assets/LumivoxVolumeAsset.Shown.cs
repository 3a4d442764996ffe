using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>What of a scan is seen in place of the patient.</summary>
    internal enum ScanPart : uint
    {
        /// <summary>The scan as it is.</summary>
        None = 0,
        /// <summary>All that was scanned, the table too.</summary>
        Everything = 1,
        /// <summary>The airways alone.</summary>
        Airways = 2,
        /// <summary>The vessels of the lungs alone.</summary>
        LungVessels = 3,
    }

    /// <summary>A part of a scan. All who show the same share it, and it lasts as long as one of them does.</summary>
    internal sealed class ShownPart
    {
        public readonly ScanPart Kind;
        internal int Users;
        internal Job Finding;
        VolumeHandle handle;

        internal ShownPart(ScanPart kind) => Kind = kind;

        /// <summary>Whether another thread is still at it.</summary>
        public bool IsComing => Finding != null;

        /// <summary>Why it cannot be had; empty where nothing has failed.</summary>
        public string Error { get; internal set; } = "";

        /// <summary>Whether it was looked for, and is not in the scan for sure.</summary>
        public bool IsMissing { get; internal set; }

        /// <summary>Whether its scan was closed, or is another.</summary>
        public bool IsOver { get; private set; }

        /// <summary>For the native library; zero where it is not there.</summary>
        public IntPtr Pointer => handle != null ? handle.Pointer : IntPtr.Zero;

        internal void Keep(VolumeHandle made) => handle = made;

        internal void End()
        {
            IsOver = true;
            Finding?.Cancel();
            Finding = null;
            handle?.Dispose();
            handle = null;
        }
    }

    // What is computed of a scan on other threads while it is shown: its surroundings put back, or an organ alone.
    public sealed unsafe partial class LumivoxVolumeAsset
    {
        readonly List<ShownPart> shownParts = new List<ShownPart>();

        /// <summary>Whether something that lies around the patient was put aside when the scan was imported: <see cref="LumivoxVolume.keepEverything"/> shows it.</summary>
        public bool hasSurroundings => m_Summary.hasSurroundings;

        /// <summary>Whether something was taken out of it that nobody can put back: older versions kept none of it.</summary>
        internal bool HasLostSurroundings
        {
            get
            {
                if (hasSurroundings) return false;
                foreach (var note in GetReport().notes)
                    if (note.StartsWith("hidden: ", StringComparison.Ordinal)) return true;
                return false;
            }
        }

        /// <summary>A part of the scan, which another thread computes; null where that is the scan itself. Who takes it leaves it again.</summary>
        internal ShownPart TakePart(ScanPart kind)
        {
            if (handle == null || kind == ScanPart.None || kind == ScanPart.Everything && !hasSurroundings) return null;
            ShownPart part = null;
            foreach (var one in shownParts)
                if (one.Kind == kind) part = one;
            if (part == null)
            {
                part = new ShownPart(kind);
                shownParts.Add(part);
                Find(part);
            }
            part.Users++;
            return part;
        }

        /// <summary>Somebody shows a part no longer.</summary>
        internal void LeavePart(ShownPart part)
        {
            if (--part.Users > 0) return;
            shownParts.Remove(part);
            part.End();
        }

        void Find(ShownPart part)
        {
            part.Finding = Jobs.Follow(Library.lumivox_part_find(handle.Pointer, (uint)part.Kind), (job, state) =>
            {
                if (part.Finding != job) return;
                part.Finding = null;
                if (state == JobState.Done)
                {
                    var made = Library.lumivox_job_take_volume(job.Pointer);
                    if (made != IntPtr.Zero) part.Keep(new VolumeHandle(made));
                    else part.IsMissing = true;
                }
                // Asking again in each frame would only fail again.
                else part.Error = state == JobState.Cancelled ? "it was stopped" : job.Error;
                LumivoxRuntime.RequestFrames();
                changed?.Invoke();
            });
        }

        void ForgetParts()
        {
            foreach (var part in shownParts) part.End();
            shownParts.Clear();
        }
    }
}
