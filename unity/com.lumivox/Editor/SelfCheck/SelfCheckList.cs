using System;
using System.Collections;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Lumivox.Native;
using Lumivox.SelfChecks;

namespace Lumivox.Editor
{
    /// <summary>All that is checked, what others need first.</summary>
    internal static class SelfCheckList
    {
        public static List<Check> All()
        {
            var checks = new List<Check>
            {
                new Check("Native library", MachineChecks.Library),
                new Check("Graphics device", MachineChecks.Device),
                new Check("Project settings", MachineChecks.Project),
                new Check("Kernels", MachineChecks.Kernels),
                new Check("Phantom", ImportChecks.Phantom),
                new Check("Import", ImportChecks.Import),
                new Check("Import as an asset", ImportChecks.Asset),
            };
            checks.AddRange(CheckScene.All.Select(scene => new Check($"Picture: {scene.Name}", check => Picture(check, scene))));
            return checks;
        }

        static IEnumerator Picture(Check check, CheckScene scene)
        {
            check.Note(scene.About);
            if (LumivoxRuntime.DeviceFault() is string fault)
            {
                check.Fail(fault, "See 'Graphics device'.");
                yield break;
            }
            if (Border.Fault != null)
            {
                check.Fail("nothing is drawn without the native library", "See 'Native library'.");
                yield break;
            }
            if (UnityEngine.Application.isPlaying)
            {
                check.Fail("pictures are drawn in edit mode only: what plays would be seen in them", "Leave play mode and run it again.");
                yield break;
            }
            CheckPicture seen = null;
            var drawing = scene.Draw(true, CheckScene.Samples, picture => seen = picture);
            try
            {
                while (drawing.MoveNext()) yield return null;
            }
            finally
            {
                (drawing as IDisposable)?.Dispose();
            }
            string FileOf(string suffix) => Path.Combine(SelfCheckRun.Folder, scene.Name + suffix + ".png");
            seen.Save(FileOf(""));
            check.Pictures = new[] { FileOf("") };
            var expected = CheckPicture.Expected(scene.Name);
            var (mean, most) = seen.DifferenceFrom(expected);
            expected.Save(FileOf("-expected"));
            seen.Difference(expected).Save(FileOf("-difference"));
            check.Pictures = new[] { FileOf(""), FileOf("-expected"), FileOf("-difference") };
            var differs = Told(mean, most);
            if (mean > CheckPicture.LargestMean || most > CheckPicture.LargestOfSquare)
                check.Fail($"the picture is not what it should be: it {differs}", $"Look at {scene.Name}.png beside {scene.Name}-expected.png, and attach both to an issue with this report.");
            else check.Note(differs);
        }

        static string Told(float mean, float most) =>
            FormattableString.Invariant($"differs by {mean:0.0000} on average (at most {CheckPicture.LargestMean}), in one square by {most:0.000} (at most {CheckPicture.LargestOfSquare})");
    }
}
