// Whether Lumivox works in this project, on this machine, in this pipeline: one click, and one report for an issue.
using UnityEditor;
using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>
    /// The self-check: Window > Lumivox > Self-Check, or, where nobody clicks,
    /// `Unity -batchmode -projectPath PROJECT -executeMethod Lumivox.Editor.SelfCheck.RunFromCommandLine -logFile -`, without
    /// `-quit` and without `-nographics`. The report goes to the log and to `Library/Lumivox/SelfCheck`, and Unity ends with 0
    /// where all is well, 1 otherwise.
    /// </summary>
    public static class SelfCheck
    {
        [MenuItem("Window/Lumivox/Self-Check", false, 2401)]
        static void Open() => SelfCheckWindow.Open().Begin();

        /// <summary>Runs all checks in turns of the editor, prints the report and ends the editor.</summary>
        public static void RunFromCommandLine()
        {
            var run = new SelfCheckRun(SelfCheckList.All());
            void Turn()
            {
                if (run.Step()) return;
                EditorApplication.update -= Turn;
                var hasFailed = true;
                try
                {
                    run.Dispose();
                    Debug.Log(run.Report);
                    hasFailed = run.HasFailed;
                }
                finally
                {
                    // Whatever happens: nobody would end the editor otherwise.
                    EditorApplication.Exit(hasFailed ? 1 : 0);
                }
            }
            EditorApplication.update += Turn;
        }
    }
}
