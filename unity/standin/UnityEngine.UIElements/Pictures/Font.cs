// A TrueType font of the machine: outlines and widths, for pictures of panels.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using UnityEngine;

namespace StandIn
{
    public sealed class Font
    {
        static readonly string[] folders = { "/usr/share/fonts/truetype/dejavu", "/usr/share/fonts/TTF", "/usr/share/fonts/dejavu-sans-fonts", "/usr/share/fonts/dejavu" };
        /// Straight pieces of a curve: at these sizes more are not seen.
        const int Pieces = 4;

        readonly byte[] data;
        readonly Dictionary<string, int> tables = new Dictionary<string, int>();
        readonly Dictionary<int, List<List<Vector2>>> outlines = new Dictionary<int, List<List<Vector2>>>();
        readonly int unitsPerEm, widths, characters;
        readonly bool longOffsets;

        Font(string file)
        {
            data = File.ReadAllBytes(file);
            for (int i = 0, count = U16(4); i < count; i++) tables[System.Text.Encoding.ASCII.GetString(data, 12 + 16 * i, 4)] = (int)U32(12 + 16 * i + 8);
            unitsPerEm = U16(tables["head"] + 18);
            longOffsets = U16(tables["head"] + 50) != 0;
            widths = U16(tables["hhea"] + 34);
            for (int i = 0, cmap = tables["cmap"], count = U16(cmap + 2); i < count; i++)
            {
                var at = cmap + (int)U32(cmap + 4 + 8 * i + 4);
                if (U16(at) == 4) characters = at;
            }
            if (characters == 0) throw new InvalidDataException($"{file} has no table of characters that is understood");
        }

        /// STANDIN_FONT names one; otherwise it is DejaVu Sans, plain or bold.
        public static Font Load(bool bold)
        {
            var own = Environment.GetEnvironmentVariable("STANDIN_FONT");
            var files = string.IsNullOrEmpty(own) ? folders.Select(folder => Path.Combine(folder, bold ? "DejaVuSans-Bold.ttf" : "DejaVuSans.ttf")) : new[] { own };
            return new Font(files.FirstOrDefault(File.Exists) ?? throw new FileNotFoundException("there is no DejaVu Sans on this machine (Debian: fonts-dejavu-core): STANDIN_FONT names another TrueType font"));
        }

        int U16(int at) => data[at] << 8 | data[at + 1];
        int S16(int at) => (short)U16(at);
        uint U32(int at) => (uint)U16(at) << 16 | (uint)U16(at + 2);

        public float Width(string text, float size) => text.Sum(character => Advance(Glyph(character))) * size / unitsPerEm;

        /// Closed lines of a text that begins at a point of its base line; down is positive.
        public IEnumerable<List<Vector2>> Outlines(string text, Vector2 at, float size)
        {
            var scale = size / unitsPerEm;
            foreach (var character in text)
            {
                var glyph = Glyph(character);
                foreach (var contour in Outline(glyph)) yield return contour.Select(point => new Vector2(at.x + point.x * scale, at.y - point.y * scale)).ToList();
                at.x += Advance(glyph) * scale;
            }
        }

        int Advance(int glyph) => U16(tables["hmtx"] + 4 * Math.Min(glyph, widths - 1));

        int Glyph(int character)
        {
            int twice = U16(characters + 6), ends = characters + 14, starts = ends + twice + 2, deltas = starts + twice, ranges = deltas + twice;
            for (var i = 0; i < twice; i += 2)
            {
                if (character > U16(ends + i)) continue;
                var start = U16(starts + i);
                if (character < start) return 0;
                var range = U16(ranges + i);
                if (range == 0) return character + U16(deltas + i) & 0xffff;
                var glyph = U16(ranges + i + range + 2 * (character - start));
                return glyph == 0 ? 0 : glyph + U16(deltas + i) & 0xffff;
            }
            return 0;
        }

