// Handles and gizmos of the scene view: what was drawn is noted, and a test's hand drags the box's handles.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace UnityEditor
{
    public sealed class Handles
    {
        public delegate float SizeFunction(Vector3 position);
        public static Matrix4x4 matrix { get; set; } = Matrix4x4.identity;
        public static Color color { get; set; } = Color.white;
        public static void DrawWireCube(Vector3 center, Vector3 size) => StandIn.SceneHands.Boxes.Add((matrix, center, size, color));
        public static void DrawLine(Vector3 p1, Vector3 p2) => StandIn.SceneHands.Lines++;
        public static void Label(Vector3 position, string text)
        {
            StandIn.SceneHands.Labels.Add(text);
            StandIn.SceneHands.Places.Add((matrix.MultiplyPoint3x4(position), text));
        }
        public static void Label(Vector3 position, string text, GUIStyle style) => Label(position, text);

        public struct DrawingScope : IDisposable
        {
            readonly Color originalColor;
            readonly Matrix4x4 originalMatrix;
            public DrawingScope(Matrix4x4 matrix) : this(Handles.color, matrix) { }
            public DrawingScope(Color color) : this(color, Handles.matrix) { }
            public DrawingScope(Color color, Matrix4x4 matrix)
            {
                originalColor = Handles.color;
                originalMatrix = Handles.matrix;
                Handles.color = color;
                Handles.matrix = matrix;
            }
            public void Dispose()
            {
                Handles.color = originalColor;
                Handles.matrix = originalMatrix;
            }
        }
    }

    public sealed class HandleUtility
    {
        public static float GetHandleSize(Vector3 position) => 1;
    }
}

namespace UnityEditor.IMGUI.Controls
{
    public abstract class PrimitiveBoundsHandle
    {
        [Flags] public enum Axes { None = 0, X = 1, Y = 2, Z = 4, All = X | Y | Z }
        public Axes axes { get; set; } = Axes.All;
        public Vector3 center { get; set; }
        public Color handleColor { get; set; } = Color.white;
        public Color wireframeColor { get; set; } = Color.white;
        public Handles.SizeFunction midpointHandleSizeFunction { get; set; }
        public void SetColor(Color color) { handleColor = wireframeColor = color; }
        internal Vector3 extent;
        public PrimitiveBoundsHandle() { }
        protected Vector3 GetSize() => extent;
        protected void SetSize(Vector3 size) => extent = size;
        public void DrawHandle()
        {
            StandIn.SceneHands.Boxes.Add((Handles.matrix, center, extent, wireframeColor));
            if (StandIn.SceneHands.Drag == null) return;
            var low = center - extent * 0.5f;
            var high = center + extent * 0.5f;
            StandIn.SceneHands.Drag(ref low, ref high);
            StandIn.SceneHands.Drag = null;
            center = (low + high) * 0.5f;
            extent = high - low;
            EditorGUI.Change();
        }
    }

    public class BoxBoundsHandle : PrimitiveBoundsHandle
    {
        public Vector3 size { get => GetSize(); set => SetSize(value); }
    }
}

namespace StandIn
{
    public static class SceneHands
    {
        public delegate void Hand(ref Vector3 low, ref Vector3 high);
        public static readonly List<(Matrix4x4 matrix, Vector3 center, Vector3 size, Color color)> Boxes = new List<(Matrix4x4, Vector3, Vector3, Color)>();
        public static readonly List<string> Labels = new List<string>();
        /// Where labels are in the world.
        public static readonly List<(Vector3 position, string text)> Places = new List<(Vector3, string)>();
        public static int Lines;
        public static void Clear()
        {
            Boxes.Clear();
            Labels.Clear();
            Places.Clear();
            Lines = 0;
        }
        /// Drags the next box that has handles.
        public static Hand Drag;
    }
}
