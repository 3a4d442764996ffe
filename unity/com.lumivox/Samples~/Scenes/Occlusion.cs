using UnityEngine;

namespace Lumivox.Samples
{
    /// <summary>Spheres before, in and behind a translucent head; one flies around it.</summary>
    [AddComponentMenu("Lumivox/Samples/Occlusion")]
    public sealed class Occlusion : SampleScene
    {
        [Tooltip("Seconds of one round; 0 stands still.")] public float period = 9;
        [Tooltip("Thin enough to look into.")] public float density = 0.06f;

        Transform traveller;
        /// Half hidden by the head.
        float phase = 0.38f;

        protected override (Vector3 pivot, float distance) Framing => (new Vector3(0, 0.02f, 0), 0.75f);

        protected override void Build()
        {
            var head = Volume("Head", Vector3.zero, "ct-muscle");
            head.density = density;
            head.surfaceStrength = 0.25f;
            // Each overlaps the head as the camera sees it, so that one tells which of the two hides the other.
            Shape(PrimitiveType.Sphere, new Vector3(-0.025f, -0.05f, -0.17f), 0.07f, new Color(0.9f, 0.35f, 0.2f));
            Shape(PrimitiveType.Sphere, new Vector3(0.02f, 0, 0.21f), 0.12f, new Color(0.25f, 0.5f, 0.9f));
            Shape(PrimitiveType.Cube, new Vector3(0, -0.16f, 0), 0.03f, Color.white).transform.localScale = new Vector3(1, 0.02f, 1);
            traveller = Shape(PrimitiveType.Sphere, Vector3.zero, 0.06f, new Color(0.95f, 0.8f, 0.25f)).transform;
            Shape(PrimitiveType.Sphere, new Vector3(0, 0.085f, 0.01f), 0.07f, new Color(0.3f, 0.75f, 0.35f));
            Move();
        }

        void Update()
        {
            if (period <= 0 || traveller == null) return;
            phase = Mathf.Repeat(phase + Time.deltaTime / period, 1);
            Move();
        }

        void Move()
        {
            var angle = phase * 2 * Mathf.PI;
            traveller.localPosition = new Vector3(0.2f * Mathf.Sin(angle), 0.01f + 0.03f * Mathf.Sin(angle * 2), -0.2f * Mathf.Cos(angle));
        }
    }
}
