// The scenes of the self-check: those of the samples, small enough for any GPU, in light that all pipelines agree on.
using System;
using System.Collections;
using System.Diagnostics;
using UnityEngine;

namespace Lumivox.SelfChecks
{
    internal sealed class CheckScene
    {
        /// <summary>Samples of a pixel: noise is far below the limits then, see <see cref="CheckPicture"/>.</summary>
        public const int Samples = 32;

        /// <summary>Seconds after which a picture is not waited for any longer, and a pipeline that has not called Lumivox by then.</summary>
        const double Patience = 150, PatienceToBeCalled = 60;

        const int HeadSize = 80;

        /// <summary>Of its pictures' files, and what it shows.</summary>
        public readonly string Name, About;
        readonly Action<CheckStage> build;

        CheckScene(string name, string about, Action<CheckStage> build) => (Name, About, this.build) = (name, about, build);

        public override string ToString() => Name;

        public static readonly CheckScene[] All =
        {
            new CheckScene("cube-at-distances", "a cube at its size, twice and four times as large, as much farther away: all look alike", CubeAtDistances),
            new CheckScene("occlusion", "meshes before, in and behind a translucent head", Occlusion),
            new CheckScene("several-volumes", "five scans of one head that overlap, in four looks", SeveralVolumes),
            new CheckScene("lights", "a skull in the light of two suns, from the left and from above", Lights),
        };

        /// <summary>Draws the scene until it is at rest, a little in each step; then hands over what is seen.</summary>
        public IEnumerator Draw(bool isApart, int samples, Action<CheckPicture> seen)
        {
            using (var stage = new CheckStage(isApart, samples))
            {
                build(stage);
                var watch = Stopwatch.StartNew();
                while (!stage.Draw())
                {
                    var status = stage.Status;
                    if (watch.Elapsed.TotalSeconds > Patience) throw new LumivoxException($"the picture is not at rest after {Patience} seconds: {status.samples} of {status.target} samples");
                    if (!status.isShown && watch.Elapsed.TotalSeconds > PatienceToBeCalled)
                    {
                        var why = string.IsNullOrEmpty(LumivoxRenderer.LastError) ? "the pipeline does not call Lumivox for the camera" : LumivoxRenderer.LastError;
                        throw new LumivoxException($"no volume was drawn within {PatienceToBeCalled} seconds: {why}");
                    }
                    yield return null;
                }
                seen(stage.Read());
            }
        }

        static void CubeAtDistances(CheckStage stage)
        {
            var scan = stage.Phantom("cube", 48);
            for (var i = 0; i < 3; i++)
            {
                float scale = 1 << i, angle = (i - 1) * 12f;
                var cube = stage.Volume(scan, "ct-muscle");
                cube.transform.position = Quaternion.Euler(0f, angle, 0f) * Vector3.forward * (0.34f * scale);
                cube.transform.rotation = Quaternion.Euler(20f, angle + 30f, 0f);
                cube.transform.localScale = Vector3.one * scale;
                cube.density = 0.1f;
            }
        }

        static void Occlusion(CheckStage stage)
        {
            stage.Camera.transform.position = new Vector3(0f, 0.01f, -0.66f);
            var head = stage.Volume(stage.Phantom("head", HeadSize), "ct-muscle");
            head.density = 0.06f;
            head.surfaceStrength = 0.25f;
            // Each overlaps the head as the camera sees it, so that one tells which of the two hides the other.
            stage.Shape(CheckStage.Sphere, new Vector3(-0.03f, -0.05f, -0.17f), Vector3.one * 0.07f, new Color(0.9f, 0.35f, 0.2f));
            stage.Shape(CheckStage.Sphere, new Vector3(0.05f, 0.01f, 0.21f), Vector3.one * 0.14f, new Color(0.25f, 0.5f, 0.9f));
            stage.Shape(CheckStage.Sphere, new Vector3(0f, 0.085f, 0.01f), Vector3.one * 0.07f, new Color(0.3f, 0.75f, 0.35f));
            stage.Shape(CheckStage.Cube, new Vector3(0f, -0.15f, 0f), new Vector3(0.5f, 0.02f, 0.5f), new Color(0.93f, 0.91f, 0.86f));
        }

        static void SeveralVolumes(CheckStage stage)
        {
            var scan = stage.Phantom("head", HeadSize);
            stage.Camera.transform.position = new Vector3(0f, 0.02f, -0.95f);
            void Add(string preset, Vector3 at, Vector3 turn, float scale)
            {
                var volume = stage.Volume(scan, preset);
                volume.transform.SetPositionAndRotation(at, Quaternion.Euler(turn));
                volume.transform.localScale = Vector3.one * scale;
            }
            Add("ct-skin", new Vector3(-0.16f, 0.06f, 0f), new Vector3(0f, 35f, 0f), 0.9f);
            Add("ct-bone", new Vector3(0.15f, 0.08f, 0.05f), new Vector3(5f, -25f, -10f), 0.9f);
            Add("ct-muscle", new Vector3(0f, -0.08f, -0.08f), new Vector3(-10f, 10f, 0f), 0.7f);
            Add("ct-angiography", new Vector3(-0.19f, -0.18f, -0.02f), new Vector3(0f, -40f, 20f), 0.6f);
            Add("ct-skin", new Vector3(0.19f, -0.16f, 0f), new Vector3(15f, -150f, 0f), 0.6f);
        }

        static void Lights(CheckStage stage)
        {
            stage.Camera.transform.position = new Vector3(0f, 0.01f, -0.56f);
            stage.Volume(stage.Phantom("head", HeadSize), "ct-bone");
            stage.Sun(Quaternion.Euler(10f, 70f, 0f), new Color(1f, 0.75f, 0.5f));
            stage.Sun(Quaternion.Euler(70f, -60f, 0f), new Color(0.45f, 0.6f, 1f));
        }
    }
}
