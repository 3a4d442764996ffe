using System;
using NUnit.Framework;
using StandIn;
using UnityEngine;

namespace Lumivox.Tests
{
    /// <summary>What frames leave on the managed heap.</summary>
    static class Garbage
    {
        /// <summary>
        /// Draws frames, each after a change by its number, and fails where those after the first few leave bytes behind: the
        /// package in its callbacks, and in its turn between frames.
        /// </summary>
        public static void IsLeftByNone(int first, int counted, Action<int> change, Action after)
        {
            long most = 0, ticks = 0;
            var frames = 0;
            for (var i = 0; i < first + counted; i++)
            {
                change(i);
                Callbacks.Reset();
                Engine.Frame();
                var bytes = Callbacks.bytes;
                var before = GC.GetAllocatedBytesForCurrentThread();
                LumivoxRuntime.Tick();
                if (i < first) continue;
                ticks += GC.GetAllocatedBytesForCurrentThread() - before;
                most = Math.Max(most, bytes);
                if (bytes > 0) frames++;
                after();
            }
            // A pool may still grow, once or twice.
            Assert.IsTrue(frames <= 2, $"{frames} of {counted} frames left garbage, {most} bytes at most");
            Assert.AreEqual(0, ticks, $"bytes in {counted} turns between frames");
        }
    }
}
