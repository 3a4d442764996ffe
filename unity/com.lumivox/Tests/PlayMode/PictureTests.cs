// The scenes of the self-check in play mode, beside the expected pictures: what plays looks like what is edited.
using System.Collections;
using System.Linq;
using Lumivox.SelfChecks;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.TestTools;

namespace Lumivox.PlayMode.Tests
{
    /// Players do not have the expected pictures.
    [UnityPlatform(RuntimePlatform.WindowsEditor, RuntimePlatform.OSXEditor, RuntimePlatform.LinuxEditor)]
    public sealed class PictureTests
    {
        static IEnumerator LooksAsExpected(string name)
        {
            var scene = CheckScene.All.Single(one => one.Name == name);
            CheckPicture seen = null;
            var drawing = scene.Draw(false, CheckScene.Samples, picture => seen = picture);
            while (drawing.MoveNext()) yield return null;
            var (mean, most) = seen.DifferenceFrom(CheckPicture.Expected(name));
            Assert.LessOrEqual(mean, CheckPicture.LargestMean, "of all squares on average");
            Assert.LessOrEqual(most, CheckPicture.LargestOfSquare, "of one square");
        }

        [UnityTest]
        public IEnumerator Occlusion() => LooksAsExpected("occlusion");

        [UnityTest, Category("Slow")]
        public IEnumerator Lights() => LooksAsExpected("lights");
    }
}
