using System;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>
    /// The preset that volumes have, as a field of an inspector: its colours and name. A click unfolds
    /// <see cref="gallery"/>, which whoever shows this puts where there is room.
    /// </summary>
    public sealed class PresetField : BaseField<string>
    {
        /// <summary>What the field says where volumes have different presets.</summary>
        const string Several = "Several";

        readonly Button button;
        readonly PresetSwatch swatch = new PresetSwatch();
        readonly Label title = new Label { name = "title", pickingMode = PickingMode.Ignore };
        readonly Func<LumivoxVolumeAsset> scan;
        (string preset, LumivoxVolumeAsset scan, bool isAvailable) shown;

        /// <summary>A field for volumes of which one shows what `scan` gives, which may be null.</summary>
        public PresetField(string label, Func<LumivoxVolumeAsset> scan) : this(label, scan, new Button { name = "open" }) { }

        PresetField(string label, Func<LumivoxVolumeAsset> scan, Button input) : base(label, input)
        {
            name = "preset";
            this.scan = scan;
            button = input;
            button.clicked += () => gallery.Toggle(scan(), value ?? "");
            button.style.flexDirection = FlexDirection.Row;
            button.style.flexGrow = 1;
            button.style.alignItems = Align.Center;
            swatch.style.width = 48;
            swatch.style.height = 12;
            title.enableRichText = false;
            title.style.flexGrow = 1;
            button.Add(swatch);
            button.Add(title);
            gallery.offersNone = true;
            gallery.chosen += preset => value = preset;
            AddToClassList(alignedFieldUssClassName);
            SetValueWithoutNotify("");
        }

        /// <summary>What a click unfolds.</summary>
        public PresetGallery gallery { get; } = new PresetGallery();

        /// <summary>What the field says.</summary>
        internal string Text => title.text;

        public override void SetValueWithoutNotify(string newValue)
        {
            base.SetValueWithoutNotify(newValue ?? "");
            Show(value == "" ? "None" : TransferFunctionAccess.TitleOfPreset(value));
        }

        /// <summary>Says that volumes have different presets; to choose one gives it to all.</summary>
        public void ShowSeveral()
        {
            // Neither any preset nor none: to choose either is a change.
            base.SetValueWithoutNotify(null);
            Show(Several);
        }

        void Show(string text)
        {
            title.text = text;
            var seen = scan();
            var isAvailable = !string.IsNullOrEmpty(value) && TransferFunctionAccess.IsPresetAvailable(value, seen);
            // Inspectors ask twice a second.
            if (shown == (value, seen, isAvailable)) return;
            shown = (value, seen, isAvailable);
            swatch.Show(null);
            if (!isAvailable) return;
            try
            {
                swatch.Show(value, seen);
            }
            catch (LumivoxException)
            {
                // A preset that is not known any more still has its name.
            }
        }
    }
}
