// Objects of a scene document that the library has opened: the same for a game that loads one and for the editor's importer.
using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox
{
    /// <summary>What becomes of the scans of a scene, and of what else is no object.</summary>
    internal interface ISceneAssets
    {
        /// <summary>A scan or label map that was opened. The handle is the asset's, or disposed of here.</summary>
        LumivoxVolumeAsset Scan(VolumeHandle opened);

        /// <summary>Something that the objects refer to; its name is like no other's.</summary>
        void Keep(string name, ScriptableObject asset);
    }

    internal sealed unsafe class SceneReader
    {
        readonly IntPtr scene;
        readonly ISceneAssets assets;
        readonly List<ScriptableObject> made = new List<ScriptableObject>();
        readonly List<string> notes = new List<string>();

        SceneReader(SceneHandle of, ISceneAssets assets)
        {
            scene = of.Pointer;
            this.assets = assets;
        }

        /// <summary>All objects of a scene below a root, or none: what was made is destroyed if something fails.</summary>
        public static LumivoxScene Make(SceneHandle of, string name, ISceneAssets assets)
        {
            var reader = new SceneReader(of, assets);
            var root = new GameObject(name);
            try
            {
                // Nothing of it is seen before all is there.
                root.SetActive(false);
                var result = reader.Fill(root);
                root.SetActive(true);
                return result;
            }
            catch
            {
                Object.DestroyImmediate(root);
                foreach (var one in reader.made) Object.DestroyImmediate(one);
                throw;
            }
        }

        LumivoxScene Fill(GameObject root)
        {
            var own = root.AddComponent<LumivoxScene>();
            var said = Border.TakeText(Library.lumivox_scene_notes(scene));
            if (!string.IsNullOrEmpty(said)) notes.AddRange(said.Split('\n'));
            root.AddComponent<LumivoxEnvironment>().Take(Environment(out var sky), sky);
            for (uint i = 0; i < Library.lumivox_scene_volume_count(scene); i++) AddVolume(root.transform, i);
            for (uint i = 0; i < Library.lumivox_scene_light_count(scene); i++) AddLight(root.transform, i);
            SavedView view;
            var camera = AddCamera(root.transform, &view);
            own.Take(view, camera, notes.ToArray(), Border.TakeText(Library.lumivox_scene_document(scene)));
            own.made.AddRange(made);
            return own;
        }

        T Keep<T>(string name, T asset) where T : ScriptableObject
        {
            made.Add(asset);
            assets.Keep(name, asset);
            return asset;
        }

        Surroundings Environment(out LumivoxSky sky)
        {
            Surroundings surroundings;
            Border.Checked(Library.lumivox_scene_environment(scene, &surroundings));
            sky = surroundings.map != IntPtr.Zero ? Keep("sky", LumivoxSky.Of(surroundings.map)) : null;
            return surroundings;
        }

        void AddVolume(Transform root, uint index)
        {
            Instance instance;
            ObjectPose pose;
            Border.Checked(Library.lumivox_scene_instance(scene, index, &instance, &pose));
            var scan = Keep($"scan {index}", assets.Scan(new VolumeHandle(Border.Checked(Library.lumivox_scene_volume(scene, index)))));
            LumivoxTransferFunction function;
            using (var native = new TransferFunctionHandle(Border.Checked(Library.lumivox_scene_transfer_function(scene, index))))
                function = Keep($"look {index}", LumivoxTransferFunction.Of(native.Pointer));
            function.name = $"Look {index + 1}";
            if (string.IsNullOrEmpty(scan.name)) scan.name = $"Scan {index + 1}";
            var name = scan.name;
            var volume = Place(root, name, pose).AddComponent<LumivoxVolume>();
            volume.gameObject.layer = LayerOf(instance.layers, name);
            volume.Take(instance, scan, function, Labels(index));
            if (instance.peelMm > LumivoxVolume.MaxPeelMm) notes.Add($"'{name}' is peeled {LumivoxVolume.MaxPeelMm} mm deep, which is the most in Unity, and not {instance.peelMm}.");
            for (uint i = 0; i < instance.clipCount; i++) AddClip(volume.transform, index, i);
        }

        LumivoxLabels Labels(uint index)
        {
            var pointer = Library.lumivox_scene_labels(scene, index);
            if (pointer == IntPtr.Zero) return null;
            var map = Keep($"label map {index}", assets.Scan(new VolumeHandle(pointer)));
            map.name = $"Label Map {index + 1}";
            var labels = Keep($"labels {index}", LumivoxLabels.Of(map));
            labels.name = $"Labels {index + 1}";
            for (uint i = 0; i < Library.lumivox_scene_style_count(scene, index); i++)
            {
                LabelStyle style;
                Border.Checked(Library.lumivox_scene_style(scene, index, i, &style));
                LumivoxTransferFunction own = null;
                if (style.transferFunction != IntPtr.Zero)
                {
                    own = Keep($"label look {index} {style.value}", LumivoxTransferFunction.Of(style.transferFunction));
                    own.name = $"Look {index + 1} of Label {style.value}";
                }
                labels.Take(style, own);
            }
            return labels;
        }

        void AddClip(Transform volume, uint index, uint number)
        {
            ClipShape shape;
            ObjectPose pose;
            Border.Checked(Library.lumivox_scene_clip(scene, index, number, &shape, &pose));
            var clip = Place(volume, ((LumivoxClip.Shape)shape.kind).ToString(), pose).AddComponent<LumivoxClip>();
            (clip.shape, clip.inverted) = ((LumivoxClip.Shape)shape.kind, shape.inverted != 0);
        }

        void AddLight(Transform root, uint index)
        {
            LightSource source;
            ObjectPose pose;
            Border.Checked(Library.lumivox_scene_light(scene, index, &source, &pose));
            var type = source.kind == LightSource.Directional ? LightType.Directional : source.kind == LightSource.Point ? LightType.Point : LightType.Spot;
            var light = Place(root, $"{type} Light {index + 1}", pose).AddComponent<Light>();
            light.type = type;
            LightReader.SetColor(light, source.strength);
            light.cullingMask = unchecked((int)source.layers);
            if (source.kind != LightSource.Directional) light.range = float.IsInfinity(source.range) ? 1000f : source.range;
            if (source.kind == LightSource.Spot)
            {
                light.spotAngle = source.outerHalfAngle * 2f * Mathf.Rad2Deg;
                if (source.outerHalfAngle > 89.5f * Mathf.Deg2Rad) notes.Add($"The spot {index + 1} is {source.outerHalfAngle * 2f * Mathf.Rad2Deg} degrees wide, and Unity's are 179 at most.");
            }
            light.gameObject.AddComponent<LumivoxLight>().Take(source);
        }

        Camera AddCamera(Transform root, SavedView* view)
        {
            ObjectPose pose;
            Border.Checked(Library.lumivox_scene_view(scene, view, &pose));
            var camera = Place(root, "Camera", pose).AddComponent<Camera>();
            camera.fieldOfView = view->fieldOfView;
            // What lies in a body begins near: a tenth of what Unity's own cameras have.
            camera.nearClipPlane = 0.01f;
            camera.allowHDR = true;
            camera.clearFlags = view->background == SavedView.Environment ? CameraClearFlags.Skybox : CameraClearFlags.SolidColor;
            camera.backgroundColor = new Color(view->color.x, view->color.y, view->color.z, view->background == SavedView.Plain ? 1f : 0f);
            var effect = camera.gameObject.AddComponent<LumivoxEffect>();
            var settings = LumivoxSettings.Default;
            settings.exposure = view->exposure;
            if (view->samples > 0) settings.targetSamples = (int)Math.Min(view->samples, 65536u);
            settings.targetNoise = view->noise;
            settings.denoise = view->denoise != 0;
            effect.settings = settings;
            return camera;
        }

        /// <summary>The lowest: an object of Unity's lies on one.</summary>
        int LayerOf(uint layers, string name)
        {
            if (layers != 0 && (layers & (layers - 1)) != 0) notes.Add($"'{name}' lies on several layers in the file, and on the lowest of them in Unity.");
            for (var layer = 0; layer < 32; layer++)
                if ((layers >> layer & 1) != 0) return layer;
            return 0;
        }

        static GameObject Place(Transform parent, string name, in ObjectPose pose)
        {
            var made = new GameObject(name);
            made.transform.SetParent(parent, false);
            made.transform.localPosition = pose.position;
            made.transform.localRotation = pose.rotation;
            made.transform.localScale = pose.scale;
            return made;
        }
    }
}
