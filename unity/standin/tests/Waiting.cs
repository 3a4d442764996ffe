// Waits for what other threads and later frames bring, on a busy machine, too.
using System;
using System.Diagnostics;
using System.Threading;
using StandIn;

namespace Lumivox.Tests
{
    static class Waiting
    {
        /// In seconds. What takes longer does not come.
        const double Longest = 120.0;

        /// Lets frames pass until something is so, some at least; whether it came to that.
        /// They are not counted: one that waits for another thread has nothing to do and takes no time.
        internal static bool Frames(Func<bool> isSo, Action afterEach = null, int least = 4)
        {
            var watch = Stopwatch.StartNew();
            for (var i = 0; watch.Elapsed.TotalSeconds < Longest; i++)
            {
                Engine.Frame();
                Ticker.Tick();
                afterEach?.Invoke();
                if (i + 1 >= least && isSo()) return true;
                // Those threads want a processor.
                if (i > 20) Thread.Sleep(1);
            }
            return false;
        }

        /// Repeats a turn until something is so; whether it came to that.
        internal static bool Turns(Func<bool> isSo, Action turn)
        {
            var watch = Stopwatch.StartNew();
            while (!isSo())
            {
                if (watch.Elapsed.TotalSeconds > Longest) return false;
                turn();
                Thread.Sleep(1);
            }
            return true;
        }
    }
}
