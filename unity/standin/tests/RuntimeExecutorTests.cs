// The executor with recordings that were written by hand: what it does with each step, and when things go wrong.
using System;
using System.Collections.Generic;
using System.Linq;
using Lumivox.Native;
using NUnit.Framework;
using StandIn;
using UnityEngine;
using UnityEngine.Rendering;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    public sealed unsafe class RuntimeExecutorTests
    {
        static readonly DeviceLimits limits = new DeviceLimits { maxTexture3d = 1024, maxTexture2d = 4096, maxBufferBytes = 1 << 27, unorm16 = 1, isSoftware = 1 };

        IntPtr stage;
        Executor executor;
        readonly List<IntPtr> memory = new List<IntPtr>();
        int buffersBefore, texturesBefore, safetyBefore;

        [SetUp]
        public void Begin()
        {
            (buffersBefore, texturesBefore, safetyBefore) = (Live.buffers, Live.renderTextures, Live.safetyHandles);
            var of = limits;
            stage = Library.lumivox_stage_new(&of);
            Assert.AreNotEqual(IntPtr.Zero, stage, Border.LastError());
            executor = new Executor(stage);
        }

        [TearDown]
        public void End()
        {
            executor.Dispose();
            Library.lumivox_stage_free(stage);
            foreach (var piece in memory) System.Runtime.InteropServices.Marshal.FreeHGlobal(piece);
            memory.Clear();
            Faults.Clear();
            Assert.AreEqual(buffersBefore, Live.buffers, Live.Describe());
            Assert.AreEqual(texturesBefore, Live.renderTextures, Live.Describe());
            Assert.AreEqual(safetyBefore, Live.safetyHandles);
        }

        byte* Keep(byte[] bytes)
        {
            var at = System.Runtime.InteropServices.Marshal.AllocHGlobal(Math.Max(1, bytes.Length));
            System.Runtime.InteropServices.Marshal.Copy(bytes, 0, at, bytes.Length);
            memory.Add(at);
            return (byte*)at;
        }

        Step CreateBuffer(ulong id, ulong bytes) => new Step { kind = StepKind.CreateBuffer, id = id, length = bytes, label = Keep(new byte[] { (byte)'b', 0 }) };

        Step WriteBuffer(ulong id, ulong offset, byte[] data) => new Step { kind = StepKind.WriteBuffer, id = id, offset = offset, data = Keep(data), length = (ulong)data.Length };

        Step CreateTexture(ulong id, uint format, uint x, uint y, uint z)
        {
            var step = new Step { kind = StepKind.CreateTexture, id = id, format = format, label = Keep(new byte[] { (byte)'t', 0 }) };
            (step.size[0], step.size[1], step.size[2]) = (x, y, z);
            return step;
        }

        Step WriteTexture(ulong id, Vector3Int origin, Vector3Int size, byte[] data)
        {
            var step = new Step { kind = StepKind.WriteTexture, id = id, data = Keep(data), length = (ulong)data.Length };
            for (var axis = 0; axis < 3; axis++) (step.origin[axis], step.size[axis]) = ((uint)origin[axis], (uint)size[axis]);
            return step;
        }

        static Step Free(ulong id) => new Step { kind = StepKind.Free, id = id };

        Outcome Run(out string why, params Step[] steps)
        {
            using (var cmd = new CommandBuffer { name = "test" })
            {
                Outcome outcome;
                executor.BeginFrame();
                fixed (Step* first = steps) outcome = executor.Execute(cmd, first, (uint)steps.Length, default, out why);
                Graphics.ExecuteCommandBuffer(cmd);
                return outcome;
            }
        }

        void Run(params Step[] steps) => Assert.AreEqual(Outcome.Executed, Run(out var why, steps), why);

        static byte[] Noise(int count, int seed)
        {
            var bytes = new byte[count];
            new System.Random(seed).NextBytes(bytes);
            return bytes;
        }

        [Test]
        public void ABufferIsZerosAndThenWhatIsWritten()
        {
            var data = Noise(4096, 1);
            Run(CreateBuffer(1, 10240), WriteBuffer(1, 2048, data));
            var buffer = Object<GraphicsBuffer>("buffers", 1);
            var expected = new byte[10240];
            data.CopyTo(expected, 2048);
            CollectionAssert.AreEqual(expected, Pictures.Read(buffer, 0, 10240));
            Run(new Step { kind = StepKind.ClearBuffer, id = 1 });
            CollectionAssert.AreEqual(new byte[10240], Pictures.Read(buffer, 0, 10240));
            Run(Free(1));
        }

        [Test]
        public void ABufferOfMoreThanARowOfGroupsIsClearedWhole()
        {
            const int bytes = 65535 * 1024 + 4096;
            Run(CreateBuffer(1, bytes), WriteBuffer(1, bytes - 16, Noise(16, 2)));
            Run(new Step { kind = StepKind.ClearBuffer, id = 1 });
            CollectionAssert.AreEqual(new byte[4112], Pictures.Read(Object<GraphicsBuffer>("buffers", 1), bytes - 4112, 4112));
            Run(Free(1));
        }

        [TestCase(0u, 1)]
        [TestCase(1u, 2)]
        [TestCase(2u, 2)]
        [TestCase(3u, 16)]
        public void ABoxIsWrittenTexelByTexel(uint format, int bytesPerTexel)
        {
            // Odd sizes, so that rows and slices begin within words.
            var size = new Vector3Int(7, 5, 3);
            var data = Noise(size.x * size.y * size.z * bytesPerTexel, 3);
            if (format == 2) for (var i = 1; i < data.Length; i += 2) data[i] &= 0x3b;
            if (format == 3) for (var i = 3; i < data.Length; i += 4) data[i] &= 0x3f;
            Run(CreateTexture(1, format, 16, 8, 6), WriteTexture(1, new Vector3Int(4, 2, 1), size, data));
            CheckBox(Object<RenderTexture>("textures", 1), new Vector3Int(4, 2, 1), size, bytesPerTexel, data);
            if (format != 3)
            {
                var copy = new Step { kind = StepKind.CopyTexture, id = 2, from = 1 };
                for (var axis = 0; axis < 3; axis++) (copy.origin[axis], copy.size[axis]) = ((uint)new Vector3Int(4, 2, 1)[axis], (uint)size[axis]);
                Run(CreateTexture(2, format, 16, 8, 8), copy);
                CheckBox(Object<RenderTexture>("textures", 2), new Vector3Int(4, 2, 1), size, bytesPerTexel, data);
                Run(Free(2));
            }
            Run(Free(1));
        }

        static void CheckBox(RenderTexture texture, Vector3Int origin, Vector3Int size, int bytesPerTexel, byte[] data)
        {
            for (var z = 0; z < size.z; z++)
            {
                var slice = Pictures.Bytes(texture, origin.z + z);
                for (var y = 0; y < size.y; y++)
                {
                    var row = slice.Skip(((origin.y + y) * texture.width + origin.x) * bytesPerTexel).Take(size.x * bytesPerTexel);
                    CollectionAssert.AreEqual(data.Skip((z * size.y + y) * size.x * bytesPerTexel).Take(size.x * bytesPerTexel), row, $"row {y} of slice {z}");
                }
            }
        }

        [Test]
        public void AFlatTextureIsWritten()
        {
            var data = Noise(16 * 8 * 16, 4);
            for (var i = 3; i < data.Length; i += 4) data[i] &= 0x3f;
            Run(CreateTexture(1, 3, 16, 8, 0), WriteTexture(1, Vector3Int.zero, new Vector3Int(16, 8, 1), data));
            CollectionAssert.AreEqual(data, Pictures.Bytes(Object<RenderTexture>("textures", 1)));
            Run(Free(1));
        }

        [Test]
        public void WhatIsFreedLivesUntilItsCommandsAreExecuted()
        {
            using (var cmd = new CommandBuffer())
            {
                executor.BeginFrame();
                var steps = new[] { CreateBuffer(1, 64), WriteBuffer(1, 0, Noise(64, 5)), Free(1) };
                fixed (Step* first = steps) Assert.AreEqual(Outcome.Executed, executor.Execute(cmd, first, 3, default, out var why), why);
                Assert.AreEqual(0, executor.Count);
                Assert.AreEqual(1, executor.FreedCount);
                executor.Turn();
                Graphics.ExecuteCommandBuffer(cmd);
            }
            for (var i = 0; i < 3; i++) executor.Turn();
            Assert.AreEqual(0, executor.FreedCount);
        }

        [Test]
        public void WhereThereIsNoRoomEverythingOfTheRecordingIsGivenBack()
        {
            Faults.maxGraphicsBufferSize = 1 << 20;
            Assert.AreEqual(Outcome.NoMemory, Run(out var why, CreateBuffer(1, 64), CreateBuffer(2, 2 << 20)));
            StringAssert.Contains("the GPU has no room for 'b' (2 MB). Use smaller or fewer volumes", why);
            Assert.AreEqual(0, executor.Count);
            Faults.Clear();
        }

        [Test]
        public void AStepThatNamesWhatIsNotThereIsRefused()
        {
            Assert.AreEqual(Outcome.Failed, Run(out var why, WriteBuffer(9, 0, new byte[16])));
            StringAssert.Contains("9 is no buffer", why);
            Assert.AreEqual(Outcome.Failed, Run(out why, new Step { kind = StepKind.Dispatch, kernel = uint.MaxValue }));
            StringAssert.Contains("there is no kernel", why);
        }

        T Object<T>(string field, ulong id)
        {
            var all = (System.Collections.IDictionary)typeof(Executor).GetField(field, System.Reflection.BindingFlags.Instance | System.Reflection.BindingFlags.NonPublic).GetValue(executor);
            return (T)all[id];
        }
    }
}
