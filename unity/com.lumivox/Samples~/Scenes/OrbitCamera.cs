using UnityEngine;

namespace Lumivox.Samples
{
    /// <summary>A camera that circles around a point and stands still when nobody moves it, so that an image can converge.</summary>
    [RequireComponent(typeof(Camera)), AddComponentMenu("Lumivox/Samples/Orbit Camera")]
    public sealed class OrbitCamera : MonoBehaviour
    {
        [Tooltip("The point that is looked at.")] public Vector3 pivot;
        [Tooltip("Metres from there.")] public float distance = 0.8f;
        [Tooltip("Degrees about the vertical axis, and above the horizon.")] public float azimuth = 20, elevation = 8;
        [Tooltip("Degrees in a second while keys are held.")] public float speed = 60;

        void OnEnable() => Place();

        void OnValidate() => Place();

        /// <summary>Turns by degrees and zooms by a factor.</summary>
        public void Move(float turn, float raise, float zoom)
        {
            if (turn == 0 && raise == 0 && zoom == 1) return;
            azimuth += turn;
            elevation = Mathf.Clamp(elevation + raise, -85, 85);
            distance = Mathf.Clamp(distance / zoom, 0.05f, 20);
            Place();
        }

#if ENABLE_LEGACY_INPUT_MANAGER
        void Update()
        {
            var by = speed * Time.deltaTime;
            float Held(KeyCode less, KeyCode more) => (Input.GetKey(more) ? 1 : 0) - (Input.GetKey(less) ? 1 : 0);
            Move(Held(KeyCode.RightArrow, KeyCode.LeftArrow) * by, Held(KeyCode.DownArrow, KeyCode.UpArrow) * by, 1 + Held(KeyCode.PageDown, KeyCode.PageUp) * Time.deltaTime);
        }
#endif

        void Place()
        {
            var turn = Quaternion.Euler(elevation, azimuth, 0);
            transform.SetPositionAndRotation(pivot - turn * Vector3.forward * distance, turn);
        }
    }
}
