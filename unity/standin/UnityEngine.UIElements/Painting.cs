// Drawing of visual elements, recorded so that tests can look at it.
using System;
using System.Collections.Generic;

namespace UnityEngine.UIElements
{
    public enum LineCap { Butt, Round }
    public enum LineJoin { Miter, Bevel, Round }
    public enum FillRule { NonZero, OddEven }
    public enum ArcDirection { Clockwise, CounterClockwise }
    public enum AngleUnit { Degree, Gradian, Radian, Turn }

    public struct Angle
    {
        public float value { get; set; }
        public AngleUnit unit { get; set; }
        public Angle(float value) : this(value, AngleUnit.Degree) { }
        public Angle(float value, AngleUnit unit) { this.value = value; this.unit = unit; }
        public static Angle Degrees(float value) => new Angle(value);
        public static implicit operator Angle(float value) => new Angle(value);
    }

    /// Paths, filled or stroked. What was drawn is in `standInShapes`.
    public class Painter2D
    {
        internal readonly List<StandIn.Shape> shapes;
        List<Vector2> path = new List<Vector2>();
        bool begun;

        internal Painter2D(List<StandIn.Shape> shapes) { this.shapes = shapes; }
        public float lineWidth { get; set; } = 1;
        public Color strokeColor { get; set; } = Color.black;
        public Color fillColor { get; set; } = Color.black;
        public LineCap lineCap { get; set; }
        public LineJoin lineJoin { get; set; }
        public float miterLimit { get; set; } = 10;
        public void BeginPath() { path = new List<Vector2>(); begun = true; }
        public void MoveTo(Vector2 pos) => Put(pos);
        public void LineTo(Vector2 pos) => Put(pos);
        public void ClosePath() { if (path.Count > 0) path.Add(path[0]); }
        public void Arc(Vector2 center, float radius, Angle startAngle, Angle endAngle, ArcDirection direction = ArcDirection.Clockwise)
        {
            for (var i = 0; i <= 16; i++)
            {
                var at = (startAngle.value + (endAngle.value - startAngle.value) * i / 16) * Math.PI / 180;
                Put(center + radius * new Vector2((float)Math.Cos(at), (float)Math.Sin(at)));
            }
        }
        public void Stroke() => End(false, strokeColor);
        public void Fill(FillRule fillRule = FillRule.NonZero) => End(true, fillColor);

        void Put(Vector2 at)
        {
            if (!begun) throw new InvalidOperationException("Painter2D: BeginPath was not called");
            if (float.IsNaN(at.x) || float.IsNaN(at.y) || float.IsInfinity(at.x) || float.IsInfinity(at.y)) throw new ArgumentException($"Painter2D: {at} is no point");
            path.Add(at);
        }

        void End(bool filled, Color color) => shapes.Add(new StandIn.Shape { Points = path.ToArray(), IsFilled = filled, Color = color, Width = lineWidth });
    }

    public struct Vertex
    {
        public static readonly float nearZ = 0;
        public Vector3 position;
        public Color32 tint;
        public Vector2 uv;
    }

    public class MeshWriteData
    {
        readonly Vertex[] vertices;
        readonly ushort[] indices;
        int nextVertex, nextIndex;
        internal MeshWriteData(StandIn.Shape shape, int vertexCount, int indexCount)
        {
            vertices = shape.Vertices = new Vertex[vertexCount];
            indices = shape.Indices = new ushort[indexCount];
        }
        public int vertexCount => vertices.Length;
        public int indexCount => indices.Length;
        public void SetNextVertex(Vertex vertex) => vertices[nextVertex++] = vertex;
        public void SetNextIndex(ushort index)
        {
            if (index >= vertices.Length) throw new ArgumentException($"MeshWriteData: index {index} of {vertices.Length} vertices");
            indices[nextIndex++] = index;
        }
        internal bool IsFull => nextVertex == vertices.Length && nextIndex == indices.Length;
    }

    public class MeshGenerationContext
    {
        readonly List<MeshWriteData> meshes = new List<MeshWriteData>();
        internal readonly List<StandIn.Shape> shapes = new List<StandIn.Shape>();
        internal MeshGenerationContext(VisualElement element) { visualElement = element; painter2D = new Painter2D(shapes); }
        public VisualElement visualElement { get; }
        public Painter2D painter2D { get; }
        public MeshWriteData Allocate(int vertexCount, int indexCount, Texture texture = null)
        {
            if (vertexCount > 65535) throw new ArgumentOutOfRangeException(nameof(vertexCount));
            var shape = new StandIn.Shape { IsFilled = true };
            shapes.Add(shape);
            var mesh = new MeshWriteData(shape, vertexCount, indexCount);
            meshes.Add(mesh);
            return mesh;
        }
        internal void Finish()
        {
            foreach (var mesh in meshes)
                if (!mesh.IsFull) throw new InvalidOperationException("MeshGenerationContext: fewer vertices or indices were written than allocated");
        }
    }
}
namespace StandIn
{
    /// Something that an element drew.
    public sealed class Shape
    {
        public UnityEngine.Vector2[] Points = Array.Empty<UnityEngine.Vector2>();
        public UnityEngine.UIElements.Vertex[] Vertices = Array.Empty<UnityEngine.UIElements.Vertex>();
        public ushort[] Indices = Array.Empty<ushort>();
        public UnityEngine.Color Color;
        public float Width;
        public bool IsFilled;
    }
}
