using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>
    /// A scene document: the file by which all hosts of Lumivox tell each other what they show. <see cref="Save"/> writes what a
    /// camera sees, <see cref="Load"/> opens one; in the editor it is an asset, and 'Assets > Create > Lumivox > Scene from View'
    /// makes one. The component is on the root of what was opened, and holds what no other one does.
    /// </summary>
    [DisallowMultipleComponent, AddComponentMenu("")]
    public sealed unsafe class LumivoxScene : MonoBehaviour
    {
        /// <summary>The curve from light to pixels with which other hosts show the scene. Unity shows it with its own.</summary>
        public enum Tone
        {
            /// <summary>Clipped.</summary>
            Plain = 0,
            /// <summary>Film-like, soft.</summary>
            Agx = 1,
            /// <summary>Film-like, of more contrast.</summary>
            Aces = 2,
        }

        [SerializeField, Tooltip("The camera from which the scene is seen.")]
        Camera m_Camera;
        [SerializeField, Tooltip("Width and height of the image that other hosts render, in pixels.")]
        Vector2Int m_ImageSize = new Vector2Int(768, 768);
        [SerializeField, Tooltip("Whether the file says how many samples the image has.")]
        bool m_SaysSamples;
        [SerializeField, Tooltip("Chooses the noise of the image that other hosts render.")]
        int m_Seed;
        [SerializeField, Tooltip("The curve from light to pixels with which other hosts show it. Unity shows it with its own.")]
        Tone m_Tone;
        [SerializeField, Tooltip("Brightens the mid-tones above 1, in other hosts.")]
        float m_Gamma = 1f;
        [SerializeField, TextArea, Tooltip("What is worth knowing of the scene as it was opened.")]
        string[] m_Notes = Array.Empty<string>();
        // With the digits that objects do not hold.
        [SerializeField, HideInInspector]
        string m_Document = "";

        /// <summary>The camera from which the scene is seen.</summary>
        public Camera sceneCamera => m_Camera;

        /// <summary>Width and height of the image that other hosts render, in pixels.</summary>
        public Vector2Int imageSize => m_ImageSize;

        /// <summary>The curve from light to pixels with which other hosts show it.</summary>
        public Tone tone => m_Tone;

        /// <summary>What is worth knowing of the scene as it was opened, in sentences for people: a scan that is another than it was, say.</summary>
        public IReadOnlyList<string> notes => m_Notes;

        /// <summary>
        /// Writes what a camera sees of volumes, with its lights and the light around, as a scene document; whole, or not at all.
        /// Scans are not copied: the file names theirs. A sky that came from no file is written beside it (.sky.exr).
        /// </summary>
        /// <exception cref="LumivoxException">It cannot be saved: something that is seen has no file, is still being read, or the file cannot be written.</exception>
        public static void Save(Camera camera, string path)
        {
            MainThread.Need("LumivoxScene.Save");
            Border.Need();
            if (camera == null) throw new LumivoxException("There is no camera to save a scene of: it is null.");
            if (string.IsNullOrWhiteSpace(path)) throw new LumivoxException("A scene is saved to a file: its path is empty.");
            if (!LumivoxEffect.TryGet(camera, out var settings)) throw new LumivoxException($"The camera '{camera.name}' draws no volumes: its Lumivox Effect is disabled.");
            foreach (var volume in LumivoxVolume.All) NeedReady(volume, camera);
            var view = ViewOf(camera, settings);
            var own = camera.gameObject.GetComponentInParent<LumivoxScene>(true);
            LumivoxRuntime.Save(camera, view, settings, own != null ? own.m_Document : "", path);
        }

        /// <summary>
        /// Opens a scene document on another thread, and makes its objects when all of it is there: a root with this component,
        /// and below it volumes, lights and a camera. Whoever destroys the root destroys <see cref="assets"/>, too.
        /// </summary>
        /// <param name="path">The file.</param>
        /// <param name="progressed">Told on the main thread how far it is.</param>
        /// <param name="cancel">Stops it: the task is cancelled.</param>
        /// <param name="allowOutsideData">Whether headers such as .mhd may name data files anywhere.</param>
        /// <exception cref="LumivoxException">From the task: something is wrong with the document or its files; the message names its line.</exception>
        public static Task<LumivoxScene> Load(string path, Action<LumivoxProgress> progressed = null, CancellationToken cancel = default, bool allowOutsideData = false)
        {
            MainThread.Need("LumivoxScene.Load");
            return Open(path, progressed, cancel, allowOutsideData, opened =>
            {
                using (opened)
                {
                    var scene = SceneReader.Make(opened, System.IO.Path.GetFileNameWithoutExtension(path), new LoadedAssets());
                    LightFinder.FindAll();
                    return scene;
                }
            });
        }

        /// <summary>What <see cref="Load"/> has made besides objects: scans, labels, transfer functions and a sky, which no scene keeps.</summary>
        public IReadOnlyList<ScriptableObject> assets => made;

        [NonSerialized] internal readonly List<ScriptableObject> made = new List<ScriptableObject>();

        /// <summary>Whether a file begins as scene documents do.</summary>
        internal static bool IsOne(string path)
        {
            fixed (byte* utf8 = Border.Utf8(path)) return Library.lumivox_scene_is_one(utf8) == 1;
        }

        /// <summary>Opens a document on another thread; what becomes of it is made on the main one.</summary>
        internal static Task<T> Open<T>(string path, Action<LumivoxProgress> progressed, CancellationToken cancel, bool allowOutsideData, Func<SceneHandle, T> make)
        {
            Border.Need();
            var task = new TaskCompletionSource<T>();
            CancellationTokenRegistration registration = default;
            IntPtr pointer;
            fixed (byte* utf8 = Border.Utf8(path ?? "")) pointer = Library.lumivox_scene_open(utf8, allowOutsideData ? 1u : 0u);
            var job = Jobs.Follow(pointer, (ended, state) =>
            {
                registration.Dispose();
                if (state == JobState.Cancelled) task.TrySetCanceled();
                else if (state != JobState.Done) task.TrySetException(new LumivoxException(ended.Error));
                else if (Jobs.Try(task, () => make(new SceneHandle(Border.Checked(Library.lumivox_job_take_scene(ended.Pointer)))), out var taken)) task.TrySetResult(taken);
            });
            if (progressed != null) job.Progressed += of => progressed(new LumivoxProgress(of.Stage, of.Done, of.Total));
            if (cancel.CanBeCanceled) registration = cancel.Register(job.Cancel);
            return task.Task;
        }

        /// <summary>Takes over what a document says of its image.</summary>
        internal void Take(in SavedView view, Camera of, string[] about, string document)
        {
            m_Camera = of;
            m_ImageSize = new Vector2Int((int)view.width, (int)view.height);
            m_SaysSamples = view.samples > 0;
            m_Seed = unchecked((int)view.seed);
            m_Tone = (Tone)view.tone;
            m_Gamma = view.gamma;
            m_Notes = about;
            m_Document = document;
        }

        static void NeedReady(LumivoxVolume volume, Camera camera)
        {
            if (((1 << volume.gameObject.layer) & camera.cullingMask) == 0 || volume.volume == null) return;
            if (volume.volume.state == LumivoxVolumeState.Loading || volume.labels != null && volume.labels.IsComing)
                throw new LumivoxException($"'{volume.name}' is still being read: save the scene when it is seen.");
            if (volume.isPreparing) throw new LumivoxException($"'{volume.name}' is still being prepared: save the scene when it is seen as it should be.");
        }

        static SavedView ViewOf(Camera camera, in LumivoxSettings settings)
        {
            var view = new SavedView
            {
                worldFromCamera = camera.cameraToWorldMatrix,
                fieldOfView = FieldOfView(camera),
                width = (uint)Mathf.Max(1, camera.pixelWidth),
                height = (uint)Mathf.Max(1, camera.pixelHeight),
                samples = (uint)settings.targetSamples,
                // Documents know no less.
                noise = settings.targetNoise > 0f ? Mathf.Max(settings.targetNoise, 1e-4f) : 0f,
                denoise = settings.denoise ? 1u : 0u,
                exposure = Mathf.Clamp(settings.exposure, -32f, 32f),
                gamma = 1f,
            };
            var behind = camera.backgroundColor;
            if (camera.clearFlags == CameraClearFlags.Skybox) view.background = SavedView.Environment;
            else if (camera.clearFlags == CameraClearFlags.SolidColor && behind.a > 0f)
            {
                view.background = SavedView.Plain;
                view.color = new Vector3(behind.r, behind.g, behind.b);
            }
            var own = camera.gameObject.GetComponentInParent<LumivoxScene>(true);
            if (own == null) return view;
            (view.width, view.height) = ((uint)own.m_ImageSize.x, (uint)own.m_ImageSize.y);
            view.seed = unchecked((uint)own.m_Seed);
            view.tone = (uint)own.m_Tone;
            view.gamma = own.m_Gamma;
            if (!own.m_SaysSamples && settings.targetSamples == LumivoxSettings.Default.targetSamples) view.samples = 0;
            return view;
        }

        /// <summary>Degrees from the bottom to the top, as its projection has them.</summary>
        static float FieldOfView(Camera camera)
        {
            const float Off = 1e-3f;
            var projection = camera.nonJitteredProjectionMatrix;
            if (camera.orthographic || Mathf.Abs(projection.m32 + 1f) > Off) throw new LumivoxException($"The camera '{camera.name}' is orthographic, and scenes are seen in perspective: choose Projection > Perspective.");
            if (Mathf.Abs(projection.m02) > Off || Mathf.Abs(projection.m12) > Off) throw new LumivoxException($"The camera '{camera.name}' looks past its middle (a lens shift, or a projection of its own), which scenes cannot say.");
            var seen = 2f * Mathf.Atan(1f / projection.m11) * Mathf.Rad2Deg;
            return Mathf.Abs(seen - camera.fieldOfView) < 1e-3f ? camera.fieldOfView : seen;
        }

        /// <summary>Scans and the like that live as long as somebody has them.</summary>
        sealed class LoadedAssets : ISceneAssets
        {
            public LumivoxVolumeAsset Scan(VolumeHandle opened) => LumivoxVolumeAsset.Of(opened);

            public void Keep(string name, ScriptableObject asset)
            {
            }
        }
    }
}
