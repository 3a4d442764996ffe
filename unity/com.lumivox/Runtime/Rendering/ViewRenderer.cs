// What one view draws in one frame, the same for every pipeline: its world, its picture, what came of it.
using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal sealed unsafe class ViewRenderer : IDisposable
    {
        /// <summary>Frames after which the film of a view that is no longer drawn is freed.</summary>
        const long KeptFrames = 300;

        /// <summary>An eye of a camera.</summary>
        sealed class View
        {
            public ulong Number;
            public Camera Camera;
            public ulong CameraId;
            public int Eye;
            public long Frame;
            public ulong World;
            public int Target;
            public bool IsShown;
            public ViewStatus Status;
            public RenderTexture Depth;
        }

        readonly List<View> views = new List<View>();
        readonly List<RenderTexture> retired = new List<RenderTexture>();
        ulong[] viewNumbers = new ulong[8];
        ulong[] worldNumbers = new ulong[8];
        ulong lastNumber;
        long frame = -1;
        int engineFrame = -1;
        bool isSwept = true;
        bool saidLost;

        /// <summary>The frame that is drawn, or was last.</summary>
        public long Frame => Math.Max(0, frame);

        /// <summary>Whether any image goes on.</summary>
        public bool WantFrames
        {
            get
            {
                foreach (var view in views)
                    if (view.IsShown && frame - view.Frame <= 1 && (view.Status.isConverged == 0 || view.Status.awaitsFeedback != 0)) return true;
                return false;
            }
        }

        /// <summary>See <see cref="LumivoxRuntime.Record"/>.</summary>
        public bool Record(CommandBuffer cmd, IntPtr stage, Executor executor, WorldGatherer worlds, in ViewInputs inputs, in LumivoxSettings settings)
        {
            var view = Find(inputs.Camera, inputs.Eye);
            // A camera that is drawn again, by a script or an editor, begins a frame of its own.
            if (engineFrame != Time.frameCount || view.Frame == frame) BeginFrame(stage, executor);
            view.Frame = frame;
            if (!isSwept) Sweep(cmd, stage, executor, worlds);
            var isAtOnce = LumivoxRenderer.RenderAtOnce;
            var world = worlds.Gather(stage, inputs.Camera, settings.environmentSource == LumivoxEnvironmentSource.Studio, frame);
            view.IsShown = world != null;
            view.Target = settings.targetSamples;
            if (world == null) return false;
            view.World = world.Number;
            var host = default(HostTargets);
            if (!world.IsRecorded)
            {
                world.IsRecorded = true;
                Execute(cmd, stage, executor, Library.lumivox_stage_record_world(stage, world.Number, isAtOnce ? 1u : 0u), host);
            }
            var viewFrame = FrameOf(inputs, settings, isAtOnce);
            if (inputs.HasDepth)
            {
                SizeDepth(view, inputs.Width, inputs.Height);
                executor.CopyDepth(cmd, view.Depth, inputs.IsDepthArray, inputs.DepthSlice, inputs.DepthTexture);
            }
            ViewStatus status;
            var recording = Library.lumivox_stage_record_view(stage, view.Number, world.Number, &viewFrame, &status);
            view.Status = status;
            host.DepthId = status.depth;
            host.ColorId = status.color;
            host.WrittenDepthId = status.writtenDepth;
            host.Ticket = status.ticket;
            host.Depth = view.Depth;
            host.Color = inputs.Color;
            host.WrittenDepth = inputs.Depth;
            host.Slice = inputs.Slice;
            host.Width = inputs.Width;
            host.Height = inputs.Height;
            var isDrawn = Execute(cmd, stage, executor, recording, host);
            if (status.lostPixels > 0 && !saidLost)
            {
                saidLost = true;
                // The picture stays: it is the best there is.
                Debug.LogWarning($"Lumivox: the graphics driver ends programs before their time: {status.lostPixels} pixels miss samples. Update the driver.");
            }
            return isDrawn;
        }

        /// <summary>Learns what came back of frames that were drawn.</summary>
        public void ReadStatuses(IntPtr stage)
        {
            foreach (var view in views)
            {
                if (!view.IsShown || (view.Status.isConverged != 0 && view.Status.awaitsFeedback == 0)) continue;
                ViewStatus status;
                if (Library.lumivox_stage_view_status(stage, view.Number, &status) < 0) continue;
                view.Status.samples = status.samples;
                view.Status.isConverged = status.isConverged;
                view.Status.awaitsFeedback = status.awaitsFeedback;
                view.Status.lostPixels = status.lostPixels;
            }
        }

        /// <summary>How far all eyes of a camera are.</summary>
        public LumivoxStatus StatusOf(Camera camera, WorldGatherer worlds)
        {
            var id = Identity.Of(camera);
            int samples = int.MaxValue, target = 0;
            long pixelSamples = 0, lost = 0;
            var isConverged = true;
            foreach (var view in views)
            {
                if (view.CameraId != id || !view.IsShown) continue;
                samples = Math.Min(samples, (int)view.Status.samples);
                target = view.Target;
                isConverged &= view.Status.isConverged != 0 && !worlds.AwaitsSky(view.World);
                pixelSamples += (long)view.Status.pixelSamples;
                lost += view.Status.lostPixels;
            }
            return target == 0 ? default : new LumivoxStatus(samples, target, isConverged, pixelSamples, lost);
        }

        public void Dispose()
        {
            foreach (var view in views) Executor.Destroy(view.Depth);
            foreach (var texture in retired) Executor.Destroy(texture);
            views.Clear();
            retired.Clear();
        }

        View Find(Camera camera, int eye)
        {
            var id = Identity.Of(camera);
            foreach (var view in views)
                if (view.CameraId == id && view.Eye == eye) return view;
            var made = new View { Number = ++lastNumber, Camera = camera, CameraId = id, Eye = eye, Frame = -1 };
            views.Add(made);
            return made;
        }

        void BeginFrame(IntPtr stage, Executor executor)
        {
            engineFrame = Time.frameCount;
            frame++;
            isSwept = false;
            LumivoxRuntime.BeginFrame();
            executor.BeginFrame();
            // Whatever was drawn with them was drawn in the frame before the last, or earlier.
            if (frame % 4 == 0)
            {
                foreach (var texture in retired) Executor.Destroy(texture);
                retired.Clear();
            }
            Library.lumivox_stage_begin_frame(stage);
        }

        /// <summary>Has the library free what no view of the frames before shows any more.</summary>
        void Sweep(CommandBuffer cmd, IntPtr stage, Executor executor, WorldGatherer worlds)
        {
            isSwept = true;
            if (viewNumbers.Length < views.Count) viewNumbers = new ulong[views.Count * 2];
            var oldest = frame - KeptFrames;
            uint kept = 0;
            for (var i = views.Count - 1; i >= 0; i--)
            {
                var view = views[i];
                var isGone = view.Camera == null || view.Frame < oldest;
                if (isGone)
                {
                    if (view.Depth != null) retired.Add(view.Depth);
                    views.RemoveAt(i);
                }
                // One that sees no volume keeps nothing of its image.
                else if (view.IsShown || view.Frame == frame) viewNumbers[kept++] = view.Number;
            }
            var worldCount = worlds.Keep(oldest, ref worldNumbers);
            fixed (ulong* viewNumber = viewNumbers)
            fixed (ulong* worldNumber = worldNumbers)
                Execute(cmd, stage, executor, Library.lumivox_stage_sweep(stage, viewNumber, kept, worldNumber, worldCount), default);
        }

        /// <summary>Has a recording's commands recorded, and tells the library what became of them.</summary>
        static bool Execute(CommandBuffer cmd, IntPtr stage, Executor executor, IntPtr recording, in HostTargets host)
        {
            if (recording == IntPtr.Zero)
            {
                if (Border.HasError()) LumivoxRuntime.Report(Border.LastError());
                return false;
            }
            uint count;
            var steps = Library.lumivox_recording_steps(recording, &count);
            var outcome = executor.Execute(cmd, steps, count, host, out var why);
            if (outcome == Outcome.Executed)
            {
                Library.lumivox_recording_finish(stage, recording, (uint)outcome, null);
                return true;
            }
            int finished;
            fixed (byte* utf8 = Border.Utf8(why)) finished = Library.lumivox_recording_finish(stage, recording, (uint)outcome, utf8);
            // A view that can do without what was refused, the light that is kept for it, goes on in the next frame.
            var isView = host.Ticket != 0;
            if (!isView || finished < 0) LumivoxRuntime.Report(why);
            return false;
        }

        void SizeDepth(View view, int width, int height)
        {
            if (view.Depth != null && view.Depth.width == width && view.Depth.height == height && view.Depth.IsCreated()) return;
            if (view.Depth != null) retired.Add(view.Depth);
            view.Depth = new RenderTexture(new RenderTextureDescriptor(width, height, GraphicsFormat.R32_SFloat, 0))
            {
                name = "Lumivox Depth",
                filterMode = FilterMode.Point,
                hideFlags = HideFlags.HideAndDontSave,
            };
            if (view.Depth.Create()) return;
            Executor.Destroy(view.Depth);
            view.Depth = null;
            throw new LumivoxException($"the GPU has no room for the depth of {width} x {height} pixels. Use smaller or fewer volumes");
        }

        static ViewFrame FrameOf(in ViewInputs inputs, in LumivoxSettings settings, bool isAtOnce)
        {
            var result = new ViewFrame
            {
                worldFromCamera = inputs.WorldFromCamera,
                clipFromCamera = Projections.ClipFromCamera(inputs.Projection, inputs.IsTopFirst),
                hasDepth = inputs.HasDepth ? 1u : 0u,
                depthClear = SystemInfo.usesReversedZBuffer ? 0f : 1f,
                isJittered = inputs.IsJittered ? 1u : 0u,
                writeDepth = settings.writeDepth ? 1u : 0u,
                exposure = Mathf.Pow(2f, settings.exposure) * inputs.Exposure,
                resolutionScale = settings.resolutionScale,
                targetSamples = (uint)settings.targetSamples,
                targetNoise = settings.targetNoise,
                // The eyes of a headset share a frame's time.
                frameBudgetMs = settings.frameBudgetMs / Math.Max(1, inputs.EyeCount),
                denoise = settings.denoise ? 1u : 0u,
                keptLight = settings.keptLight ? 1u : 0u,
                atOnce = isAtOnce ? 1u : 0u,
            };
            (result.size[0], result.size[1]) = ((uint)inputs.Width, (uint)inputs.Height);
            if (!inputs.HasOwnFog && RenderSettings.fog && Fog.IsSeenBy(inputs.Camera))
            {
                result.fog = (uint)RenderSettings.fogMode;
                result.fogColor = Numbers.Linear(RenderSettings.fogColor);
                result.fogStart = RenderSettings.fogStartDistance;
                result.fogEnd = RenderSettings.fogEndDistance;
                result.fogDensity = RenderSettings.fogDensity;
            }
            return result;
        }
    }
}
