using System;
using System.Collections;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using UnityEditor;
using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>A run of checks, one after the other, that goes on a little in each step. What ends early leaves nothing behind.</summary>
    internal sealed class SelfCheckRun : IDisposable
    {
        readonly Stopwatch watch = new Stopwatch();
        IEnumerator steps;
        int current;

        public readonly IReadOnlyList<Check> Checks;

        public SelfCheckRun(IReadOnlyList<Check> checks)
        {
            Checks = checks;
            Directory.CreateDirectory(Folder);
        }

        /// <summary>Where reports and pictures are kept, beside the project's assets.</summary>
        public static string Folder => StoredScans.ProjectFile(ProjectFolder);

        /// <summary>The same, from the project's folder on.</summary>
        public const string ProjectFolder = "Library/Lumivox/SelfCheck";

        public static string ReportFile => Path.Combine(Folder, "report.txt");

        public bool IsOver => current >= Checks.Count;

        public bool HasFailed
        {
            get
            {
                foreach (var check in Checks)
                    if (check.Now != Check.State.Passed) return true;
                return false;
            }
        }

        public float Progress => (float)current / Checks.Count;

        /// <summary>What is known now, for an issue.</summary>
        public string Report => SelfCheckReport.Of(Checks);

        /// <summary>Goes on to where the check wants the editor to have its turn. Returns whether there is more to do.</summary>
        public bool Step()
        {
            if (!IsOver) Advance();
            // An editor at rest takes no turns.
            if (!IsOver && !Application.isPlaying) EditorApplication.QueuePlayerLoopUpdate();
            return !IsOver;
        }

        /// <summary>Stops what is under way; checks that did not end have not passed.</summary>
        public void Dispose()
        {
            if (IsOver) return;
            End(Checks[current]);
            current = Checks.Count;
            Release();
        }

        /// What was on the GPU for the checks alone would stay for some seconds.
        static void Release()
        {
            if (LumivoxVolume.All.Count == 0) LumivoxRuntime.Stop();
        }

        /// <summary>One step of the check that is under way, or the first of the next.</summary>
        internal void Advance()
        {
            var check = Checks[current];
            void Hear(string message, string stack, LogType type)
            {
                if (type == LogType.Log || type == LogType.Warning) return;
                var line = message.Split('\n')[0];
                // Others may have errors of their own meanwhile.
                if (line.Contains("Lumivox")) check.Fail($"Unity's console says: {line}");
                else check.Note($"meanwhile, in Unity's console: {line}");
            }
            Application.logMessageReceived += Hear;
            watch.Restart();
            var goesOn = false;
            try
            {
                if (steps == null)
                {
                    check.Now = Check.State.Running;
                    steps = check.Begin();
                }
                goesOn = steps.MoveNext();
            }
            catch (Exception error) when (EditorWork.IsOutside(error))
            {
                check.Fail(error.Message);
            }
            catch (Exception error)
            {
                // Other checks may tell why.
                check.Fail($"a fault in Lumivox: {error}");
            }
            finally
            {
                Application.logMessageReceived -= Hear;
                check.Seconds += watch.Elapsed.TotalSeconds;
            }
            if (goesOn) return;
            End(check);
            check.Now = check.Faults.Count == 0 ? Check.State.Passed : Check.State.Failed;
            current++;
            if (!IsOver) return;
            // A single one is a test's: the report of all stays.
            if (Checks.Count > 1) File.WriteAllText(ReportFile, Report);
            Release();
        }

        void End(Check check)
        {
            (steps as IDisposable)?.Dispose();
            steps = null;
            if (check.Now == Check.State.Running) check.Now = Check.State.Waiting;
        }
    }
}
