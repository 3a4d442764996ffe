// Skyboxes as maps: the material is drawn into a cube, which comes back and becomes a panorama on another thread. It is
// done again when the material or the sun changes.
using System;
using System.Threading.Tasks;
using Lumivox.Native;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    internal sealed unsafe class SkyBaker : IDisposable
    {
        /// <summary>Texels along a side of a face, and around the map.</summary>
        const int Side = 128, Width = 512, Height = 256;

        /// <summary>Turns between two looks at what a sky is made of.</summary>
        const int TurnsBetweenLooks = 10;

        /// <summary>Attempts after which a sky that cannot be had is done without.</summary>
        const int MostTries = 3;

        readonly float[] faces = new float[6 * Side * Side * 4];
        readonly Action<AsyncGPUReadbackRequest> came;
        Material sky;
        Cubemap cubemap;
        ulong fingerprint;
        ulong mapHash;
        MapHandle map;
        Camera camera;
        RenderTexture cube;
        Task<float[]> converting;
        int nextLook;
        int tries;
        /// <summary>Counts skies that were looked away from, and what that was when the one that is read was asked for.</summary>
        int lookedAway, readAfter;
        bool isWanted, isReading, isUnseen, isDisposed;
        float scale = 1f;

        public SkyBaker() => came = Came;

        /// <summary>The map for a frame; zero where there is none yet.</summary>
        public IntPtr Use()
        {
            isUnseen = false;
            return map != null ? map.Pointer : IntPtr.Zero;
        }

        /// <summary>Whether the map that was used last is not that of the sky as it is now.</summary>
        public bool IsAwaited => isWanted || isReading || isUnseen || converting != null;

        /// <summary>Whether a camera is the one that skies are drawn with.</summary>
        public bool Owns(Camera other) => !ReferenceEquals(camera, null) && ReferenceEquals(camera, other);

        /// <summary>The sky of the frame's scenes. Called while it is drawn: the baking itself waits for the next turn.</summary>
        public void Look(Material material)
        {
            if (material == sky && ReferenceEquals(cubemap, null) && nextLook-- > 0) return;
            nextLook = TurnsBetweenLooks;
            var now = Fingerprint(material);
            if (now == fingerprint && material == sky) return;
            Want(material, null, now, 1f);
        }

        /// <summary>A cube of the host's own, times a factor.</summary>
        public void Look(Cubemap of, float factor)
        {
            if (ReferenceEquals(of, cubemap) && factor == scale) return;
            Want(null, of, 0, factor);
        }

        /// <summary>There is no sky to bake: what was baked, or is about to be, is nobody's any more.</summary>
        public void LookAway()
        {
            if (ReferenceEquals(sky, null) && ReferenceEquals(cubemap, null) && map == null) return;
            (sky, cubemap, fingerprint) = (null, null, 0);
            isWanted = isUnseen = false;
            lookedAway++;
            map?.Dispose();
            map = null;
        }

        /// <summary>Between frames: what is drawn here would be drawn within another camera's picture otherwise.</summary>
        public void Tick()
        {
            if (converting != null && converting.IsCompleted) Take();
            if (!isWanted || isReading || converting != null) return;
            isWanted = false;
            if (cubemap != null) Read(cubemap);
            else if (sky != null && tries < MostTries) Bake();
            else ReadReflection();
        }

        public void Dispose()
        {
            isDisposed = true;
            map?.Dispose();
            map = null;
            Executor.Destroy(cube);
            cube = null;
            if (camera != null) Disposal.Destroy(camera.gameObject);
            camera = null;
        }

        void Want(Material material, Cubemap of, ulong now, float factor)
        {
            (sky, cubemap, fingerprint, scale) = (material, of, now, factor);
            tries = 0;
            isWanted = true;
        }

        void Bake()
        {
            tries++;
            if (camera == null)
            {
                var hidden = new GameObject("Lumivox Sky") { hideFlags = HideFlags.HideAndDontSave };
                camera = hidden.AddComponent<Camera>();
                camera.enabled = false;
                camera.cameraType = CameraType.Reflection;
                camera.clearFlags = CameraClearFlags.Skybox;
                camera.cullingMask = 0;
                camera.allowHDR = true;
                camera.allowMSAA = false;
                camera.useOcclusionCulling = false;
            }
            if (cube == null)
                cube = new RenderTexture(Side, Side, 16, RenderTextureFormat.ARGBHalf)
                {
                    name = "Lumivox Sky",
                    dimension = TextureDimension.Cube,
                    hideFlags = HideFlags.HideAndDontSave,
                };
            if (camera.RenderToCubemap(cube)) Read(cube);
            else ReadReflection();
        }

        /// <summary>What reflects the sky where no probe does: coarser, but always there.</summary>
        void ReadReflection()
        {
            var reflection = ReflectionProbe.defaultTexture;
            if (reflection != null && reflection.dimension == TextureDimension.Cube) Read(reflection);
        }

        int readSide;

        void Read(Texture of)
        {
            if (!SystemInfo.supportsAsyncGPUReadback) return;
            // Finer ones have a level of about the size.
            var level = 0;
            while (of.width >> level > Side && level + 1 < of.mipmapCount) level++;
            readSide = Math.Max(1, of.width >> level);
            if (readSide > Side) return;
            isReading = true;
            readAfter = lookedAway;
            AsyncGPUReadback.Request(of, level, TextureFormat.RGBAFloat, came);
        }

        void Came(AsyncGPUReadbackRequest request)
        {
            isReading = false;
            if (isDisposed || readAfter != lookedAway) return;
            if (request.hasError || request.layerCount < 6)
            {
                isWanted = ++tries <= MostTries;
                return;
            }
            var side = readSide;
            for (var face = 0; face < 6; face++)
            {
                var texels = request.GetData<float>(face);
                for (var i = 0; i < side * side * 4; i++) faces[face * side * side * 4 + i] = texels[i];
            }
            var factor = scale;
            converting = Task.Run(() => CubeMap.Panorama(faces, side, Width, Height, factor));
        }

        void Take()
        {
            var task = converting;
            converting = null;
            if (readAfter != lookedAway) return;
            if (task.IsFaulted)
            {
                Debug.LogException(task.Exception);
                return;
            }
            var hash = CubeMap.Hash(task.Result);
            // The same picture again starts no image over.
            if (map != null && hash == mapHash) return;
            fixed (float* rgb = task.Result)
            {
                var made = new MapHandle(Border.Checked(Library.lumivox_map_new(Width, Height, rgb)));
                map?.Dispose();
                (map, mapHash, isUnseen) = (made, hash, true);
            }
            LumivoxRuntime.RequestFrames();
        }

        /// <summary>Changes when the sky may: with its material's numbers and textures, and the sun that some show.</summary>
        static ulong Fingerprint(Material material)
        {
            if (material == null) return 1;
            var hash = 14695981039346656037ul;
            void Mix(int value) => hash = (hash ^ (uint)value) * 1099511628211ul;
            Mix(material.ComputeCRC());
            var sun = RenderSettings.sun;
            if (sun != null && sun.isActiveAndEnabled)
            {
                var direction = sun.transform.forward;
                var color = LightReader.ColorOf(sun);
                Mix(direction.GetHashCode());
                Mix(color.GetHashCode());
            }
            return hash;
        }
    }
}
