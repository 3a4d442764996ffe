using UnityEngine;

namespace Lumivox.Samples
{
    /// <summary>A scene that builds itself when it is played: a light, a camera, a floor and what the sample is about.</summary>
    public abstract class SampleScene : MonoBehaviour
    {
        [Tooltip("What volumes show; the phantom of a head without one.")] public LumivoxVolumeAsset scan;

        protected OrbitCamera View { get; private set; }

        /// <summary>Where the camera looks, and from how far.</summary>
        protected abstract (Vector3 pivot, float distance) Framing { get; }

        protected abstract void Build();

        protected virtual void Start()
        {
            if (scan == null) scan = DefaultScan();
            var sun = Child("Sun").AddComponent<Light>();
            sun.type = LightType.Directional;
            sun.intensity = 1.2f;
            sun.transform.rotation = Quaternion.Euler(42, -35, 0);
            var camera = Camera.main;
            if (camera == null)
            {
                camera = Child("Camera").AddComponent<Camera>();
                camera.tag = "MainCamera";
            }
            camera.nearClipPlane = 0.02f;
            View = camera.gameObject.AddComponent<OrbitCamera>();
            (View.pivot, View.distance) = Framing;
            View.Move(0.001f, 0, 1);
            Build();
            // Lights are otherwise found within half a second of being made.
            LumivoxRenderer.FindLights();
        }

        protected virtual LumivoxVolumeAsset DefaultScan() => LumivoxVolumeAsset.Phantom("head", 192);

        protected GameObject Child(string name)
        {
            var child = new GameObject(name);
            child.transform.SetParent(transform, false);
            return child;
        }

        /// <summary>A volume that shows the scan as a preset has it; presets for CT need not wait for the voxels.</summary>
        protected LumivoxVolume Volume(string name, Vector3 position, string preset)
        {
            var volume = Child(name).AddComponent<LumivoxVolume>();
            volume.transform.localPosition = position;
            volume.volume = scan;
            if (preset != "") volume.ApplyPreset(preset);
            return volume;
        }

        protected GameObject Shape(PrimitiveType type, Vector3 position, float size, Color color)
        {
            var shape = GameObject.CreatePrimitive(type);
            shape.transform.SetParent(transform, false);
            shape.transform.localPosition = position;
            shape.transform.localScale = Vector3.one * size;
            // The pipeline's own material, tinted.
            shape.GetComponent<Renderer>().material.color = color;
            return shape;
        }
    }
}
