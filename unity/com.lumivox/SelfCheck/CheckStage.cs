// A small scene of the self-check's own, with a camera that draws into a texture. In edit mode it lies in a preview scene:
// nothing of the scene that is open is seen in it, lights it or is changed by it.
using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;
using UnityEngine.SceneManagement;
using Object = UnityEngine.Object;

namespace Lumivox.SelfChecks
{
    internal sealed class CheckStage : IDisposable
    {
        /// <summary>Of the pictures, in pixels.</summary>
        public const int Side = 80;

        /// <summary>Milliseconds of the GPU that one drawing may take: an editor stays usable meanwhile.</summary>
        const float BudgetMs = 60f;

        static readonly Color background = new Color(0.44f, 0.49f, 0.56f);

        readonly List<Object> made = new List<Object>();
        readonly RenderTexture target;
        readonly LumivoxEffect effect;
        readonly Lighting lighting;
        readonly PipelineHost host;
        Scene scene;

        /// <summary>What looks at the scene; along +z from wherever it is put.</summary>
        public Camera Camera { get; }

        /// <summary>In a preview scene where `isApart`, which edit mode alone can; otherwise in the scene that plays.</summary>
        public CheckStage(bool isApart, int samples)
        {
            host = PipelineHost.Current ?? throw new LumivoxException("volumes are not drawn in this project's render pipeline");
#if UNITY_EDITOR
            if (isApart) scene = UnityEditor.SceneManagement.EditorSceneManager.NewPreviewScene();
#endif
            try
            {
                target = Keep(new RenderTexture(new RenderTextureDescriptor(Side, Side, GraphicsFormat.R16G16B16A16_SFloat, 32)) { name = "Lumivox Self-Check", hideFlags = HideFlags.HideAndDontSave });
                Camera = Make("Camera").AddComponent<Camera>();
                // It is drawn by Draw alone.
                Camera.enabled = false;
                if (isApart) Camera.scene = scene;
                Camera.targetTexture = target;
                Camera.allowHDR = true;
                Camera.allowMSAA = false;
                Camera.nearClipPlane = 0.02f;
                Camera.farClipPlane = 20f;
                Camera.fieldOfView = 36f;
                Camera.clearFlags = CameraClearFlags.SolidColor;
                Camera.backgroundColor = background;
                host.ShowLightAsItIs(Camera);
                // Whatever lights the project's scenes, a studio lights this one: as bright in physical units as elsewhere.
                effect = Camera.gameObject.AddComponent<LumivoxEffect>();
                effect.environmentSource = LumivoxEnvironmentSource.Studio;
                effect.exposure = -Mathf.Log(EnvironmentReader.Studio.strength, 2f);
                effect.targetSamples = samples;
                effect.frameBudgetMs = BudgetMs;
                lighting = new Lighting(scene);
            }
            catch
            {
                Dispose();
                throw;
            }
        }

        /// <summary>Something that goes when the stage does.</summary>
        public T Keep<T>(T one) where T : Object
        {
            made.Add(one);
            return one;
        }

        public GameObject Make(string name)
        {
#if UNITY_EDITOR
            // The scene that is open does not take notice of what is hidden from its beginning.
            var thing = Keep(UnityEditor.EditorUtility.CreateGameObjectWithHideFlags(name, HideFlags.HideAndDontSave));
#else
            var thing = Keep(new GameObject(name) { hideFlags = HideFlags.HideAndDontSave });
#endif
            if (scene.IsValid()) SceneManager.MoveGameObjectToScene(thing, scene);
            return thing;
        }

        /// <summary>A volume that shows a scan as a preset for CT has it.</summary>
        public LumivoxVolume Volume(LumivoxVolumeAsset scan, string preset)
        {
            var volume = Make(preset).AddComponent<LumivoxVolume>();
            volume.volume = scan;
            volume.ApplyPreset(preset);
            Keep(volume.transferFunction);
            return volume;
        }

        public LumivoxVolumeAsset Phantom(string kind, int size)
        {
            var scan = Keep(LumivoxVolumeAsset.Phantom(kind, size));
            scan.hideFlags = HideFlags.HideAndDontSave;
            return scan;
        }

