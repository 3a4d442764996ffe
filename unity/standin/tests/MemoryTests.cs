// Whether frames that go on for long leave memory behind, of the package's or of what stands in for the engine and its driver.
using System;
using System.Diagnostics;
using NUnit.Framework;
using StandIn;

namespace Lumivox.Tests
{
    public sealed class MemoryTests : CubeScene
    {
        /// Megabytes of this process that are in memory.
        static double Resident()
        {
            GC.Collect();
            using (var process = Process.GetCurrentProcess()) return process.WorkingSet64 / 1048576.0;
        }

        [Test]
        public void ThreeHundredFramesGrowByLittle()
        {
            camera.GetComponent<LumivoxEffect>().targetSamples = 65536;
            camera.GetComponent<LumivoxEffect>().frameBudgetMs = 1f;
            double before = 0;
            for (var i = 0; i <= 360; i++)
            {
                volume.density = 50f + i % 7;
                Engine.Frame();
                Ticker.Tick();
                if (i == 60) before = Resident();
            }
            var grown = Resident() - before;
            Assert.IsTrue(grown < 30, $"{grown:0} MB in 300 frames");
        }
    }
}
