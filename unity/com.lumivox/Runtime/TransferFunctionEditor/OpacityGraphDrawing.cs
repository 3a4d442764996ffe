using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    public sealed partial class OpacityGraph
    {
        readonly List<double> ticks = new List<double>();
        readonly List<Label> labels = new List<Label>();
        readonly List<float> columns = new List<float>();
        float[] histogram = Array.Empty<float>();
        (double low, double high) histogramRange;
        Label invitation;

        /// <summary>Counts of voxels per bin over these values; empty where there is no scan.</summary>
        internal void SetHistogram(float[] counts, double low, double high)
        {
            histogram = counts;
            histogramRange = (low, high);
            MarkDirtyRepaint();
        }

        /// Numbers are elements of their own, which cannot be made while something is drawn.
        void PlaceTicks()
        {
            axis.Ticks((int)(contentRect.width / 80), ticks);
            for (var i = 0; i < Math.Max(ticks.Count, labels.Count); i++)
            {
                if (i == labels.Count)
                {
                    var label = new Label { pickingMode = PickingMode.Ignore };
                    label.style.position = Position.Absolute;
                    label.style.bottom = 2;
                    label.style.width = 76;
                    label.style.height = 14;
                    label.style.fontSize = 10;
                    label.style.opacity = 0.55f;
                    label.style.paddingLeft = label.style.paddingRight = label.style.paddingTop = label.style.paddingBottom = 0;
                    label.style.marginLeft = label.style.marginRight = 0;
                    label.style.unityTextAlign = TextAnchor.MiddleCenter;
                    labels.Add(label);
                    Add(label);
                }
                labels[i].style.display = i < ticks.Count && !model.IsEmpty ? DisplayStyle.Flex : DisplayStyle.None;
                if (i >= ticks.Count) continue;
                labels[i].text = axis.Text(ticks[i], false);
                labels[i].style.left = PixelOf(ticks[i]) - 38;
            }
        }

        /// <summary>Shows what there is to do where there are no points yet.</summary>
        internal void ShowInvitation()
        {
            if (invitation == null)
            {
                invitation = new Label("Double-click to add the first knot, or choose a preset.") { pickingMode = PickingMode.Ignore };
                invitation.StretchToParentSize();
                invitation.style.unityTextAlign = TextAnchor.MiddleCenter;
                invitation.style.opacity = 0.6f;
                Add(invitation);
            }
            invitation.style.display = HasFunction && model.IsEmpty ? DisplayStyle.Flex : DisplayStyle.None;
            PlaceTicks();
            MarkDirtyRepaint();
        }

        protected override void Draw(MeshGenerationContext context)
        {
            if (contentRect.width <= 2 * Margin || contentRect.height <= Top + Bottom) return;
            var painter = context.painter2D;
            Fill(painter, contentRect, new Color(0.07f, 0.08f, 0.1f, 0.55f));
            if (model.IsEmpty) return;
            DrawGrid(painter);
            DrawHistogram(context);
            DrawCurve(context);
            DrawKnots(painter);
        }

        void DrawGrid(Painter2D painter)
        {
            for (var step = 0; step < 5; step++)
            {
                var y = HeightOf(step / 4.0);
                Line(painter, new Vector2(Plot.xMin, y), new Vector2(Plot.xMax, y), Ink(step == 0 ? 0.16f : 0.07f), 1);
            }
            foreach (var tick in ticks)
            {
                var x = PixelOf(tick);
                Line(painter, new Vector2(x, Plot.yMin), new Vector2(x, Plot.yMax + 3), Ink(0.07f), 1);
            }
        }

        /// Counts on a log scale: air outnumbers everything else by far.
        void DrawHistogram(MeshGenerationContext context)
        {
            var highest = 0f;
            foreach (var count in histogram) highest = Math.Max(highest, count);
            if (highest <= 0) return;
            var plot = Plot;
            var width = (histogramRange.high - histogramRange.low) / histogram.Length;
            int first = -1, end = 0;
            for (var i = 0; i < histogram.Length; i++)
            {
                var x = PixelOf(histogramRange.low + (i + 0.5) * width);
                if (x < plot.xMin - 8 || x > plot.xMax + 8) continue;
                if (first < 0) first = i;
                end = i + 1;
            }
            if (first < 0) return;
            var ink = Ink(0.16f);
            FillBand(context, end - first, i =>
            {
                var x = PixelOf(histogramRange.low + (first + i + 0.5) * width);
                var height = (float)(Math.Log(1 + histogram[first + i]) / Math.Log(1 + highest)) * plot.height * 0.94f;
                return (new Vector2(x, plot.yMax), new Vector2(x, plot.yMax - height), ink, ink);
            });
        }

        void DrawCurve(MeshGenerationContext context)
        {
            var plot = Plot;
            columns.Clear();
            for (var x = plot.xMin; x < plot.xMax; x += 2) columns.Add(x);
            columns.Add(plot.xMax);
            foreach (var knot in model.Knots)
            {
                var at = PixelOf(model.Shown(knot.value));
                if (at > plot.xMin && at < plot.xMax) columns.Add(at);
            }
            columns.Sort();
            FillBand(context, columns.Count, i =>
            {
                var value = ValueAt(columns[i]);
                var color = model.ColorAt(value);
                return (new Vector2(columns[i], plot.yMax), new Vector2(columns[i], HeightOf(model.OpacityAt(value))),
                    new Color(color.r, color.g, color.b, 0.22f), new Color(color.r, color.g, color.b, 0.72f));
            });
            var painter = context.painter2D;
            painter.strokeColor = Ink(0.95f);
            painter.lineWidth = 1.6f;
            painter.lineJoin = LineJoin.Round;
            painter.BeginPath();
            for (var i = 0; i < columns.Count; i++)
            {
                var at = new Vector2(columns[i], HeightOf(model.OpacityAt(ValueAt(columns[i]))));
                if (i == 0) painter.MoveTo(at);
                else painter.LineTo(at);
            }
            painter.Stroke();
        }

        void DrawKnots(Painter2D painter)
        {
            var hasFocus = focusController?.focusedElement == this;
            for (var i = 0; i < model.Knots.Count; i++)
            {
                var at = PlaceOf(i);
                if (at.x < -8 || at.x > contentRect.width + 8) continue;
                var isActive = i == selected || i == dragged;
                var radius = isActive || i == Hovered ? 6.5f : 5;
                Disc(painter, at, radius + 1.5f, new Color(0, 0, 0, 0.55f));
                Disc(painter, at, radius, isActive ? Accent() : Knob);
                Disc(painter, at, radius - 2.2f, model.ColorAt(model.Shown(model.Knots[i].value)));
                if (!isActive || !hasFocus) continue;
                painter.strokeColor = Accent(0.7f);
                painter.lineWidth = 1.2f;
                painter.BeginPath();
                painter.Arc(at, radius + 3.5f, 0, 360);
                painter.Stroke();
            }
        }
    }
}
