// Bytes on their way back from the GPU, each told to the native library once, or told to be lost.
using System;
using System.Collections.Generic;
using Lumivox.Native;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal sealed unsafe class ReadBacks
    {
        /// <summary>Turns after which what has not come is lost: its commands were never executed.</summary>
        const int Patience = 600;

        sealed class Pending
        {
            public readonly Action<AsyncGPUReadbackRequest> Callback;
            public ReadBacks Owner;
            public ulong Ticket;
            public long Asked;

            public Pending() => Callback = Came;

            void Came(AsyncGPUReadbackRequest request)
            {
                // After a stop nobody listens.
                var owner = Owner;
                if (owner != null) owner.Deliver(this, request);
            }
        }

        readonly IntPtr stage;
        readonly List<Pending> waiting = new List<Pending>();
        readonly Stack<Pending> spare = new Stack<Pending>();

        public ReadBacks(IntPtr stage) => this.stage = stage;

        /// <summary>Whether anything is on its way.</summary>
        public bool IsWaiting => waiting.Count > 0;

        public void Ask(CommandBuffer cmd, GraphicsBuffer buffer, int bytes, int offset, ulong ticket, long turn)
        {
            if (!SystemInfo.supportsAsyncGPUReadback)
            {
                Library.lumivox_stage_feedback(stage, ticket, null, 0);
                return;
            }
            var pending = spare.Count > 0 ? spare.Pop() : new Pending();
            pending.Owner = this;
            pending.Ticket = ticket;
            pending.Asked = turn;
            waiting.Add(pending);
            cmd.RequestAsyncReadback(buffer, bytes, offset, pending.Callback);
        }

        /// <summary>Gives up what has not come for long.</summary>
        public void Trim(long turn)
        {
            for (var i = waiting.Count - 1; i >= 0; i--)
            {
                var pending = waiting[i];
                if (turn - pending.Asked < Patience) continue;
                waiting.RemoveAt(i);
                // Its callback may still come: it is not used again.
                pending.Owner = null;
                Library.lumivox_stage_feedback(stage, pending.Ticket, null, 0);
            }
        }

        /// <summary>Nobody listens any more.</summary>
        public void Forget()
        {
            foreach (var pending in waiting) pending.Owner = null;
            waiting.Clear();
        }

        void Deliver(Pending pending, AsyncGPUReadbackRequest request)
        {
            waiting.Remove(pending);
            pending.Owner = null;
            spare.Push(pending);
            if (request.hasError)
            {
                Library.lumivox_stage_feedback(stage, pending.Ticket, null, 0);
            }
            else
            {
                var bytes = request.GetData<byte>();
                Library.lumivox_stage_feedback(stage, pending.Ticket, NativeArrayUnsafeUtility.GetUnsafeReadOnlyPtr(bytes), (ulong)bytes.Length);
            }
            LumivoxRuntime.FeedbackCame();
        }
    }
}
