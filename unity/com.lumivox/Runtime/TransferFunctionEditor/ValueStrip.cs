using System;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>A strip of the transfer-function editor over the shared axis: what zooming, panning, holding and drawing have in common.</summary>
    public abstract class ValueStrip : VisualElement
    {
        /// <summary>Pixels between the element's sides and the axis' ends.</summary>
        public const float Margin = 14;
        const float WheelZoom = 1.2f;
        /// How near the pointer must be to a handle, in pixels, and a finger.
        const float GrabDistance = 11, TouchDistance = 26;
        static readonly Color accent = new Color(0.95f, 0.62f, 0.42f);

        /// <summary>Before the first change of an edit, with its name.</summary>
        internal Action<string> EditStarted;
        /// <summary>After each change.</summary>
        internal Action Edited;
        /// <summary>When an edit is over, with the series that it belongs to, or null.</summary>
        internal Action<string> EditFinished;
        /// <summary>An edit is given up: all shall be as before.</summary>
        internal Action EditDropped;
        /// <summary>What is under the pointer.</summary>
        internal Action<string> Hinted;

        protected readonly ValueAxis axis;
        protected readonly TransferFunctionModel model;
        bool isPanning, isEditing;

        protected ValueStrip(ValueAxis axis, TransferFunctionModel model)
        {
            this.axis = axis;
            this.model = model;
            style.overflow = Overflow.Hidden;
            generateVisualContent += Draw;
            RegisterCallback<PointerDownEvent>(OnPointerDown);
            RegisterCallback<PointerMoveEvent>(OnPointerMove);
            RegisterCallback<PointerUpEvent>(OnPointerUp);
            RegisterCallback<PointerCancelEvent>(_ => LetGo());
            RegisterCallback<PointerCaptureOutEvent>(_ => LetGo());
            RegisterCallback<PointerLeaveEvent>(_ => { Hover(-1); Hinted?.Invoke(""); });
            RegisterCallback<WheelEvent>(OnWheel);
            axis.ViewChanged += MarkDirtyRepaint;
        }

        /// <summary>The handle that the pointer is at, or -1.</summary>
        public int Hovered { get; private set; } = -1;

        protected abstract int HandleCount { get; }
        /// Pixels from a handle to a place.
        protected abstract float DistanceTo(int handle, Vector2 at);
        protected abstract void Press(PointerDownEvent e, int handle);
        protected abstract void Drag(PointerMoveEvent e);
        protected abstract void Release();
        protected abstract bool IsDragging { get; }
        protected virtual void PointAt(Vector2 at) { }
        protected virtual bool IsUsable => !model.IsEmpty;
        protected abstract void Draw(MeshGenerationContext context);

        /// <summary>The pixel of a value.</summary>
        public float PixelOf(double value) => axis.PixelOf(value, contentRect.width, Margin);

        /// <summary>The value at a pixel.</summary>
        public double ValueAt(float pixel) => axis.ValueAt(pixel, contentRect.width, Margin);

        protected void Begin(string name)
        {
            if (isEditing) return;
            isEditing = true;
            EditStarted?.Invoke(name);
        }

        protected void End(string series = null)
        {
            if (!isEditing) return;
            isEditing = false;
            EditFinished?.Invoke(series);
        }

        /// An edit that is done at once.
        protected void Do(string name, Action edit, string series = null)
        {
            Begin(name);
            edit();
            Edited?.Invoke();
            End(series);
        }

        /// <summary>Lets go of what is dragged, for the points became others; it is nobody's edit any more.</summary>
        internal virtual void Drop()
        {
            isEditing = false;
            Release();
            Hover(-1);
        }

        /// <summary>Ends what is under way, as lifting the pointer does.</summary>
        internal void LetGo()
        {
            isPanning = false;
            if (!IsDragging) return;
            Release();
            End();
            MarkDirtyRepaint();
        }

        /// <summary>Gives up the edit that is under way. Returns whether there was one.</summary>
        internal bool GiveUp()
        {
            if (!IsDragging) return false;
            var wasEditing = isEditing;
            Drop();
            if (wasEditing) EditDropped?.Invoke();
            return true;
        }

        protected int HandleAt(Vector2 at, string pointerType)
        {
            var nearest = -1;
            var distance = pointerType == UnityEngine.UIElements.PointerType.touch ? TouchDistance : GrabDistance;
            for (var i = 0; i < HandleCount; i++)
            {
                var d = DistanceTo(i, at);
                if (d >= distance) continue;
                distance = d;
                nearest = i;
            }
            return nearest;
        }

        protected void Hover(int handle)
        {
            if (handle == Hovered) return;
            Hovered = handle;
            MarkDirtyRepaint();
        }

        void OnPointerDown(PointerDownEvent e)
        {
            if (e.button == 2 || e.button == 0 && e.altKey)
            {
                isPanning = true;
                this.CapturePointer(e.pointerId);
                e.StopPropagation();
                return;
            }
            if (!IsUsable || IsDragging) return;
            Press(e, HandleAt(e.localPosition, e.pointerType));
            if (IsDragging) this.CapturePointer(e.pointerId);
            e.StopPropagation();
        }

        void OnPointerMove(PointerMoveEvent e)
        {
            if (isPanning)
                axis.Pan(ValueAt(0) - ValueAt(e.deltaPosition.x));
            else if (IsDragging)
                Drag(e);
            else if (IsUsable)
            {
                Hover(HandleAt(e.localPosition, e.pointerType));
                PointAt(e.localPosition);
                return;
            }
            else
                return;
            e.StopPropagation();
        }

        void OnPointerUp(PointerUpEvent e)
        {
            // Losing the pointer is what ends a drag.
            if (this.HasPointerCapture(e.pointerId)) this.ReleasePointer(e.pointerId);
            LetGo();
            e.StopPropagation();
        }

        void OnWheel(WheelEvent e)
        {
            var at = ValueAt(e.localMousePosition.x);
            if (e.shiftKey || Math.Abs(e.delta.x) > Math.Abs(e.delta.y))
                axis.Pan(axis.Width * 0.05 * Math.Sign(Math.Abs(e.delta.x) > Math.Abs(e.delta.y) ? e.delta.x : e.delta.y));
            else if (e.delta.y != 0)
                axis.Zoom(e.delta.y < 0 ? WheelZoom : 1 / WheelZoom, at);
            e.StopPropagation();
        }

        /// The theme's text colour, as faint as asked for.
        protected Color Ink(float alpha)
        {
            var ink = resolvedStyle.color;
            return new Color(ink.r, ink.g, ink.b, alpha);
        }

        protected static Color Accent(float alpha = 1) => new Color(accent.r, accent.g, accent.b, alpha);

        protected static Color Knob => new Color(0.96f, 0.96f, 0.97f);

        /// Fills the band between pairs of points, each with its colour at the bottom and at the top.
        internal static void FillBand(MeshGenerationContext context, int count, Func<int, (Vector2 bottom, Vector2 top, Color low, Color high)> pair)
        {
            if (count < 2) return;
            var mesh = context.Allocate(count * 2, (count - 1) * 6);
            for (var i = 0; i < count; i++)
            {
                var (bottom, top, low, high) = pair(i);
                mesh.SetNextVertex(new Vertex { position = new Vector3(bottom.x, bottom.y, Vertex.nearZ), tint = low });
                mesh.SetNextVertex(new Vertex { position = new Vector3(top.x, top.y, Vertex.nearZ), tint = high });
            }
            // Clockwise as they are seen; other triangles are not drawn.
            for (var i = 0; i + 1 < count; i++)
                foreach (var corner in quad)
                    mesh.SetNextIndex((ushort)(i * 2 + corner));
        }

        static readonly int[] quad = { 1, 3, 2, 1, 2, 0 };

        protected static void Line(Painter2D painter, Vector2 from, Vector2 to, Color color, float width)
        {
            painter.strokeColor = color;
            painter.lineWidth = width;
            painter.BeginPath();
            painter.MoveTo(from);
            painter.LineTo(to);
            painter.Stroke();
        }

        protected static void Disc(Painter2D painter, Vector2 center, float radius, Color color)
        {
            painter.fillColor = color;
            painter.BeginPath();
            painter.Arc(center, radius, 0, 360);
            painter.Fill();
        }

        protected static void Fill(Painter2D painter, Rect rect, Color color)
        {
            painter.fillColor = color;
            painter.BeginPath();
            painter.MoveTo(new Vector2(rect.xMin, rect.yMin));
            painter.LineTo(new Vector2(rect.xMax, rect.yMin));
            painter.LineTo(new Vector2(rect.xMax, rect.yMax));
            painter.LineTo(new Vector2(rect.xMin, rect.yMax));
            painter.ClosePath();
            painter.Fill();
        }
    }
}
