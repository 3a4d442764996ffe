using System;
using UnityEngine;

namespace Lumivox
{
    // The fields are the keys of the library's JSON.
#pragma warning disable IDE1006

    /// <summary>How a scan was loaded, or what files hold.</summary>
    [Serializable]
    public sealed class LumivoxReport
    {
        /// <summary>What the files are, such as `DICOM`.</summary>
        public string format = "";
        /// <summary>What could have been loaded. A stored scan keeps only the one that it is.</summary>
        public LumivoxSeries[] series = Array.Empty<LumivoxSeries>();
        /// <summary>Which of them it is, from 0.</summary>
        public int chosen;
        /// <summary>Sentences for people.</summary>
        public string[] notes = Array.Empty<string>();
        /// <summary>Slices that are missing and were left empty.</summary>
        public int[] empty_slices = Array.Empty<int>();
        /// <summary>Files that were passed over.</summary>
        public LumivoxSkippedFile[] skipped = Array.Empty<LumivoxSkippedFile>();

        /// <summary>The series that it is about; null where there is none.</summary>
        public LumivoxSeries chosenSeries => chosen >= 0 && chosen < series.Length ? series[chosen] : null;

        internal static LumivoxReport FromJson(string json)
        {
            if (IsNothing(json)) return new LumivoxReport();
            return JsonUtility.FromJson<LumivoxReport>(json) ?? new LumivoxReport();
        }

        /// <summary>Of a scan, which is one series.</summary>
        internal static LumivoxReport OfScan(string json)
        {
            var report = new LumivoxReport();
            if (IsNothing(json)) return report;
            var of = JsonUtility.FromJson<Scan>(json);
            if (of == null) return report;
            report.format = of.format ?? "";
            report.notes = of.notes ?? Array.Empty<string>();
            // What is null in JSON comes as one without a name.
            if (of.series != null && !string.IsNullOrEmpty(of.series.name)) report.series = new[] { of.series };
            return report;
        }

        static bool IsNothing(string json) => string.IsNullOrEmpty(json) || json == "null";

        [Serializable]
        sealed class Scan
        {
            public string format = "";
            public string[] notes = Array.Empty<string>();
            public LumivoxSeries series = null;
        }
    }

    /// <summary>A series of a study.</summary>
    [Serializable]
    public sealed class LumivoxSeries
    {
        /// <summary>What it is chosen by; not kept with stored scans.</summary>
        public string id = "";
        /// <summary>Such as `CT series 4`, which names neither files nor the patient.</summary>
        public string name = "";
        /// <summary>Its SeriesInstanceUID.</summary>
        public string uid = "";
        /// <summary>DICOM's number; 0 without one.</summary>
        public int number;
        /// <summary>What the scanner calls it.</summary>
        public string description = "";
        /// <summary>How many files it is in.</summary>
        public int files;
        /// <summary>DICOM's code, such as `CT`.</summary>
        public string modality = "";
        /// <summary>Voxels along x, y and z.</summary>
        public int[] dims = Array.Empty<int>();
        /// <summary>Millimetres between them.</summary>
        public float[] spacing_mm = Array.Empty<float>();
        /// <summary>Of its slices, such as `axial`.</summary>
        public string orientation = "";
        /// <summary>Volumes in it.</summary>
        public int phases;
        /// <summary>Of its values.</summary>
        public string unit = "";
        /// <summary>Memory that one phase takes.</summary>
        public long bytes;
        /// <summary>Why another series comes first, such as `a localizer`; empty for the first.</summary>
        public string reason = "";
        /// <summary>The series that a segmentation belongs to.</summary>
        public string segments_series = "";
        /// <summary>Sentences for people.</summary>
        public string[] notes = Array.Empty<string>();
    }

    /// <summary>A file that was passed over.</summary>
    [Serializable]
    public sealed class LumivoxSkippedFile
    {
        /// <summary>Its path.</summary>
        public string path = "";
        /// <summary>Why.</summary>
        public string reason = "";
    }
}
