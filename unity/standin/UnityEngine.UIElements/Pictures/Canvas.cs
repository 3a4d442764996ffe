// Paints shapes, text and pictures with smooth edges, as a screen has them: sRGB, the highest row first.
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;

namespace StandIn
{
    public sealed class Canvas
    {
        /// Lines of a pixel that are looked at.
        const int Lines = 5;

        static readonly Font plain = Font.Load(false), bold = Font.Load(true);
        readonly Color[] pixels;
        readonly float[] cover;
        public readonly int width, height;
        public Rect Clip;

        public Canvas(int width, int height)
        {
            (this.width, this.height) = (width, height);
            pixels = new Color[width * height];
            cover = new float[width];
            Clip = new Rect(0, 0, width, height);
        }

        /// For files: the lowest row first.
        public Picture ToPicture()
        {
            var picture = new Picture(width, height);
            for (var y = 0; y < height; y++) Array.Copy(pixels, y * width, picture.pixels, (height - 1 - y) * width, width);
            return picture;
        }

        void Blend(int x, int y, Color color, float alpha)
        {
            if (x < Clip.xMin || y < Clip.yMin || x >= Clip.xMax || y >= Clip.yMax) return;
            var at = y * width + x;
            var under = pixels[at];
            pixels[at] = new Color(under.r + (color.r - under.r) * alpha, under.g + (color.g - under.g) * alpha, under.b + (color.b - under.b) * alpha, 1f);
        }

        /// Fills what closed lines go around.
        public void Fill(IEnumerable<IReadOnlyList<Vector2>> closed, Color color)
        {
            var edges = new List<(Vector2 from, Vector2 to)>();
            foreach (var line in closed)
                for (var i = 0; i < line.Count; i++) edges.Add((line[i], line[(i + 1) % line.Count]));
            if (edges.Count == 0 || color.a <= 0f) return;
            int first = Mathf.Max(0, Mathf.FloorToInt(edges.Min(edge => edge.from.y))), last = Mathf.Min(height - 1, Mathf.FloorToInt(edges.Max(edge => edge.from.y)));
            for (var y = first; y <= last; y++)
            {
                Array.Clear(cover, 0, width);
                for (var line = 0; line < Lines; line++)
                {
                    var at = y + (line + 0.5f) / Lines;
                    var crossings = edges.Where(edge => edge.from.y <= at != edge.to.y <= at)
                        .Select(edge => (x: edge.from.x + (at - edge.from.y) / (edge.to.y - edge.from.y) * (edge.to.x - edge.from.x), turn: edge.from.y < edge.to.y ? 1 : -1)).OrderBy(crossing => crossing.x).ToList();
                    for (int i = 0, turns = 0; i + 1 < crossings.Count; i++)
                        if ((turns += crossings[i].turn) != 0) Cover(crossings[i].x, crossings[i + 1].x);
                }
                for (var x = 0; x < width; x++)
                    if (cover[x] > 0) Blend(x, y, color, color.a * Mathf.Min(1f, cover[x]));
            }
        }

        void Cover(float from, float to)
        {
            for (var x = Mathf.Max(0, Mathf.FloorToInt(from)); x < Mathf.Min(width, to); x++)
                cover[x] += Mathf.Max(0f, Mathf.Min(x + 1, to) - Mathf.Max(x, from)) / Lines;
        }

        public void Fill(Rect rect, Color color, float round = 0)
        {
            if (round <= 0) Fill(new[] { new[] { new Vector2(rect.xMin, rect.yMin), new Vector2(rect.xMax, rect.yMin), new Vector2(rect.xMax, rect.yMax), new Vector2(rect.xMin, rect.yMax) } }, color);
            else Fill(new[] { Rounded(rect, round) }, color);
        }

        static Vector2[] Rounded(Rect rect, float round) => Enumerable.Range(0, 24).Select(i =>
        {
            var angle = (i + 0.5f) / 24 * 2 * Mathf.PI;
            var way = new Vector2(Mathf.Cos(angle), Mathf.Sin(angle));
            return new Vector2(way.x > 0 ? rect.xMax - round : rect.xMin + round, way.y > 0 ? rect.yMax - round : rect.yMin + round) + way * round;
        }).ToArray();

