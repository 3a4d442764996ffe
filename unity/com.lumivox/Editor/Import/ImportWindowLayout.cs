using System;
using System.IO;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Editor
{
    public sealed partial class ImportWindow
    {
        TextField pathField, rawField, targetField;
        Toggle outsideField, gapsField, damagedField, everythingField, addField;
        SliderInt phaseField;
        ListView list;
        Image thumbnail;
        Label details, stage;
        HelpBox problems;
        ProgressBar bar;
        VisualElement progressRow;
        Button stop, import, browseFolder, browseFile;

        void CreateGUI()
        {
            var root = rootVisualElement;
            root.style.paddingLeft = root.style.paddingRight = root.style.paddingTop = root.style.paddingBottom = 6;

            var source = Row(root, "source");
            pathField = Text(source, "path", "Scan", "A folder of DICOM files, a zip archive, or a NIfTI, NRRD, MetaImage or RAW file. Press Enter to look at it, or drop one on this window.");
            pathField.RegisterValueChangedCallback(_ => { Distrust(); Scan(); });
            browseFolder = Press(source, "browse-folder", "Folder...", "A folder of DICOM files, with those in it.", () => Browse(EditorUtility.OpenFolderPanel("Import a DICOM folder", m_Path, "")));
            browseFile = Press(source, "browse-file", "File...", "An archive, or a file of another format.", () => Browse(EditorUtility.OpenFilePanel("Import a scan", Folder(m_Path), "")));

            rawField = Text(root, "raw", "Holds", "What the file holds, such as 256x256x108:i16le:spacing=1,1,2.");
            rawField.RegisterValueChangedCallback(_ => Scan());
            outsideField = Check(root, "outside", "Allow data outside the scan's folder", "Of a header that you trust: its data may be files that lie neither beside it nor below it.", false);
            outsideField.RegisterValueChangedCallback(_ => Scan());
            rawField.style.display = outsideField.style.display = DisplayStyle.None;

            list = new ListView
            {
                name = "series", fixedItemHeight = 38, selectionType = SelectionType.Single, makeItem = MakeRow, bindItem = BindRow,
                itemsSource = Array.Empty<LumivoxSeries>(), tooltip = "What can be imported; a double-click imports it.",
            };
            list.style.flexGrow = 1;
            list.style.minHeight = 80;
            list.selectionChanged += _ => OnSeriesSelected();
            list.itemsChosen += _ => Import();
            root.Add(list);

            var about = Row(root, "about");
            about.style.height = ThumbnailSize;
            thumbnail = new Image { name = "thumbnail", scaleMode = ScaleMode.ScaleToFit, tooltip = "The middle slice of the series that is chosen." };
            thumbnail.style.width = thumbnail.style.height = ThumbnailSize;
            about.Add(thumbnail);
            var scroll = new ScrollView { name = "report" };
            scroll.style.flexGrow = 1;
            details = new Label { name = "details" };
            details.enableRichText = false;
            details.style.whiteSpace = WhiteSpace.Normal;
            scroll.Add(details);
            about.Add(scroll);

            problems = new HelpBox("", HelpBoxMessageType.Error) { name = "problems" };
            problems.style.display = DisplayStyle.None;
            root.Add(problems);

            var choices = Row(root, "choices");
            gapsField = Check(choices, "gaps", "Leave gaps", "Slices that are missing stay empty; otherwise a scan that lacks some is not imported.", false);
            damagedField = Check(choices, "damaged", "Fill damaged", "Slices that are damaged are filled in from their neighbours; otherwise they stay empty.", false);
            everythingField = Check(choices, "everything", "Keep everything", "Of a CT: the table, clothes and cables are a part of the scan. Otherwise they are put aside, and Keep Everything of a volume shows them.", false);
            phaseField = new SliderInt("Phase", 1, 1) { name = "phase", showInputField = true, tooltip = "Which of the volumes in the series is imported." };
            phaseField.style.flexGrow = 1;
            phaseField.style.display = DisplayStyle.None;
            choices.Add(phaseField);

            var target = Row(root, "target-row");
            targetField = Text(target, "target", "Save as", "A file in the project; it is the scan's asset.");
            addField = Check(target, "add", "Add to scene", "Shows the scan in the scene that is open.", true);
            import = Press(target, "import", "Import", "Imports the series that is chosen.", Import);

            progressRow = Row(root, "progress");
            stage = new Label { name = "stage" };
            stage.style.flexGrow = 1;
            progressRow.Add(stage);
            bar = new ProgressBar { name = "bar" };
            bar.style.flexGrow = 1;
            progressRow.Add(bar);
            stop = Press(progressRow, "stop", "Stop", "Stops what is under way; nothing is saved.", Stop);

            TakeDrops(root);
            pathField.SetValueWithoutNotify(m_Path);
            ShowReceiver();
            Go(Step.Choose);
            if (isAwaited) Take(m_Path, m_Receiver);
        }

        static VisualElement Row(VisualElement parent, string name)
        {
            var row = new VisualElement { name = name };
            row.style.flexDirection = FlexDirection.Row;
            row.style.flexShrink = 0;
            row.style.alignItems = Align.Center;
            parent.Add(row);
            return row;
        }

        static TextField Text(VisualElement parent, string name, string label, string tooltip)
        {
            var field = new TextField(label) { name = name, tooltip = tooltip, isDelayed = true };
            field.labelElement.style.minWidth = 60;
            field.style.flexGrow = 1;
            field.style.flexShrink = 1;
            parent.Add(field);
            return field;
        }

        static Toggle Check(VisualElement parent, string name, string text, string tooltip, bool isOn)
        {
            var field = new Toggle { name = name, text = text, tooltip = tooltip };
            field.SetValueWithoutNotify(isOn);
            parent.Add(field);
            return field;
        }

        static Button Press(VisualElement parent, string name, string text, string tooltip, Action action)
        {
            var button = new Button(action) { name = name, text = text, tooltip = tooltip };
            parent.Add(button);
            return button;
        }

        static VisualElement MakeRow()
        {
            var row = new VisualElement();
            var title = new Label { name = "title" };
            title.enableRichText = false;
            title.style.unityFontStyleAndWeight = FontStyle.Bold;
            var line = new Label { name = "line" };
            line.enableRichText = false;
            line.style.opacity = 0.7f;
            row.Add(title);
            row.Add(line);
            return row;
        }

        void BindRow(VisualElement row, int index)
        {
            var series = report.series[index];
            row.Q<Label>("title").text = ReportText.Title(series);
            row.Q<Label>("line").text = ReportText.Line(series);
            row.tooltip = string.IsNullOrEmpty(series.reason) ? series.uid : $"Another series comes first: this is {series.reason}.";
        }

        void Browse(string path)
        {
            if (!string.IsNullOrEmpty(path)) Take(path, m_Receiver);
        }

        static string Folder(string path) => Directory.Exists(path) ? path : path == "" ? "" : Path.GetDirectoryName(path);

        void ShowReceiver()
        {
            if (addField != null) addField.text = m_Receiver != null ? $"Give to {m_Receiver.name}" : "Add to scene";
        }

        void Go(Step step)
        {
            Now = step;
            foreach (var field in new VisualElement[] { pathField, rawField, outsideField, browseFolder, browseFile, targetField, phaseField, gapsField, damagedField, everythingField, addField, list })
                field.SetEnabled(!Works);
            import.SetEnabled(step == Step.Ready && Selected >= 0);
            bar.style.display = Works ? DisplayStyle.Flex : DisplayStyle.None;
            stop.style.display = step == Step.Scanning || step == Step.Importing ? DisplayStyle.Flex : DisplayStyle.None;
            if (Works) problems.style.display = DisplayStyle.None;
            else bar.title = "";
            if (step == Step.Choose) stage.text = "";
        }

        void ShowDetails()
        {
            var place = Selected;
            details.text = (place >= 0 ? ReportText.Of(report.series[place]) : "") + (report != null ? ReportText.Of(report, place) : "");
        }

        void ShowProblem(string message)
        {
            if (stage.text != "" && !Works) stage.text = "";
            problems.text = message;
            problems.style.display = DisplayStyle.Flex;
        }

        void AddProblem(string message)
        {
            problems.text = problems.style.display == DisplayStyle.Flex ? problems.text + "\n" + message : message;
            problems.style.display = DisplayStyle.Flex;
        }
    }
}
