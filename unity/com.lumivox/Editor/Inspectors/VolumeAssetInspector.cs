using System;
using System.Linq;
using Lumivox.Native;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;
using Object = UnityEngine.Object;

namespace Lumivox.Editor
{
    /// <summary>What a scan is, how it was imported, and how often its values occur.</summary>
    [CustomEditor(typeof(LumivoxVolumeAsset)), CanEditMultipleObjects]
    sealed class VolumeAssetInspector : UnityEditor.Editor
    {
        /// Voxels along a side of a phantom that is only pictured.
        const int PreviewSize = 96;

        Label facts, state;
        HistogramView histogram;
        LumivoxVolumeAsset listened;

        LumivoxVolumeAsset Scan => (LumivoxVolumeAsset)target;

        public override VisualElement CreateInspectorGUI()
        {
            var root = new VisualElement();
            if (targets.Length > 1)
            {
                root.Add(new Label($"{targets.Length} scans") { name = "facts" });
                return root;
            }
            facts = Text(root, "facts");
            state = Text(root, "state");
            state.style.opacity = 0.7f;
            histogram = new HistogramView { name = "histogram" };
            root.Add(histogram);
            var row = new VisualElement();
            row.style.flexDirection = FlexDirection.Row;
            row.Add(new Button(Open) { name = "open", text = "Count Values", tooltip = "Reads the scan, to show how often its values occur." });
            row.Add(new Button(() => Selection.activeGameObject = VolumeActions.Create(Scan, null).gameObject) { name = "add", text = "Add to Scene", tooltip = "Makes an object that shows the scan." });
            root.Add(row);
            root.RegisterCallback<AttachToPanelEvent>(_ => Listen(Scan));
            root.RegisterCallback<DetachFromPanelEvent>(_ => Listen(null));
            Show();
            return root;
        }

        static Label Text(VisualElement parent, string name)
        {
            var label = new Label { name = name };
            label.enableRichText = false;
            label.style.whiteSpace = WhiteSpace.Normal;
            parent.Add(label);
            return label;
        }

        /// What the project window shows of a phantom, which nothing has imported. It is computed, so a small one does.
        public override Texture2D RenderStaticPreview(string assetPath, Object[] subAssets, int width, int height)
        {
            var small = Border.Fault == null ? Scan.SmallPhantom(PreviewSize) : null;
            if (small == null) return null;
            string problem = null;
            try
            {
                // Why it cannot be opened is said by itself.
                return EditorWork.Wait(small.Open()) ? ScanPictures.Of(small, out problem, Mathf.Min(width, height)) : null;
            }
            catch (Exception error) when (EditorWork.IsOutside(error))
            {
                problem = error.Message;
                return null;
            }
            finally
            {
                if (problem != null) Debug.LogWarning($"{Scan.name} has no picture: {problem}", Scan);
                DestroyImmediate(small);
            }
        }

        void Open()
        {
            try
            {
                if (Scan.state == LumivoxVolumeState.Closed || Scan.state == LumivoxVolumeState.Failed) Scan.Open();
                Show();
            }
            catch (Exception error) when (EditorWork.IsOutside(error))
            {
                state.text = error.Message;
            }
        }

        void Listen(LumivoxVolumeAsset scan)
        {
            if (!ReferenceEquals(listened, null)) listened.changed -= Show;
            listened = scan;
            if (scan != null) scan.changed += Show;
        }

        void Show()
        {
            if (target == null) return;
            var scan = Scan;
            var lines = new[] { scan.isEmpty ? "There is no scan in it." : scan.dimensions == Vector3Int.zero ? "A scan that is computed when something shows it." : ReportText.Of(scan) }.ToList();
            var report = scan.GetReport();
            if (report.chosenSeries != null)
            {
                lines.Insert(0, ReportText.Title(report.chosenSeries));
                lines.Add(string.Join(", ", new[] { report.format, scan.modality, report.chosenSeries.orientation }.Where(text => !string.IsNullOrEmpty(text))));
            }
            lines.AddRange(scan.labels.Select(label => $"{label.value}  {label.name}  {ReportText.Number((float)label.milliliters)} ml"));
            lines.AddRange(report.notes.Select(note => "\u2022 " + note));
            facts.text = string.Join("\n", lines);
            state.text = scan.state == LumivoxVolumeState.Failed ? scan.error : scan.state == LumivoxVolumeState.Loading ? "It is being read." : "";
            if (scan.state != LumivoxVolumeState.Ready) return;
            try
            {
                histogram.Show(scan);
            }
            catch (Exception error) when (EditorWork.IsOutside(error))
            {
                state.text = error.Message;
            }
        }
    }

    /// <summary>How often values occur, on a log scale: air outnumbers everything else by far.</summary>
    sealed class HistogramView : VisualElement
    {
        const int Bins = 192;
        float[] counts = new float[0];

        public HistogramView()
        {
            style.height = 80;
            style.marginTop = style.marginBottom = 4;
            generateVisualContent += Draw;
            style.display = DisplayStyle.None;
        }

        internal int Count => counts.Length;

        public void Show(LumivoxVolumeAsset scan)
        {
            counts = scan.GetHistogram(Bins, scan.valueRange);
            tooltip = $"How often values occur, from {ReportText.Number(scan.valueRange.x)} to {ReportText.Number(scan.valueRange.y)} {scan.unit}, on a logarithmic scale.";
            style.display = DisplayStyle.Flex;
            MarkDirtyRepaint();
        }

        void Draw(MeshGenerationContext context)
        {
            if (counts.Length == 0 || contentRect.width < 1) return;
            var highest = Mathf.Max(1, counts.Max());
            var painter = context.painter2D;
            var ink = resolvedStyle.color;
            painter.fillColor = new Color(ink.r, ink.g, ink.b, 0.35f);
            painter.BeginPath();
            painter.MoveTo(new Vector2(0, contentRect.height));
            for (var i = 0; i < counts.Length; i++)
            {
                var height = Mathf.Log(1 + counts[i]) / Mathf.Log(1 + highest) * contentRect.height;
                painter.LineTo(new Vector2(contentRect.width * i / (counts.Length - 1), contentRect.height - height));
            }
            painter.LineTo(new Vector2(contentRect.width, contentRect.height));
            painter.ClosePath();
            painter.Fill();
        }
    }
}