        /// A box with a border of a pixel.
        public void Box(Rect rect, Color inside, Color border, float round = 3)
        {
            Fill(rect, border, round);
            Fill(new Rect(rect.x + 1, rect.y + 1, rect.width - 2, rect.height - 2), inside, round - 1);
        }

        public void Line(IReadOnlyList<Vector2> points, Color color, float thick)
        {
            for (var i = 0; i + 1 < points.Count; i++)
            {
                var along = points[i + 1] - points[i];
                if (along.magnitude < 1e-4f) continue;
                var side = new Vector2(-along.y, along.x) / along.magnitude * thick / 2;
                Fill(new[] { new[] { points[i] + side, points[i + 1] + side, points[i + 1] - side, points[i] - side } }, color);
            }
        }

        /// A triangle whose corners have colours.
        public void Triangle(Vector2[] at, Color[] colors)
        {
            var area = Cross(at[1] - at[0], at[2] - at[0]);
            if (Mathf.Abs(area) < 1e-6f) return;
            for (var y = Mathf.FloorToInt(at.Min(p => p.y)); y <= at.Max(p => p.y); y++)
                for (var x = Mathf.FloorToInt(at.Min(p => p.x)); x <= at.Max(p => p.x); x++)
                {
                    var p = new Vector2(x + 0.5f, y + 0.5f);
                    float b = Cross(p - at[0], at[2] - at[0]) / area, c = Cross(at[1] - at[0], p - at[0]) / area;
                    if (b < 0 || c < 0 || b + c > 1) continue;
                    var color = colors[0] * (1 - b - c) + colors[1] * b + colors[2] * c;
                    if (x >= 0 && y >= 0 && x < width && y < height) Blend(x, y, color, color.a);
                }
        }

        static float Cross(Vector2 a, Vector2 b) => a.x * b.y - a.y * b.x;

        /// A picture in a box, as large as keeps its shape; pixels with the lowest row first.
        public void Image(Rect box, int columns, int rows, Func<int, int, Color> pixel)
        {
            var scale = Mathf.Min(box.width / columns, box.height / rows);
            var rect = new Rect(box.x + (box.width - columns * scale) / 2, box.y + (box.height - rows * scale) / 2, columns * scale, rows * scale);
            for (var y = Mathf.Max(0, Mathf.FloorToInt(rect.yMin)); y < Mathf.Min(height, rect.yMax); y++)
                for (var x = Mathf.Max(0, Mathf.FloorToInt(rect.xMin)); x < Mathf.Min(width, rect.xMax); x++)
                {
                    // The mean of what lies below a pixel.
                    var sum = Color.clear;
                    for (var part = 0; part < 9; part++)
                    {
                        int column = Mathf.FloorToInt((x + (part % 3 + 0.5f) / 3 - rect.x) / scale), row = Mathf.FloorToInt((y + (part / 3 + 0.5f) / 3 - rect.y) / scale);
                        if (column < 0 || row < 0 || column >= columns || row >= rows) continue;
                        var color = pixel(column, rows - 1 - row);
                        sum += new Color(color.r * color.a, color.g * color.a, color.b * color.a, color.a);
                    }
                    if (sum.a > 0) Blend(x, y, sum / sum.a, sum.a / 9);
                }
        }

        public static float TextWidth(string text, float size, bool isBold) => (isBold ? bold : plain).Width(text, size);

        public void Text(string text, Vector2 baseline, float size, Color color, bool isBold) => Fill((isBold ? bold : plain).Outlines(text, baseline, size), color);

        /// A text in lines that are no longer than that.
        public static List<string> Wrapped(string text, float size, bool isBold, float most)
        {
            var lines = new List<string>();
            foreach (var paragraph in text.Split('\n'))
            {
                var line = "";
                foreach (var word in paragraph.Split(' '))
                {
                    var longer = line == "" ? word : line + " " + word;
                    if (line != "" && TextWidth(longer, size, isBold) > most) { lines.Add(line); longer = word; }
                    line = longer;
                }
                lines.Add(line);
            }
            return lines;
        }
    }
}