        List<List<Vector2>> Outline(int glyph)
        {
            if (outlines.TryGetValue(glyph, out var known)) return known;
            var contours = outlines[glyph] = new List<List<Vector2>>();
            int Offset(int i) => longOffsets ? (int)U32(tables["loca"] + 4 * i) : 2 * U16(tables["loca"] + 2 * i);
            if (Offset(glyph) == Offset(glyph + 1)) return contours;
            var at = tables["glyf"] + Offset(glyph);
            var count = S16(at);
            if (count < 0) Compose(at + 10, contours);
            else Trace(at + 10, count, contours);
            return contours;
        }

        /// A glyph of others, such as a letter and its accent.
        void Compose(int at, List<List<Vector2>> contours)
        {
            int flags;
            do
            {
                flags = U16(at);
                var part = U16(at + 2);
                var words = (flags & 1) != 0;
                var move = words ? new Vector2(S16(at + 4), S16(at + 6)) : new Vector2((sbyte)data[at + 4], (sbyte)data[at + 5]);
                at += words ? 8 : 6;
                var scale = Vector2.one;
                if ((flags & 8) != 0) { scale = Vector2.one * (S16(at) / 16384f); at += 2; }
                else if ((flags & 64) != 0) { scale = new Vector2(S16(at) / 16384f, S16(at + 2) / 16384f); at += 4; }
                else if ((flags & 128) != 0) at += 8;
                foreach (var contour in Outline(part)) contours.Add(contour.Select(point => new Vector2(point.x * scale.x, point.y * scale.y) + move).ToList());
            } while ((flags & 32) != 0);
        }

        void Trace(int at, int count, List<List<Vector2>> contours)
        {
            var ends = Enumerable.Range(0, count).Select(i => U16(at + 2 * i)).ToArray();
            var points = count == 0 ? 0 : ends[count - 1] + 1;
            at += 2 * count;
            at += 2 + U16(at);
            var flags = new byte[points];
            for (var i = 0; i < points; i++)
            {
                flags[i] = data[at++];
                if ((flags[i] & 8) == 0) continue;
                for (var repeats = data[at++]; repeats > 0; repeats--, i++) flags[i + 1] = flags[i];
            }
            float[] Coordinates(int small, int same)
            {
                var values = new float[points];
                var value = 0;
                for (var i = 0; i < points; i++)
                {
                    if ((flags[i] & small) != 0) value += (flags[i] & same) != 0 ? data[at++] : -data[at++];
                    else if ((flags[i] & same) == 0) { value += S16(at); at += 2; }
                    values[i] = value;
                }
                return values;
            }
            float[] xs = Coordinates(2, 16), ys = Coordinates(4, 32);
            for (int c = 0, first = 0; c < count; first = ends[c++] + 1) contours.Add(Flat(Enumerable.Range(first, ends[c] - first + 1).Select(i => (new Vector2(xs[i], ys[i]), (flags[i] & 1) != 0)).ToList()));
        }

        /// Quadratic curves as straight pieces; between two control points lies one of the curve's own.
        static List<Vector2> Flat(List<(Vector2 at, bool isOn)> points)
        {
            var whole = new List<(Vector2 at, bool isOn)>();
            for (var i = 0; i < points.Count; i++)
            {
                var next = points[(i + 1) % points.Count];
                whole.Add(points[i]);
                if (!points[i].isOn && !next.isOn) whole.Add(((points[i].at + next.at) / 2, true));
            }
            var start = whole.FindIndex(point => point.isOn);
            var flat = new List<Vector2>();
            for (var i = 0; i < whole.Count && start >= 0; i++)
            {
                var (at, isOn) = whole[(start + i) % whole.Count];
                if (isOn) { flat.Add(at); continue; }
                Vector2 from = whole[(start + i - 1 + whole.Count) % whole.Count].at, to = whole[(start + i + 1) % whole.Count].at;
                for (var piece = 1; piece < Pieces; piece++)
                {
                    var t = piece / (float)Pieces;
                    flat.Add((1 - t) * (1 - t) * from + 2 * t * (1 - t) * at + t * t * to);
                }
            }
            return flat;
        }
    }
}
