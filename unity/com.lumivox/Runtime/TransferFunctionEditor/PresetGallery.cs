using System;
using System.Collections.Generic;
using System.Threading.Tasks;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>
    /// The presets as pictures of the scan at hand, and as their colours until those are there. Folded until somebody asks
    /// for it; to choose one folds it again.
    /// </summary>
    public sealed class PresetGallery : VisualElement
    {
        const int Side = 72;

        /// <summary>A preset was chosen.</summary>
        public event Action<string> chosen;

        sealed class Tile : Button
        {
            public readonly string Preset;
            public readonly bool IsAvailable;
            readonly Image image;
            Texture2D picture;

            public Tile(string preset, bool isAvailable, bool isChosen, LumivoxVolumeAsset scan, Action action) : base(action)
            {
                (Preset, IsAvailable) = (preset, isAvailable);
                name = preset;
                style.width = Side + 38;
                style.flexDirection = FlexDirection.Column;
                style.alignItems = Align.Center;
                style.paddingTop = 4;
                var swatch = new PresetSwatch();
                swatch.style.width = swatch.style.height = Side;
                image = new Image { name = "picture", scaleMode = ScaleMode.ScaleToFit, pickingMode = PickingMode.Ignore };
                image.StretchToParentSize();
                swatch.Add(image);
                Add(swatch);
                var title = new Label(TransferFunctionAccess.TitleOfPreset(preset)) { name = "title", pickingMode = PickingMode.Ignore };
                title.enableRichText = false;
                title.style.height = 18;
                title.style.whiteSpace = WhiteSpace.NoWrap;
                if (isChosen) title.style.unityFontStyleAndWeight = FontStyle.Bold;
                Add(title);
                var about = LumivoxTransferFunction.PresetDescription(preset);
                tooltip = isAvailable ? about : about + "\nIt places itself by a scan's values: give the volume a scan first.";
                SetEnabled(isAvailable);
                if (isAvailable) swatch.Show(preset, scan);
            }

            /// The colours are behind what is transparent no longer.
            public void Show(Texture2D made)
            {
                picture = made;
                image.image = made;
                ((PresetSwatch)image.parent).Show(null);
            }

            public void Forget()
            {
                image.image = null;
                PresetSwatch.Destroy(picture);
                picture = null;
            }
        }

        readonly List<Tile> tiles = new List<Tile>();
        LumivoxVolumeAsset scan;
        string current = "";
        /// Which pictures are waited for.
        int asked;

        public PresetGallery()
        {
            name = "preset-gallery";
            style.flexDirection = FlexDirection.Row;
            style.flexWrap = Wrap.Wrap;
            style.flexShrink = 0;
            style.display = DisplayStyle.None;
            RegisterCallback<KeyDownEvent>(e =>
            {
                if (e.keyCode != KeyCode.Escape || !isOpen) return;
                Fold();
                e.StopPropagation();
            });
            RegisterCallback<DetachFromPanelEvent>(_ => Fold());
        }

        /// <summary>Whether no preset can be chosen, too: that is told as an empty name.</summary>
        public bool offersNone { get; set; }

        /// <summary>Whether the presets are seen.</summary>
        public bool isOpen => style.display != DisplayStyle.None;

        /// <summary>Shows the presets, for a scan where there is one, or folds them.</summary>
        public void Toggle(LumivoxVolumeAsset volume, string preset = "")
        {
            if (isOpen) Fold();
            else Open(volume, preset);
        }

        /// <summary>Shows the presets, for a scan where there is one.</summary>
        public void Open(LumivoxVolumeAsset volume, string preset = "")
        {
            Fold();
            scan = volume;
            current = preset ?? "";
            if (scan != null) scan.changed += Fill;
            style.display = DisplayStyle.Flex;
            Fill();
        }

        /// <summary>Shows them no longer, and frees their pictures.</summary>
        public void Fold()
        {
            asked++;
            if (!ReferenceEquals(scan, null)) scan.changed -= Fill;
            scan = null;
            Clear();
            foreach (var tile in tiles) tile.Forget();
            tiles.Clear();
            style.display = DisplayStyle.None;
        }

        void Fill()
        {
            asked++;
            Clear();
            foreach (var tile in tiles) tile.Forget();
            tiles.Clear();
            try
            {
                foreach (var preset in LumivoxTransferFunction.PresetNames)
                    tiles.Add(new Tile(preset, TransferFunctionAccess.IsPresetAvailable(preset, scan), preset == current, scan, () => Choose(preset)));
            }
            catch (LumivoxException error)
            {
                Add(new HelpBox(error.Message, HelpBoxMessageType.Error));
                return;
            }
            foreach (var tile in tiles) Add(tile);
            if (offersNone) Add(new Button(() => Choose("")) { name = "none", text = "None", tooltip = "Forgets which preset it was; the look stays as it is." });
            Picture(0, asked);
        }

        /// One after the other: all at once would take a game's threads.
        void Picture(int place, int round)
        {
            while (place < tiles.Count && !tiles[place].IsAvailable) place++;
            if (round != asked || place >= tiles.Count || scan == null || scan.state != LumivoxVolumeState.Ready) return;
            scan.RequestPicture(2 * Side, tiles[place].Preset).ContinueWith(done =>
            {
                // Colours without a picture are still a choice.
                var made = done.IsFaulted || done.IsCanceled ? null : done.Result;
                if (round != asked) PresetSwatch.Destroy(made);
                else
                {
                    if (made != null) tiles[place].Show(made);
                    else if (done.IsFaulted) tiles[place].tooltip += $"\nIt has no picture: {done.Exception.GetBaseException().Message}";
                    Picture(place + 1, round);
                }
                return done.Exception;
            }, TaskContinuationOptions.ExecuteSynchronously);
        }

        void Choose(string preset)
        {
            Fold();
            chosen?.Invoke(preset);
        }
    }
}
