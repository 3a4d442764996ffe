using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>What a value of a label map means.</summary>
    [Serializable]
    public struct LumivoxLabel
    {
        /// <summary>The voxels' value, 1 to 255.</summary>
        public int value;
        /// <summary>For people: `liver`.</summary>
        public string name;
        /// <summary>Its colour in the map.</summary>
        public Color color;
        /// <summary>How much there is of it, in millilitres.</summary>
        public double milliliters;

        /// <summary>A label for <see cref="LumivoxLabels.Create"/>.</summary>
        public LumivoxLabel(int value, string name, Color color)
        {
            this.value = value;
            this.name = name;
            this.color = color;
            milliliters = 0;
        }
    }

    // What a scan's parts are: labels, where it is a map of them, and depth below the skin.
    public sealed unsafe partial class LumivoxVolumeAsset
    {
        [SerializeField, HideInInspector]
        LumivoxLabel[] m_Labels = Array.Empty<LumivoxLabel>();
        [SerializeField, HideInInspector]
        bool m_IsLabelMap;

        Job findingSkin;
        string skinError = "";

        /// <summary>Whether its values are those of labels, as a segmentation's are: what <see cref="LumivoxLabels"/> takes.</summary>
        public bool isLabelMap => m_IsLabelMap;

        /// <summary>The labels of a label map, by rising value.</summary>
        public IReadOnlyList<LumivoxLabel> labels => m_Labels;

        /// <summary>Whether its skin is there, for what is peeled; asks for it where nobody has.</summary>
        internal bool NeedSkin()
        {
            if (handle == null) return false;
            // The library may know it a moment before its work is over and told: until then nothing is peeled, nor said of it.
            if (IsFindingSkin) return false;
            var known = Library.lumivox_volume_skin(handle.Pointer);
            if (known != 0 || skinError.Length > 0) return known == 1;
            findingSkin = Jobs.Follow(Library.lumivox_skin_find(handle.Pointer), (job, state) =>
            {
                if (job != findingSkin) return;
                findingSkin = null;
                // Asking again in each frame would only fail again.
                if (state != JobState.Done) skinError = state == JobState.Cancelled ? "it was stopped" : job.Error;
                LumivoxRuntime.RequestFrames();
                changed?.Invoke();
            });
            return false;
        }

        /// <summary>Why nothing is peeled of it; empty where that is not so, or not known yet.</summary>
        internal string SkinProblem
        {
            get
            {
                if (skinError.Length > 0) return $"Its skin cannot be found: {skinError}.";
                return !IsFindingSkin && handle != null && Library.lumivox_volume_skin(handle.Pointer) == 2 ? "No skin was found in it for sure." : "";
            }
        }

        /// <summary>Whether its skin is being looked for.</summary>
        internal bool IsFindingSkin => findingSkin != null && !findingSkin.Handle.IsClosed;

        void ForgetSkin()
        {
            findingSkin?.Cancel();
            findingSkin = null;
            skinError = "";
        }

        LumivoxLabel[] LabelsOf(IntPtr made)
        {
            var count = Library.lumivox_labels_count(made);
            m_IsLabelMap = count >= 0;
            if (count <= 0) return Array.Empty<LumivoxLabel>();
            var native = new LabelInfo[count];
            fixed (LabelInfo* to = native) Border.Checked(Library.lumivox_labels_list(made, to, (uint)count));
            var labels = new LumivoxLabel[count];
            for (var i = 0; i < count; i++)
            {
                var light = native[i].color;
                labels[i] = new LumivoxLabel((int)native[i].value, Border.TakeText(Library.lumivox_labels_name(made, (uint)i)), new Color(light.x, light.y, light.z, 1f).gamma)
                {
                    milliliters = native[i].milliliters,
                };
            }
            return labels;
        }
    }
}
