using UnityEngine;

namespace Lumivox.Samples
{
    /// <summary>
    /// The test cube three times: as large as it is, twice and four times as large, as much farther away. All three look alike,
    /// for extinction is measured in the scan's own millimetres; with World, larger is more opaque and redder.
    /// </summary>
    [AddComponentMenu("Lumivox/Samples/Cube at Distances")]
    public sealed class CubeAtDistances : SampleScene
    {
        [Tooltip("What a millimetre of extinction is measured in.")] public LumivoxVolume.ExtinctionSpace extinctionSpace = LumivoxVolume.ExtinctionSpace.Volume;
        [Tooltip("Thin enough that the sizes differ with World.")] public float density = 0.1f;

        static readonly float[] scales = { 1, 2, 4 };

        protected override (Vector3 pivot, float distance) Framing => (Vector3.zero, 1);

        protected override LumivoxVolumeAsset DefaultScan() => LumivoxVolumeAsset.Phantom("cube", 96);

        protected override async void Build()
        {
            // Where they stand depends on how large the scan is.
            if (!await scan.Open() || this == null) return;
            View.azimuth = View.elevation = 0;
            View.Move(0, 0.001f, 1);
            var eye = View.transform.position;
            var size = scan.sizeM.x;
            for (var i = 0; i < scales.Length; i++)
            {
                // Along three rays from the camera, so that each fills the same part of the image.
                var direction = Quaternion.Euler(0, (i - 1) * 16, 0) * Vector3.forward;
                var cube = Volume($"Cube x{scales[i]}", Vector3.zero, "ct-muscle");
                cube.transform.position = eye + direction * (size * 4 * scales[i]);
                cube.transform.rotation = Quaternion.Euler(20, (i - 1) * 16 + 30, 0);
                cube.transform.localScale = Vector3.one * scales[i];
                cube.extinctionSpace = extinctionSpace;
                cube.density = density;
            }
        }
    }
}
