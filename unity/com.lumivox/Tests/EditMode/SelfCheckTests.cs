// Each check of the self-check, as a test of Unity's Test Framework.
using System.Collections;
using System.Linq;
using Lumivox.Editor;
using NUnit.Framework;
using UnityEngine.TestTools;

namespace Lumivox.EditMode.Tests
{
    public sealed class SelfCheckTests
    {
        static IEnumerator Passes(string name)
        {
            var check = SelfCheckList.All().Single(one => one.Name == name);
            using (var run = new SelfCheckRun(new[] { check }))
                while (run.Step()) yield return null;
            Assert.AreEqual(Check.State.Passed, check.Now, SelfCheckReport.Of(new[] { check }));
        }

        [UnityTest]
        public IEnumerator Library() => Passes("Native library");

        [UnityTest]
        public IEnumerator Device() => Passes("Graphics device");

        [UnityTest]
        public IEnumerator Project() => Passes("Project settings");

        [UnityTest]
        public IEnumerator Kernels() => Passes("Kernels");

        [UnityTest]
        public IEnumerator Phantom() => Passes("Phantom");

        [UnityTest]
        public IEnumerator Import() => Passes("Import");

        [UnityTest]
        public IEnumerator ImportAsAnAsset() => Passes("Import as an asset");

        // Slow: the self-check from the command line has the same pictures.
        [UnityTest, Category("Slow")]
        public IEnumerator CubeAtDistances() => Passes("Picture: cube-at-distances");

        [UnityTest, Category("Slow")]
        public IEnumerator Occlusion() => Passes("Picture: occlusion");

        [UnityTest, Category("Slow")]
        public IEnumerator SeveralVolumes() => Passes("Picture: several-volumes");

        [UnityTest, Category("Slow")]
        public IEnumerator Lights() => Passes("Picture: lights");

        [Test]
        public void EveryCheckIsATest()
        {
            var tests = GetType().GetMethods().Count(method => method.IsDefined(typeof(UnityTestAttribute), false));
            Assert.AreEqual(SelfCheckList.All().Count, tests);
        }
    }
}
