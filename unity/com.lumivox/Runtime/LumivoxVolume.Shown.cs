using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    // What of its scan a volume shows: the patient, one organ, or all that was scanned.
    public sealed unsafe partial class LumivoxVolume
    {
        [NonSerialized] ShownPart shown;
        [NonSerialized] LumivoxVolumeAsset shownOf;
        /// Whether a game was told that there is no such part.
        [NonSerialized] bool isTold;
        /// The preset that was asked about last, and the part that it is for.
        [NonSerialized] string askedPreset;
        [NonSerialized] ScanPart partOfPreset;

        /// <summary>
        /// Whether what lies around the patient in a CT is seen, too: the table, clothes, cables, where the import has put them
        /// aside (see <see cref="LumivoxVolumeAsset.hasSurroundings"/>). They come back within a moment, from another thread.
        /// With it, a preset that shows one organ shows all, and <see cref="peelMm"/> takes them off with the skin.
        /// </summary>
        public bool keepEverything
        {
            get => m_KeepEverything;
            set
            {
                MainThread.Need("LumivoxVolume.keepEverything");
                m_KeepEverything = value;
                Change();
            }
        }

        /// <summary>
        /// Whether another thread still computes something that is shown here: the surroundings of the patient, the organ of the
        /// preset, the skin below which it peels. Until then it is seen without.
        /// </summary>
        public bool isPreparing
        {
            get
            {
                MainThread.Need("LumivoxVolume.isPreparing");
                if (!isActiveAndEnabled || m_Volume == null) return false;
                var part = Shown();
                return part != null && part.IsComing || m_PeelMm > 0f && !m_Volume.NeedSkin() && m_Volume.IsFindingSkin;
            }
        }

        /// <summary>What is being computed, for people; empty where nothing is.</summary>
        internal string Preparing
        {
            get
            {
                if (!isPreparing) return "";
                if (shown == null || !shown.IsComing) return "The skin is being found.";
                return shown.Kind == ScanPart.Everything ? "What lies around the patient is being put back." : "The organ is being found.";
            }
        }

        /// <summary>What is seen in place of the patient, for the native library; zero: the scan as it is.</summary>
        IntPtr ShownPointer()
        {
            var part = Shown();
            if (part == null) return IntPtr.Zero;
            if (!isTold && (part.IsMissing || part.Error.Length > 0))
            {
                isTold = true;
                if (Application.isPlaying) Debug.LogWarning($"LumivoxVolume: {PartWarning()}", this);
            }
            return part.Pointer;
        }

        ShownPart Shown()
        {
            var wanted = m_Volume == null || m_Volume.Pointer == IntPtr.Zero ? ScanPart.None : m_KeepEverything ? ScanPart.Everything : PartOfPreset();
            if (shown != null && (shown.Kind != wanted || shown.IsOver || !ReferenceEquals(shownOf, m_Volume))) LeavePart();
            if (shown == null && wanted != ScanPart.None)
            {
                shownOf = m_Volume;
                shown = m_Volume.TakePart(wanted);
            }
            return shown;
        }

        void LeavePart()
        {
            // Of a scan that was destroyed all are over.
            if (shown != null && !shown.IsOver) shownOf.LeavePart(shown);
            (shown, shownOf, isTold) = (null, null, false);
        }

        ScanPart PartOfPreset()
        {
            if (ReferenceEquals(askedPreset, m_Preset)) return partOfPreset;
            askedPreset = m_Preset;
            if (string.IsNullOrEmpty(m_Preset)) return partOfPreset = ScanPart.None;
            fixed (byte* utf8 = Border.Utf8(m_Preset)) return partOfPreset = (ScanPart)Library.lumivox_preset_part(utf8);
        }

        /// <summary>Why something else is seen than was asked for; null where that is not so.</summary>
        string PartWarning()
        {
            if (shown != null && shown.Error.Length > 0) return $"Not what was asked for is seen of the scan: {shown.Error}.";
            if (shown == null || !shown.IsMissing || shown.Kind == ScanPart.Everything) return null;
            var what = shown.Kind == ScanPart.Airways ? "airways" : "lungs with vessels";
            return $"No {what} were found in the scan for sure: all of it is seen with the preset {m_Preset}.";
        }

        void AddWarningsOfShown(List<string> warnings)
        {
            if (m_Volume == null || m_Volume.state != LumivoxVolumeState.Ready) return;
            if (m_KeepEverything && m_Volume.HasLostSurroundings) warnings.Add("'Keep Everything' has nothing to put back: when the scan was imported, what lies around the patient was not kept. Import it again.");
            if (isActiveAndEnabled) Shown();
            var problem = PartWarning();
            if (problem != null) warnings.Add(problem);
        }
    }
}
