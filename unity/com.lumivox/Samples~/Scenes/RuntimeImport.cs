using System;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox.Samples
{
    /// <summary>A running game that imports scans and edits their transfer function: type a path, and press Import.</summary>
    [AddComponentMenu("Lumivox/Samples/Runtime Import"), RequireComponent(typeof(UIDocument))]
    public sealed class RuntimeImport : SampleScene
    {
        LumivoxVolume volume;
        LumivoxTransferFunction function;
        LumivoxVolumeAsset imported;
        TransferFunctionField editor;
        TextField path;
        Label status;
        Button import, stop;
        CancellationTokenSource cancel;

        protected override (Vector3 pivot, float distance) Framing => (Vector3.zero, 0.7f);

        protected override void Build()
        {
            volume = Volume("Scan", Vector3.zero, "ct-muscle");
            function = volume.transferFunction;
            var root = GetComponent<UIDocument>().rootVisualElement;
            var panel = new VisualElement();
            panel.style.position = Position.Absolute;
            panel.style.left = panel.style.right = panel.style.bottom = 12;
            panel.style.height = 320;
            panel.style.paddingLeft = panel.style.paddingRight = panel.style.paddingTop = panel.style.paddingBottom = 8;
            panel.style.backgroundColor = new Color(0.1f, 0.11f, 0.13f, 0.92f);
            panel.style.color = new Color(0.9f, 0.9f, 0.92f);
            root.Add(panel);

            var row = new VisualElement();
            row.style.flexDirection = FlexDirection.Row;
            path = new TextField("Scan") { tooltip = "A folder of DICOM files, an archive, or a file of another format." };
            path.style.flexGrow = 1;
            import = new Button(() => Import()) { text = "Import" };
            stop = new Button(() => cancel?.Cancel()) { text = "Stop" };
            stop.SetEnabled(false);
            row.Add(path);
            row.Add(import);
            row.Add(stop);
            panel.Add(row);
            status = new Label("Type the path of a scan.");
            panel.Add(status);

            // A preset sets the volume's medium, too.
            editor = new TransferFunctionField { volume = scan, transferFunction = function, appliesPresets = false };
            editor.presetChosen += preset =>
            {
                volume.ApplyPreset(preset);
                Adopt(volume.transferFunction);
            };
            panel.Add(editor);
        }

        void OnDestroy()
        {
            cancel?.Cancel();
            if (imported != null) Destroy(imported);
            if (function != null) Destroy(function);
        }

        async void Import()
        {
            cancel = new CancellationTokenSource();
            import.SetEnabled(false);
            stop.SetEnabled(true);
            try
            {
                using (var importer = new LumivoxImporter())
                {
                    importer.progressed += progress => status.text = $"{progress.stage} {progress.done}/{progress.total}";
                    var made = await importer.Load(new[] { path.value.Trim() }, null, cancel.Token);
                    if (this == null) return;
                    Show(made);
                }
            }
            catch (OperationCanceledException)
            {
                if (this != null) status.text = "Stopped.";
            }
            catch (LumivoxException error)
            {
                if (this != null) status.text = error.Message;
            }
            finally
            {
                if (this != null)
                {
                    import.SetEnabled(true);
                    stop.SetEnabled(false);
                }
            }
        }

        void Show(LumivoxVolumeAsset made)
        {
            var before = imported;
            imported = made;
            volume.volume = made;
            volume.ApplyPreset(LumivoxTransferFunction.PresetFor(made));
            editor.volume = made;
            Adopt(volume.transferFunction);
            View.Move(0.001f, 0, 1);
            if (before != null) Destroy(before);
            var (dims, notes) = (made.dimensions, made.GetReport().notes);
            status.text = $"{dims.x} x {dims.y} x {dims.z} voxels. {string.Join(" ", notes)}";
        }

        /// What a preset made before is nobody's any more.
        void Adopt(LumivoxTransferFunction other)
        {
            var before = function;
            editor.transferFunction = function = other;
            if (before != null && before != other) Destroy(before);
        }
    }
}
