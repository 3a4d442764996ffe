using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Lumivox.SelfChecks;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    /// <summary>The checks and what came of them, one below the other, with the pictures that were drawn.</summary>
    public sealed class SelfCheckWindow : EditorWindow
    {
        const int PictureSize = CheckStage.Side;
        static readonly string[] captions = { "seen here", "expected", "difference" };
        static readonly Color good = new Color(0.36f, 0.7f, 0.4f), bad = new Color(0.9f, 0.35f, 0.3f), plain = new Color(0.6f, 0.6f, 0.6f);

        readonly List<Texture2D> textures = new List<Texture2D>();
        SelfCheckRun run;
        Row[] rows = Array.Empty<Row>();
        Button start, stop, copy, show;
        ProgressBar bar;
        Label verdict;
        ScrollView list;

        /// A check as it is shown.
        sealed class Row
        {
            public Label Word, Details;
            public VisualElement Pictures;
            public Check.State Shown;
        }

        /// <summary>Opens the window; checks nothing by itself.</summary>
        public static SelfCheckWindow Open()
        {
            var window = GetWindow<SelfCheckWindow>(false, "Lumivox Self-Check");
            window.minSize = new Vector2(420, 320);
            return window;
        }

        /// <summary>Runs all checks anew.</summary>
        public void Begin() => Begin(SelfCheckList.All());

        internal void Begin(IReadOnlyList<Check> checks)
        {
            Stop();
            run = new SelfCheckRun(checks);
            List();
            EditorApplication.update += Turn;
        }

        internal SelfCheckRun Run => run;

        /// <summary>Stops what is under way.</summary>
        public void Stop()
        {
            EditorApplication.update -= Turn;
            if (run == null) return;
            run.Dispose();
            Refresh();
        }

        void CreateGUI()
        {
            var root = rootVisualElement;
            root.style.paddingLeft = root.style.paddingRight = root.style.paddingTop = root.style.paddingBottom = 6;
            var head = new VisualElement { name = "head" };
            head.style.flexDirection = FlexDirection.Row;
            head.style.flexShrink = 0;
            head.style.alignItems = Align.Center;
            start = Press(head, "start", "Run", "Runs all checks: it takes a minute or two. Your scene stays as it is.", Begin);
            stop = Press(head, "stop", "Stop", "Stops what is under way; nothing is left behind.", Stop);
            copy = Press(head, "copy", "Copy Report", "Copies the report, for an issue.", () => GUIUtility.systemCopyBuffer = run.Report);
            show = Press(head, "show", "Show Pictures", "Shows the folder with the report and all pictures.", () => EditorUtility.RevealInFinder(SelfCheckRun.ReportFile));
            verdict = new Label { name = "verdict" };
            verdict.style.unityFontStyleAndWeight = FontStyle.Bold;
            verdict.style.flexGrow = 1;
            verdict.style.marginLeft = 8;
            head.Add(verdict);
            root.Add(head);
            bar = new ProgressBar { name = "bar", lowValue = 0, highValue = 1 };
            bar.style.flexShrink = 0;
            root.Add(bar);
            list = new ScrollView { name = "checks" };
            list.style.flexGrow = 1;
            root.Add(list);
            List();
            EditorApplication.playModeStateChanged += OnPlayMode;
        }

        void OnDisable()
        {
            EditorApplication.playModeStateChanged -= OnPlayMode;
            Stop();
            Forget();
        }

        /// Scenes of its own do not outlive that.
        void OnPlayMode(PlayModeStateChange change)
        {
            if (change == PlayModeStateChange.ExitingEditMode || change == PlayModeStateChange.ExitingPlayMode) Stop();
        }

        static Button Press(VisualElement parent, string name, string text, string tooltip, Action action)
        {
            var button = new Button(action) { name = name, text = text, tooltip = tooltip };
            parent.Add(button);
            return button;
        }

        void Turn()
        {
            if (!run.Step()) EditorApplication.update -= Turn;
            Refresh();
        }

        void List()
        {
            if (list == null) return;
            Forget();
            list.Clear();
            rows = run == null ? Array.Empty<Row>() : run.Checks.Select(MakeRow).ToArray();
            Refresh();
        }

        Row MakeRow(Check check)
        {
            var line = new VisualElement { name = check.Name };
            line.style.flexDirection = FlexDirection.Row;
            line.style.flexShrink = 0;
            line.style.marginTop = 4;
            var row = new Row { Word = new Label(), Details = new Label(), Pictures = new VisualElement() };
            row.Word.style.width = 64;
            row.Word.style.flexShrink = 0;
            row.Word.style.unityFontStyleAndWeight = FontStyle.Bold;
            line.Add(row.Word);
            var column = new VisualElement();
            column.style.flexGrow = column.style.flexShrink = 1;
            var title = new Label(check.Name);
            title.style.unityFontStyleAndWeight = FontStyle.Bold;
            column.Add(title);
            row.Details.name = "details";
            row.Details.enableRichText = false;
            row.Details.style.whiteSpace = WhiteSpace.Normal;
            row.Details.style.opacity = 0.8f;
            column.Add(row.Details);
            row.Pictures.style.flexDirection = FlexDirection.Row;
            column.Add(row.Pictures);
            line.Add(column);
            list.Add(line);
            Show(row, check);
            return row;
        }

        void Refresh()
        {
            if (list == null) return;
            var works = run != null && !run.IsOver;
            start.SetEnabled(!works);
            stop.SetEnabled(works);
            copy.SetEnabled(run != null);
            show.SetEnabled(run != null && run.IsOver);
            bar.style.display = works ? DisplayStyle.Flex : DisplayStyle.None;
            verdict.text = run == null ? "Checks whether Lumivox works in this project." : SelfCheckReport.Verdict(run.Checks);
            if (run == null) return;
            bar.value = run.Progress;
            for (var i = 0; i < rows.Length; i++)
                if (rows[i].Shown != run.Checks[i].Now) Show(rows[i], run.Checks[i]);
        }

        void Show(Row row, Check check)
        {
            row.Shown = check.Now;
            row.Word.text = SelfCheckReport.Word(check.Now);
            row.Word.style.color = check.Now == Check.State.Passed ? good : check.Now == Check.State.Failed ? bad : plain;
            var texts = check.Faults.SelectMany(fault => fault.Remedy == "" ? new[] { fault.What } : new[] { fault.What, fault.Remedy }).Concat(check.Notes);
            row.Details.text = string.Join("\n", texts);
            row.Details.style.display = row.Details.text == "" ? DisplayStyle.None : DisplayStyle.Flex;
            row.Pictures.Clear();
            for (var i = 0; i < check.Pictures.Length; i++) row.Pictures.Add(Picture(check.Pictures[i], captions[i]));
        }

        VisualElement Picture(string file, string caption)
        {
            var box = new VisualElement();
            box.style.marginRight = 6;
            box.style.marginTop = 2;
            var texture = CheckPicture.Load(file).ToTexture();
            textures.Add(texture);
            var image = new Image { image = texture, scaleMode = ScaleMode.ScaleToFit, tooltip = Path.GetFileName(file) };
            image.style.width = image.style.height = PictureSize;
            box.Add(image);
            box.Add(new Label(caption));
            return box;
        }

        void Forget()
        {
            foreach (var texture in textures) DestroyImmediate(texture);
            textures.Clear();
        }
    }
}
