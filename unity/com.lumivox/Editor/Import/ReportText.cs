using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Text;
using UnityEditor;

namespace Lumivox.Editor
{
    /// <summary>What is known of scans, in words.</summary>
    static class ReportText
    {
        /// <summary>A row of the list of series.</summary>
        public static string Title(LumivoxSeries series)
        {
            var title = series.number != 0 ? $"{series.number}  " : "";
            return title + (string.IsNullOrEmpty(series.description) ? series.name : series.description);
        }

        /// <summary>What stands below its title: voxels, phases, files, and why another series comes first.</summary>
        public static string Line(LumivoxSeries series)
        {
            var facts = new List<string>();
            if (series.dims.Length == 3) facts.Add($"{series.dims[0]} \u00d7 {series.dims[1]} \u00d7 {series.dims[2]}");
            if (series.phases > 1) facts.Add($"{series.phases} phases");
            if (series.files > 0) facts.Add(series.files == 1 ? "one file" : $"{series.files} files");
            if (!string.IsNullOrEmpty(series.reason)) facts.Add(series.reason);
            return string.Join(",  ", facts);
        }

        /// <summary>All that is known of one series.</summary>
        public static string Of(LumivoxSeries series)
        {
            var facts = new List<string> { series.modality, series.orientation };
            if (series.spacing_mm.Length == 3) facts.Add($"voxels of {Number(series.spacing_mm[0])} \u00d7 {Number(series.spacing_mm[1])} \u00d7 {Number(series.spacing_mm[2])} mm");
            facts.Add($"{EditorUtility.FormatBytes(series.bytes)} in memory");
            if (!string.IsNullOrEmpty(series.unit)) facts.Add($"values in {series.unit}");
            var text = new StringBuilder(string.Join(", ", facts.Where(fact => !string.IsNullOrEmpty(fact)))).Append('\n');
            if (!string.IsNullOrEmpty(series.reason)) text.Append($"Not the first choice: {series.reason}\n");
            foreach (var note in series.notes) text.Append($"\u2022 {note}\n");
            return text.ToString();
        }

        /// <summary>Notes on the series that the report is about, then what was left out, grouped by the reason.</summary>
        public static string Of(LumivoxReport report, int place)
        {
            var text = new StringBuilder();
            if (place < 0) text.Append($"{report.format} without a series that can be imported\n");
            if (place >= 0 && place == report.chosen)
                foreach (var note in report.notes.Except(report.series[place].notes)) text.Append($"\u2022 {note}\n");
            foreach (var reason in report.skipped.GroupBy(file => file.reason))
            {
                var names = reason.Select(file => Path.GetFileName(file.path)).ToList();
                text.Append($"Left out, {reason.Key}: {names.Count} ({string.Join(", ", names.Take(5))}{(names.Count > 5 ? ", ..." : "")})\n");
            }
            return text.ToString();
        }

        /// <summary>What a scan is, in a line.</summary>
        public static string Of(LumivoxVolumeAsset scan)
        {
            var (dims, spacing, range) = (scan.dimensions, scan.spacingMm, scan.valueRange);
            return $"{dims.x} \u00d7 {dims.y} \u00d7 {dims.z} voxels of {Number(spacing.x)} \u00d7 {Number(spacing.y)} \u00d7 {Number(spacing.z)} mm, {Number(range.x)} to {Number(range.y)} {scan.unit}".TrimEnd();
        }

        public static string Number(float number) => number.ToString("0.###", CultureInfo.InvariantCulture);
    }
}
