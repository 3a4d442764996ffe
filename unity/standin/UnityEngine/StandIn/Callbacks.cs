// What scripts cost while the engine calls them: time, and garbage.
using System;
using System.Diagnostics;

namespace StandIn
{
    /// Of callbacks of scripts on the main thread: cameras', passes', read-backs', updates. What the stand-in does for them
    /// where the engine has its own memory or threads is not counted; what it does to record their commands is.
    public static class Callbacks
    {
        static long fromBytes, fromTicks, ticks;
        static bool isCounting;

        public static long bytes { get; private set; }
        public static double milliseconds => ticks * 1e3 / Stopwatch.Frequency;
        public static void Reset() => bytes = ticks = 0;

        /// Around a call of a script's.
        internal static Scope Counted() => new Scope(true);
        /// Around what the stand-in does when a script calls it.
        internal static Scope Own() => new Scope(false);

        static void Switch(bool counts)
        {
            long bytesNow = GC.GetAllocatedBytesForCurrentThread(), ticksNow = Stopwatch.GetTimestamp();
            if (isCounting)
            {
                bytes += bytesNow - fromBytes;
                ticks += ticksNow - fromTicks;
            }
            (isCounting, fromBytes, fromTicks) = (counts, bytesNow, ticksNow);
        }

        internal readonly struct Scope : IDisposable
        {
            readonly bool before;
            internal Scope(bool counts)
            {
                before = isCounting;
                Switch(counts);
            }
            public void Dispose() => Switch(before);
        }
    }
}
