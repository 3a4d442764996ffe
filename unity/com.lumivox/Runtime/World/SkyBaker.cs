// Skyboxes as maps: the material is drawn into a cube, which comes back and becomes a panorama on another thread. It is
// done again when the material or the sun changes.
using System;
using System.Threading.Tasks;
using Lumivox.Native;
using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    /// <summary>One sky, a material or a cube of the host's own, for all worlds that it lights: see <see cref="Skies"/>.</summary>
    internal sealed unsafe class SkyBaker : IDisposable
    {
        /// <summary>Texels along a side of a face, and around the map.</summary>
        const int Side = 128, Width = 512, Height = 256;

        /// <summary>Turns between two looks at what a sky is made of.</summary>
        const int TurnsBetweenLooks = 10;

        /// <summary>Attempts after which a sky that cannot be had is done without.</summary>
        const int MostTries = 3;

        readonly Material material;
        readonly Cubemap cubemap;
        readonly float[] faces = new float[6 * Side * Side * 4];
        readonly CubeReader reader = new CubeReader(Side);
        readonly Action<AsyncGPUReadbackRequest> came;
        ulong fingerprint;
        ulong mapHash;
        MapHandle map;
        Camera camera;
        RenderTexture cube;
        Task<float[]> converting;
        int nextLook;
        int tries;
        bool isWanted, isReading, isDisposed;

        public SkyBaker(Material material)
        {
            this.material = material;
            came = Came;
            Want(Fingerprint(material));
        }

        public SkyBaker(Cubemap cubemap)
        {
            this.cubemap = cubemap;
            came = Came;
            Want(0);
        }

        /// <summary>How many worlds it lights.</summary>
        public int Users;

        /// <summary>Counts its maps: 0 before the first.</summary>
        public int Version { get; private set; }

        /// <summary>The newest map; zero where there is none yet.</summary>
        public IntPtr Map => map != null ? map.Pointer : IntPtr.Zero;

        /// <summary>Whether a map is on its way.</summary>
        public bool IsBusy => isWanted || isReading || converting != null;

        /// <summary>Whether a camera is the one that the sky is drawn with.</summary>
        public bool Owns(Camera other) => !ReferenceEquals(camera, null) && ReferenceEquals(camera, other);

        public bool Shows(Material other) => !ReferenceEquals(material, null) && ReferenceEquals(material, other);

        public bool Shows(Cubemap other) => !ReferenceEquals(cubemap, null) && ReferenceEquals(cubemap, other);

        /// <summary>Whether it has changed. Called while a frame is drawn: the baking itself waits for the next turn.</summary>
        public void Look()
        {
            if (ReferenceEquals(material, null) || nextLook-- > 0) return;
            nextLook = TurnsBetweenLooks;
            var now = Fingerprint(material);
            if (now != fingerprint) Want(now);
        }

        /// <summary>Between frames: what is drawn here would be drawn within another camera's picture otherwise.</summary>
        public void Tick()
        {
            if (converting != null && converting.IsCompleted) Take();
            if (!isWanted || isReading || converting != null) return;
            isWanted = false;
            if (cubemap != null) Read(cubemap);
            else if (material != null && tries < MostTries) Bake();
            else ReadReflection();
        }

        public void Dispose()
        {
            isDisposed = true;
            map?.Dispose();
            map = null;
            // What is read back still names them.
            if (!isReading)
            {
                Executor.Destroy(cube);
                reader.Dispose();
            }
            if (camera != null) Disposal.Destroy(camera.gameObject);
            camera = null;
        }

        void Want(ulong now)
        {
            fingerprint = now;
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
                // The scene's may be another meanwhile, as where the editor shows a prefab.
                hidden.AddComponent<Skybox>().material = material;
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

        void Read(Texture of)
        {
            if (!SystemInfo.supportsAsyncGPUReadback) return;
            try
            {
                reader.Read(of, came);
                isReading = true;
            }
            catch (LumivoxException error)
            {
                Debug.LogError($"Lumivox: the sky does not light the volumes: {error.Message}");
            }
        }

        void Came(AsyncGPUReadbackRequest request)
        {
            isReading = false;
            if (isDisposed)
            {
                Executor.Destroy(cube);
                reader.Dispose();
                return;
            }
            if (request.hasError)
            {
                isWanted = ++tries <= MostTries;
                return;
            }
            var side = reader.Side;
            var texels = request.GetData<float>();
            for (var i = 0; i < texels.Length; i++) faces[i] = texels[i];
            converting = Task.Run(() => CubeMap.Panorama(faces, side, Width, Height, 1f));
        }

        void Take()
        {
            var task = converting;
            converting = null;
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
                (map, mapHash) = (made, hash);
                Version++;
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