        /// <summary>Unity's own meshes, of a metre.</summary>
        public const string Sphere = "New-Sphere.fbx", Cube = "Cube.fbx";

        /// <summary>A mesh of Unity's that shines by itself in one colour, whatever lights it: pipelines shade each in their own way.</summary>
        public void Shape(string mesh, Vector3 position, Vector3 size, Color color)
        {
            // Not a primitive of Unity's: those have colliders, and begin in the scene that is open.
            var shape = Make(mesh);
            shape.AddComponent<MeshFilter>().sharedMesh = Resources.GetBuiltinResource<Mesh>(mesh);
            shape.AddComponent<MeshRenderer>().sharedMaterial = Keep(host.Shining(color));
            shape.transform.localPosition = position;
            shape.transform.localScale = size;
        }

        /// <summary>A sun, as bright beside the studio in each pipeline.</summary>
        public void Sun(Quaternion rotation, Color color)
        {
            var sun = Make("Sun").AddComponent<Light>();
            sun.type = LightType.Directional;
            sun.color = color;
            sun.intensity = host.SunIntensity;
            sun.transform.rotation = rotation;
            // Searches go through the scenes that are open.
            LightFinder.Add(sun);
        }

        /// <summary>Draws once. Returns whether there is nothing more to trace.</summary>
        /// <exception cref="LumivoxException">Its volumes cannot be drawn.</exception>
        public bool Draw()
        {
            lighting.Begin();
#if UNITY_EDITOR
            // What is not compiled yet would be drawn with something else in its place.
            var isAsynchronous = UnityEditor.ShaderUtil.allowAsyncCompilation;
            UnityEditor.ShaderUtil.allowAsyncCompilation = false;
#endif
            try
            {
                // Of other cameras, which are drawn between the check's steps.
                LumivoxRuntime.TakeFault();
                host.Draw(Camera);
                // What the GPU tells of it would come with a later frame, and an editor at rest has none.
                if (SystemInfo.supportsAsyncGPUReadback) AsyncGPUReadback.WaitAllRequests();
            }
            finally
            {
#if UNITY_EDITOR
                UnityEditor.ShaderUtil.allowAsyncCompilation = isAsynchronous;
#endif
                lighting.End();
            }
            if (LumivoxRuntime.TakeFault() is string fault) throw new LumivoxException(fault);
            return Status.isShown && Status.isConverged;
        }

        public LumivoxStatus Status => LumivoxRenderer.GetStatus(Camera);

        public CheckPicture Read() => CheckPicture.Of(target);

        public void Dispose()
        {
            // The camera lets go of its texture before that goes.
            for (var i = made.Count - 1; i >= 0; i--)
                if (made[i] != null) Object.DestroyImmediate(made[i]);
            made.Clear();
#if UNITY_EDITOR
            if (scene.IsValid()) UnityEditor.SceneManagement.EditorSceneManager.ClosePreviewScene(scene);
#endif
            scene = default;
        }

        /// <summary>Lighting settings of the stage's own while it is drawn: without fog and ambient light, whatever the open scene has.</summary>
        sealed class Lighting
        {
            readonly Scene scene;
            bool fog;
            AmbientMode mode;
            Color ambient;

            public Lighting(Scene scene) => this.scene = scene;

            public void Begin()
            {
#if UNITY_EDITOR
                if (scene.IsValid() && !UnityEditor.Unsupported.SetOverrideLightingSettings(scene))
                    throw new LumivoxException("the editor does not let the check have lighting of its own now");
#endif
                (fog, mode, ambient) = (RenderSettings.fog, RenderSettings.ambientMode, RenderSettings.ambientLight);
                RenderSettings.fog = false;
                RenderSettings.ambientMode = AmbientMode.Flat;
                RenderSettings.ambientLight = Color.black;
            }

            public void End()
            {
                (RenderSettings.fog, RenderSettings.ambientMode, RenderSettings.ambientLight) = (fog, mode, ambient);
#if UNITY_EDITOR
                if (scene.IsValid()) UnityEditor.Unsupported.RestoreOverrideLightingSettings();
#endif
            }
        }
    }
}
