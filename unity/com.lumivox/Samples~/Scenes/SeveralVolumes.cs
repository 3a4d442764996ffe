using UnityEngine;

namespace Lumivox.Samples
{
    /// <summary>Many volumes of one scan, turned, scaled and overlapping, on a spiral: they sort and blend by themselves.</summary>
    [AddComponentMenu("Lumivox/Samples/Several Volumes")]
    public sealed class SeveralVolumes : SampleScene
    {
        [Range(1, 200), Tooltip("How many.")] public int count = 24;
        [Tooltip("Draws the turns and sizes.")] public int seed = 7;

        const float GoldenAngle = 2.399963f;
        static readonly string[] looks = { "ct-muscle", "ct-skin", "ct-bone", "ct-angiography" };

        protected override (Vector3 pivot, float distance) Framing => (new Vector3(0, 0.1f, 0), 1.2f + 0.12f * Mathf.Sqrt(count));

        protected override void Build()
        {
            View.Move(0, 20, 1);
            var random = new System.Random(seed);
            float Between(float low, float high) => low + (high - low) * (float)random.NextDouble();
            // Few transfer functions for many volumes: they may be shared.
            var functions = System.Array.ConvertAll(looks, look => LumivoxTransferFunction.Preset(look));
            for (var i = 0; i < count; i++)
            {
                var radius = 0.15f * Mathf.Sqrt(i + 0.5f);
                var angle = i * GoldenAngle;
                var place = new Vector3(radius * Mathf.Cos(angle), 0.13f + 0.1f * Mathf.Sin(radius * 5), radius * Mathf.Sin(angle));
                var volume = Volume($"Volume {i + 1}", place, "");
                volume.transform.localRotation = Quaternion.Euler(Between(-20, 20), Between(-180, 180), Between(-20, 20));
                volume.transform.localScale = Vector3.one * Between(0.55f, 1);
                volume.transferFunction = functions[i % functions.Length];
            }
        }
    }
}
