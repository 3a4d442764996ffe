// Unity's objects, and all that follows work of other threads, are the main thread's.
using System.Threading;
using UnityEngine;

namespace Lumivox
{
    internal static class MainThread
    {
        static int id;

        /// <summary>Throws on any other thread, before anything has begun that nobody would follow.</summary>
        public static void Need(string member)
        {
            var here = Thread.CurrentThread.ManagedThreadId;
            if (id == 0 && IsUnitys()) id = here;
            if (id != here) throw new LumivoxException($"{member} is for the main thread only: call it from a script's messages, or after an await that began there.");
        }

        /// <summary>Unity tells it by what it answers there alone.</summary>
        static bool IsUnitys()
        {
            try
            {
                return Time.frameCount >= 0;
            }
            catch (UnityException)
            {
                return false;
            }
        }
    }
}
