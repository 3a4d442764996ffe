// One stage and one executor for the whole process: made when the first volume is drawn, gone before the domain is.
using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal static unsafe class LumivoxRuntime
    {
        /// <summary>Seconds for which a scan that nothing shows stays in memory.</summary>
        const float KeptSeconds = 5f;

        static IntPtr stage;
        static Executor executor;
        static WorldGatherer worlds;
        static ViewRenderer views;
        static string error = "";
        static string frameError = "";
        static string untoldFault;
        static bool cannotStart;
        static bool wantsFrames;
        /// Since when there has been no volume; 0 where there is one.
        static double idleSince;

        /// <summary>Why volumes cannot be drawn, or an empty string.</summary>
        public static string Error => error;

        public static ulong VoxelBytes => stage != IntPtr.Zero ? Library.lumivox_stage_voxel_bytes(stage) : 0;

        public static ulong KeptLightBytes => stage != IntPtr.Zero ? Library.lumivox_stage_light_bytes(stage) : 0;

        internal static Executor Executor => executor;

        internal static WorldGatherer Worlds => worlds;

        /// <summary>Whether objects are made for an asset: they are in no scene, though Unity enables them.</summary>
        internal static bool IsMakingAssets;

        /// <summary>A volume is there: frames and turns are listened to.</summary>
        public static void Need()
        {
            Ticker.Need();
            BuiltInPipeline.Need();
        }

        /// <summary>Something that is seen has changed: an engine that idles draws again.</summary>
        public static void RequestFrames() => wantsFrames = true;

        /// <summary>The GPU told something of a frame that it drew.</summary>
        public static void FeedbackCame() => views?.ReadStatuses(stage);

        /// <summary>Whether a camera is one that draws volumes, as it is now.</summary>
        public static bool Draws(Camera camera)
        {
            if (camera == null || LumivoxVolume.All.Count == 0 || camera.cullingMask == 0) return false;
            if (camera.cameraType != CameraType.Game && camera.cameraType != CameraType.SceneView && camera.cameraType != CameraType.VR) return false;
            if (worlds != null && worlds.Skies.Owns(camera)) return false;
            return LumivoxEffect.TryGet(camera, out _);
        }

        /// <summary>How far a camera's image is.</summary>
        public static LumivoxStatus StatusOf(Camera camera) =>
            views != null && camera != null ? views.StatusOf(camera, worlds) : default;

        /// <summary>Voxels of a scan along an axis for one on the GPU, where it has no room for all; else 1.</summary>
        public static int ReductionOf(IntPtr volume)
        {
            if (stage == IntPtr.Zero || volume == IntPtr.Zero) return 1;
            uint factor, arriving;
            if (Library.lumivox_volume_resolution(stage, volume, &factor, &arriving) < 0 || arriving != 0) return 1;
            return Math.Max(1, (int)factor);
        }

        /// <summary>Records all that a view draws in this frame. Returns whether that is anything.</summary>
        public static bool Record(CommandBuffer cmd, in ViewInputs inputs)
        {
            if (!Draws(inputs.Camera) || !LumivoxEffect.TryGet(inputs.Camera, out var settings) || !Start()) return false;
            if (executor.IsLost)
            {
                // A new device has nothing of what the old one had.
                StopDevice();
                if (!Start()) return false;
            }
            try
            {
                return views.Record(cmd, stage, executor, worlds, inputs, settings);
            }
            catch (LumivoxException thrown)
            {
                Report(thrown.Message);
                return false;
            }
        }

        /// <summary>Writes what a camera sees as a scene document. Throws what keeps it from that.</summary>
        public static void Save(Camera camera, in SavedView view, in LumivoxSettings settings, string opened, string path)
        {
            if (!Start()) throw new LumivoxException(error);
            // All of them, though some were made a moment ago.
            LightFinder.FindAll();
            worlds.Forget();
            var world = worlds.Gather(stage, camera, settings.environmentSource == LumivoxEnvironmentSource.Studio, views.Frame);
            worlds.Forget();
            if (world == null) throw new LumivoxException("The camera sees no volume: there is nothing to save.");
            if (worlds.AwaitsSky(world.Number)) throw new LumivoxException("The sky that lights the volumes is still being read: let a few frames be drawn, and save the scene again.");
            var of = view;
            fixed (byte* utf8 = Border.Utf8(path), was = Border.Utf8(opened)) Border.Checked(Library.lumivox_stage_save_world(stage, world.Number, &of, EnvironmentReader.Radiance, was, utf8));
        }

        /// <summary>A frame begins: errors of the one before have been told, and hold if they are met again.</summary>
        public static void BeginFrame()
        {
            error = frameError;
            frameError = "";
        }

        /// <summary>What could not be drawn since this was asked last; null: nothing. Cameras that are drawn in between alone can be the cause.</summary>
        public static string TakeFault()
        {
            var fault = untoldFault;
            untoldFault = null;
            return fault;
        }

        /// <summary>Something cannot be drawn. It is said once.</summary>
        public static void Report(string why)
        {
            frameError = why;
            untoldFault = why;
            if (error == why) return;
            error = why;
            if (why != Border.Fault) Debug.LogError($"Lumivox cannot draw the volumes: {why}");
        }

        /// <summary>A turn of the main thread, outside of all rendering.</summary>
        public static void Tick()
        {
            LumivoxVolumeAsset.CloseUnused(KeptSeconds);
            StopWhenIdle();
            if (stage != IntPtr.Zero)
            {
                executor.Turn();
                worlds.Tick();
                views.ReadStatuses(stage);
                wantsFrames |= views.WantFrames || worlds.AwaitsSkies;
            }
            wantsFrames |= Jobs.Count > 0;
            if (!wantsFrames) return;
            wantsFrames = false;
#if UNITY_EDITOR
            // Its views are drawn on demand.
            UnityEditor.SceneView.RepaintAll();
            if (!Application.isPlaying) UnityEditor.EditorApplication.QueuePlayerLoopUpdate();
#endif
        }

        /// <summary>Frees all that is on the GPU and in the library. The next frame starts anew.</summary>
        public static void Stop()
        {
            Disposal.IsLast = true;
            try
            {
                BuiltInPipeline.Release();
                StopDevice();
            }
            finally
            {
                Disposal.IsLast = false;
            }
        }

        /// <summary>Where no volume is left, nobody would ever free what was shown.</summary>
        static void StopWhenIdle()
        {
            var now = Time.realtimeSinceStartupAsDouble;
            if (stage == IntPtr.Zero || LumivoxVolume.All.Count > 0) idleSince = 0;
            else if (idleSince == 0) idleSince = now;
            else if (now - idleSince > KeptSeconds) Stop();
        }

        static void StopDevice()
        {
            if (executor != null)
            {
                // What is under way still names what is about to go.
                if (SystemInfo.supportsAsyncGPUReadback) AsyncGPUReadback.WaitAllRequests();
                views.Dispose();
                worlds.Dispose();
                executor.Dispose();
                executor = null;
                views = null;
                worlds = null;
            }
            if (stage != IntPtr.Zero) Library.lumivox_stage_free(stage);
            stage = IntPtr.Zero;
            cannotStart = false;
            error = "";
            frameError = "";
        }

        static bool Start()
        {
            if (stage != IntPtr.Zero) return true;
            if (cannotStart) return false;
            var why = Border.Fault ?? DeviceFault();
            if (why != null)
            {
                cannotStart = true;
                Report(why);
                frameError = "";
                return false;
            }
            var limits = Limits();
            stage = Library.lumivox_stage_new(&limits);
            if (stage == IntPtr.Zero)
            {
                cannotStart = true;
                Report(Border.LastError());
                return false;
            }
            executor = new Executor(stage);
            worlds = new WorldGatherer();
            views = new ViewRenderer();
            return true;
        }

        /// <summary>Why nothing can be drawn on this machine; null where it can.</summary>
        internal static string DeviceFault()
        {
            if (SystemInfo.graphicsDeviceType == GraphicsDeviceType.Null) return "there is no graphics device: volumes are not drawn without one.";
            if (!SystemInfo.supportsComputeShaders) return $"{SystemInfo.graphicsDeviceType} runs no compute shaders: choose Direct3D 11 or 12, Vulkan or Metal in Project Settings > Player > Graphics APIs.";
            if (!SystemInfo.supports3DTextures) return $"{SystemInfo.graphicsDeviceType} on this device has no 3D textures.";
            // What values of 8 and 16 bits are kept in where there are no textures of theirs.
            if (!Formats.AreWritten(GraphicsFormat.R16_SFloat)) return $"{SystemInfo.graphicsDeviceType} on this device cannot write textures of half floats (R16_SFloat). Update its driver, or choose another graphics API in Project Settings > Player.";
            return null;
        }

        static DeviceLimits Limits()
        {
            var settings = LumivoxProjectSettings.Current;
            var device = SystemInfo.graphicsDeviceName ?? "";
            return new DeviceLimits
            {
                maxTexture3d = (uint)SystemInfo.maxTexture3DSize,
                maxTexture2d = (uint)SystemInfo.maxTextureSize,
                maxBufferBytes = (ulong)SystemInfo.maxGraphicsBufferSize,
                voxelBytes = settings != null ? (ulong)settings.voxelMegabytes << 20 : 0,
                unorm16 = Formats.AreWritten(GraphicsFormat.R16_UNorm) ? 1u : 0u,
                isSoftware = IsSoftware(device) ? 1u : 0u,
            };
        }

        static bool IsSoftware(string device)
        {
            foreach (var name in softwareDevices)
                if (device.IndexOf(name, StringComparison.OrdinalIgnoreCase) >= 0) return true;
            return false;
        }

        static readonly string[] softwareDevices = { "llvmpipe", "SwiftShader", "Basic Render Driver" };
    }
}
