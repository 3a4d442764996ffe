using System;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>
    /// Edits a <see cref="LumivoxTransferFunction"/>: opacity over the scan's histogram, colours, window, presets. Works in
    /// the editor and in a running game; set <see cref="transferFunction"/> and, for the histogram, <see cref="volume"/>.
    /// </summary>
    /// <remarks>
    /// The function changes while a point is dragged. Undo and redo (Control+Z, Control+Y) are its own unless
    /// <see cref="keepsHistory"/> is off; then <see cref="editStarted"/> and <see cref="editFinished"/> are for those who
    /// keep steps elsewhere, who give one back with <see cref="TransferFunctionAccess.SetState"/>.
    /// </remarks>
#if UNITY_6000_0_OR_NEWER
    [UxmlElement]
#endif
    public partial class TransferFunctionField : VisualElement
    {
#if !UNITY_6000_0_OR_NEWER
        public new class UxmlFactory : UxmlFactory<TransferFunctionField, UxmlTraits> { }
#endif
        const int Bins = 384;
        /// Milliseconds without zooming before the histogram is taken anew.
        const long HistogramDelay = 150;
        const float Emphasis = 2.5f;
        /// Values that are shown where neither scan nor points say which: those of a CT scanner.
        const double CtLow = -1024, CtHigh = 3071;

        /// <summary>Before the first change of an edit, with its name.</summary>
        public event Action<string> editStarted;
        /// <summary>After an edit. Where it was given up, or changed nothing, it is after as it was before.</summary>
        public event Action<TransferFunctionEdit> editFinished;
        /// <summary>A preset was chosen. Where <see cref="appliesPresets"/> is off, to apply it is up to whoever hears of it.</summary>
        public event Action<string> presetChosen;

        readonly TransferFunctionModel model = new TransferFunctionModel();
        readonly ValueAxis axis = new ValueAxis();
        readonly ValueStrip[] strips;
        readonly WindowStrip windowStrip;
        readonly OpacityGraph graph;
        readonly ColorStrip colors;
        readonly PointRow points;
        readonly PresetGallery gallery = new PresetGallery();
        readonly TransferFunctionHistory history = new TransferFunctionHistory();
        readonly VisualElement bar = new VisualElement { name = "toolbar" };
        readonly Label hint = new Label { name = "hint" };
        readonly Label rows = new Label { name = "gradients", tooltip = "Rows of a function of value and gradient, from a file or the numbers of the asset. Edits leave them as they are, and they are saved with it." };
        readonly DoubleField level, width;
        readonly Button presets, undo, redo;
        readonly IVisualElementScheduledItem histogramTimer;
        LumivoxTransferFunction function;
        LumivoxVolumeAsset scan;
        TransferFunctionState before, opened;
        string editName = "";
        bool isWriting, isAttached;

        public TransferFunctionField()
        {
            name = "transfer-function";
            windowStrip = new WindowStrip(axis, model);
            graph = new OpacityGraph(axis, model);
            colors = new ColorStrip(axis, model);
            points = new PointRow(model, graph, colors) { Edit = Do };
            strips = new ValueStrip[] { windowStrip, graph, colors };
            style.flexGrow = 1;

            bar.style.flexDirection = FlexDirection.Row;
            bar.style.flexWrap = Wrap.Wrap;
            bar.style.alignItems = Align.Center;
            presets = Tool("presets", "Presets", "Looks that suit a kind of scan at once.", () => gallery.Toggle(scan));
            gallery.chosen += Choose;
            level = Number("level", "Level", "The middle of the window.");
            width = Number("width", "Width", "From the first to the last point.");
            level.RegisterValueChangedCallback(e => TypeWindow(e, e.newValue, width.value));
            width.RegisterValueChangedCallback(e => TypeWindow(e, level.value, e.newValue));
            bar.Add(level);
            bar.Add(width);
            Tool("emphasise", "Faint", "Shows small opacities larger, or as they are.", () => graph.Emphasis = graph.Emphasis == 1 ? Emphasis : 1);
            Tool("show-all", "All", "Shows all values (A).", axis.ShowAll);
            Tool("show-points", "Points", "Shows the points (F).", ShowPoints);
            Tool("reset", "Reset", "Resets the window, or takes everything back since the editor was opened.", OpenReset);
            undo = Tool("undo", "Undo", "Takes the last edit back (Control+Z).", () => Step(history.Undo()));
            redo = Tool("redo", "Redo", "Does again what was taken back (Control+Y).", () => Step(history.Redo()));
            hint.style.flexGrow = 1;
            hint.style.opacity = 0.7f;
            hint.style.minWidth = 130;
            hint.style.unityTextAlign = TextAnchor.MiddleRight;
            hint.style.overflow = Overflow.Hidden;
            hint.style.textOverflow = TextOverflow.Ellipsis;
            bar.Add(hint);

            Add(bar);
            Add(gallery);
            foreach (var strip in strips)
            {
                strip.EditStarted = Begin;
                strip.Edited = Write;
                strip.EditFinished = Finish;
                strip.EditDropped = GiveBack;
                strip.Hinted = text => hint.text = text;
                Add(strip);
            }
            Add(points);
            rows.style.opacity = 0.7f;
            rows.style.whiteSpace = WhiteSpace.Normal;
            Add(rows);
            graph.SelectionChanged = OnSelection;
            colors.SelectionChanged = OnSelection;
            graph.ShowAllAsked = axis.ShowAll;
            graph.ShowPointsAsked = ShowPoints;
            histogramTimer = schedule.Execute(TakeHistogram);
            histogramTimer.Pause();
            axis.ViewChanged += () => { if (panel != null) histogramTimer.ExecuteLater(HistogramDelay); };
            RegisterCallback<KeyDownEvent>(OnKey);
            RegisterCallback<AttachToPanelEvent>(_ => Attach());
            RegisterCallback<DetachFromPanelEvent>(_ => Detach());
            ShowAll();
        }

        /// <summary>What is edited; null clears the editor.</summary>
        public LumivoxTransferFunction transferFunction
        {
            get => function;
            set
            {
                if (ReferenceEquals(function, value)) return;
                foreach (var strip in strips)
                {
                    strip.LetGo();
                    strip.Drop();
                }
                Listen(false);
                function = value;
                Listen(true);
                history.Clear();
                graph.Selected = colors.Selected = -1;
                ReadFunction();
                opened = function != null ? model.State : null;
                ShowPoints();
            }
        }

        /// <summary>The scan whose histogram is shown; may be null.</summary>
        public LumivoxVolumeAsset volume
        {
            get => scan;
            set
            {
                if (ReferenceEquals(scan, value)) return;
                ListenToScan(false);
                gallery.Fold();
                scan = value;
                ListenToScan(true);
                graph.SetHistogram(Array.Empty<float>(), 0, 1);
                if (scan != null && !scan.isEmpty && scan.state == LumivoxVolumeState.Closed) scan.Open();
                OnScanChanged();
                ShowPoints();
                TakeHistogram();
            }
        }

        /// <summary>Whether a chosen preset's points are taken over here. Off where a preset is to set a volume's medium as well.</summary>
        public bool appliesPresets { get; set; } = true;

        /// <summary>Whether undo and redo are kept here.</summary>
        public bool keepsHistory
        {
            get => undo.style.display != DisplayStyle.None;
            set
            {
                undo.style.display = redo.style.display = value ? DisplayStyle.Flex : DisplayStyle.None;
                history.Clear();
            }
        }

        /// <summary>The row of buttons, for those of whoever shows this.</summary>
        public VisualElement toolbar => bar;

        /// <summary>The points as they are edited.</summary>
        internal TransferFunctionModel Model => model;
        internal ValueAxis Axis => axis;
        internal OpacityGraph Graph => graph;
        internal ColorStrip Colors => colors;
        internal WindowStrip Window => windowStrip;
        internal TransferFunctionHistory History => history;
        internal PresetGallery Gallery => gallery;

        /// <summary>Takes over another function's points as one edit.</summary>
        public void Take(LumivoxTransferFunction source, string name = "Take Transfer Function")
        {
            if (source == null || function == null) return;
            var state = source.GetState();
            Do(name, () => model.State = state);
            ShowPoints();
        }

        /// <summary>Shows the points and a little beside them.</summary>
        public void ShowPoints()
        {
            var (low, high) = model.ShownRange;
            if (model.IsEmpty || low == high)
            {
                axis.ShowAll();
                return;
            }
            var border = (high - low) * 0.08;
            axis.Show(low - border, high + border);
        }

        /// <summary>Reads the function again, after an undo for example that told nobody.</summary>
        public void Refresh()
        {
            if (function == null && !ReferenceEquals(function, null))
            {
                transferFunction = null;
                return;
            }
            OnFunctionChanged();
        }

        Button Tool(string toolName, string text, string toolTooltip, Action action)
        {
            var button = new Button(action) { name = toolName, text = text, tooltip = toolTooltip };
            bar.Add(button);
            return button;
        }

        static DoubleField Number(string fieldName, string title, string fieldTooltip)
        {
            var field = new DoubleField(title) { name = fieldName, tooltip = fieldTooltip, isDelayed = true };
            field.labelElement.style.minWidth = 0;
            field.style.width = 120;
            return field;
        }

        void Begin(string name)
        {
            before = model.State;
            editName = name;
            editStarted?.Invoke(name);
        }

        void Write()
        {
            if (function == null) return;
            isWriting = true;
            try
            {
                function.SetState(model.State);
            }
            finally
            {
                isWriting = false;
            }
            ShowAll();
        }

        void Finish(string series)
        {
            var edit = new TransferFunctionEdit(editName, before, model.State, series);
            if (keepsHistory && !edit.after.Equals(edit.before)) history.Add(edit);
            // Not while a point is dragged: the axis would move under it.
            ShowRange();
            ShowTools();
            editFinished?.Invoke(edit);
        }

        /// An edit that is given up leaves nothing behind.
        void GiveBack()
        {
            model.State = before;
            Write();
            editFinished?.Invoke(new TransferFunctionEdit(editName, before, before, null));
        }

        void Do(string name, Action edit) => Do(name, edit, null);

        void Do(string name, Action edit, string series)
        {
            if (function == null) return;
            Begin(name);
            edit();
            Write();
            Finish(series);
        }

        void Step(TransferFunctionState state)
        {
            if (state == null || function == null) return;
            foreach (var strip in strips) strip.Drop();
            model.State = state;
            Write();
        }

        void TypeWindow(EventBase e, double middle, double extent)
        {
            e.StopPropagation();
            if (!model.IsEmpty && extent > 0) Do("Set Window", () => model.SetWindow(middle, extent), "window");
            ShowWindow();
        }

        void OnFunctionChanged()
        {
            if (isWriting) return;
            var was = model.State;
            ReadFunction();
            if (model.State.Equals(was)) return;
            // Somebody else set the points: an undo, say, or a script.
            foreach (var strip in strips) strip.Drop();
            history.Clear();
            ShowAll();
        }

        void OnScanChanged()
        {
            axis.Unit = scan != null ? scan.unit : "";
            ShowRange();
            ShowTools();
            if (scan != null && scan.state == LumivoxVolumeState.Ready) histogramTimer.ExecuteLater(0);
        }

        void OnSelection()
        {
            points.Refresh();
            ShowTools();
        }

        void OnKey(KeyDownEvent e)
        {
            if (!e.actionKey || !keepsHistory) return;
            if (e.keyCode == KeyCode.Z && !e.shiftKey) Step(history.Undo());
            else if (e.keyCode == KeyCode.Y || e.keyCode == KeyCode.Z) Step(history.Redo());
            else return;
            e.StopPropagation();
        }

        void Attach()
        {
            if (isAttached) return;
            isAttached = true;
            Listen(true);
            ListenToScan(true);
            Refresh();
            OnScanChanged();
            TakeHistogram();
        }

        /// An element that is shown nowhere must not be kept alive by what it listens to.
        void Detach()
        {
            foreach (var strip in strips) strip.LetGo();
            Listen(false);
            ListenToScan(false);
            isAttached = false;
        }

        void Listen(bool listens)
        {
            if (ReferenceEquals(function, null)) return;
            function.changed -= OnFunctionChanged;
            if (listens && isAttached) function.changed += OnFunctionChanged;
        }

        void ListenToScan(bool listens)
        {
            if (ReferenceEquals(scan, null)) return;
            scan.changed -= OnScanChanged;
            if (listens && isAttached) scan.changed += OnScanChanged;
        }

        void ReadFunction()
        {
            model.State = function != null ? function.GetState() : new TransferFunctionState(Array.Empty<OpacityPoint>(), Array.Empty<ColorPoint>());
            graph.HasFunction = function != null;
            ShowRange();
            ShowAll();
        }

        void ShowRange()
        {
            var (low, high) = model.ShownRange;
            if (scan != null && scan.valueRange.y > scan.valueRange.x)
            {
                low = model.IsEmpty ? scan.valueRange.x : Math.Min(low, scan.valueRange.x);
                high = model.IsEmpty ? scan.valueRange.y : Math.Max(high, scan.valueRange.y);
            }
            else if (model.IsEmpty || low == high) (low, high) = model.IsEmpty ? (CtLow, CtHigh) : (Math.Min(low, CtLow), Math.Max(high, CtHigh));
            axis.SetFull(low, high);
        }

        void ShowAll()
        {
            ShowWindow();
            ShowTools();
            points.Refresh();
            graph.ShowInvitation();
            ShowRows();
            foreach (var strip in strips) strip.MarkDirtyRepaint();
        }

        /// What is edited is for where values do not change; the rest is said to be there.
        void ShowRows()
        {
            var count = model.Gradients.Count;
            rows.style.display = count > 0 ? DisplayStyle.Flex : DisplayStyle.None;
            if (count == 0) return;
            var at = new string[count];
            for (var i = 0; i < count; i++) at[i] = model.Gradients[i].perMm.ToString("0.###", System.Globalization.CultureInfo.InvariantCulture);
            rows.text = $"Besides these, {(count == 1 ? "a row" : $"{count} rows")} for gradients of {string.Join(", ", at)} per mm.";
        }

        void ShowWindow()
        {
            var (low, high) = model.ShownRange;
            level.SetValueWithoutNotify(PointRow.Rounded((low + high) / 2));
            width.SetValueWithoutNotify(PointRow.Rounded(high - low));
        }

        void ShowTools()
        {
            var usable = function != null && !model.IsEmpty;
            level.SetEnabled(usable);
            width.SetEnabled(usable);
            presets.SetEnabled(function != null);
            if (function == null) gallery.Fold();
            undo.SetEnabled(history.CanUndo);
            redo.SetEnabled(history.CanRedo);
        }

        void TakeHistogram()
        {
            // What is closed again keeps what it showed.
            if (scan == null || scan.state != LumivoxVolumeState.Ready) return;
            var (low, high) = axis.View;
            graph.SetHistogram(Smooth(scan.GetHistogram(Bins, new Vector2((float)low, (float)high))), low, high);
        }

        /// Scans store whole numbers: bins hold two of them here and three there, which would look like a comb.
        internal static float[] Smooth(float[] counts)
        {
            var smooth = (float[])counts.Clone();
            for (var i = 1; i + 1 < counts.Length; i++) smooth[i] = (counts[i - 1] + 2 * counts[i] + counts[i + 1]) / 4;
            return smooth;
        }

        void Choose(string preset)
        {
            presetChosen?.Invoke(preset);
            if (!appliesPresets || function == null) return;
            var made = LumivoxTransferFunction.Preset(preset, scan);
            Take(made, "Apply Preset");
            PresetSwatch.Destroy(made);
        }

        void OpenReset()
        {
            var menu = new GenericDropdownMenu();
            if (model.Shift != 0 || model.WindowScale != 1) menu.AddItem("Reset window", false, () => Do("Reset Window", model.ResetWindow));
            else menu.AddDisabledItem("Reset window", false);
            if (opened != null && !opened.Equals(model.State)) menu.AddItem("As it was when it was opened", false, () => Do("Reset Transfer Function", () => model.State = opened));
            else menu.AddDisabledItem("As it was when it was opened", false);
            var reset = bar.Q<Button>("reset");
            DropdownMenus.Open(menu, reset.worldBound, reset);
        }
    }
}
