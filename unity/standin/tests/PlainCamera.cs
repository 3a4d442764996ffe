// What most tests of pictures look with: one camera before the origin, black behind, a few samples.
using StandIn;
using UnityEngine;

namespace Lumivox.Tests
{
    static class PlainCamera
    {
        internal static Camera Make(int side, int samples = 8)
        {
            Engine.SetScreen(side, side);
            var camera = new GameObject("Camera").AddComponent<Camera>();
            camera.transform.position = new Vector3(0f, 0f, -0.3f);
            camera.nearClipPlane = 0.01f;
            camera.farClipPlane = 10f;
            camera.fieldOfView = 40f;
            camera.allowHDR = true;
            camera.clearFlags = CameraClearFlags.SolidColor;
            camera.backgroundColor = Color.black;
            var effect = camera.gameObject.AddComponent<LumivoxEffect>();
            effect.targetSamples = samples;
            effect.frameBudgetMs = 1000f;
            effect.environmentSource = LumivoxEnvironmentSource.Studio;
            return camera;
        }
    }
}
