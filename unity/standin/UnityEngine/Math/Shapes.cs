using System;
using System.Globalization;

namespace UnityEngine
{
    [Serializable]
    public struct Color : IEquatable<Color>
    {
        public float r, g, b, a;
        public Color(float r, float g, float b, float a) { this.r = r; this.g = g; this.b = b; this.a = a; }
        public Color(float r, float g, float b) : this(r, g, b, 1) { }
        public static Color white => new Color(1, 1, 1);
        public static Color black => new Color(0, 0, 0);
        public static Color red => new Color(1, 0, 0);
        public static Color green => new Color(0, 1, 0);
        public static Color blue => new Color(0, 0, 1);
        public static Color yellow => new Color(1, 235f / 255, 4f / 255);
        public static Color cyan => new Color(0, 1, 1);
        public static Color magenta => new Color(1, 0, 1);
        public static Color gray => new Color(.5f, .5f, .5f);
        public static Color grey => gray;
        public static Color clear => new Color(0, 0, 0, 0);
        public float this[int index]
        {
            get => index switch { 0 => r, 1 => g, 2 => b, 3 => a, _ => throw new IndexOutOfRangeException("Invalid Color index!") };
            set { if (index == 0) r = value; else if (index == 1) g = value; else if (index == 2) b = value; else if (index == 3) a = value; else throw new IndexOutOfRangeException("Invalid Color index!"); }
        }
        public float grayscale => .299f * r + .587f * g + .114f * b;
        public float maxColorComponent => Mathf.Max(Mathf.Max(r, g), b);
        public Color linear => new Color(Mathf.GammaToLinearSpace(r), Mathf.GammaToLinearSpace(g), Mathf.GammaToLinearSpace(b), a);
        public Color gamma => new Color(Mathf.LinearToGammaSpace(r), Mathf.LinearToGammaSpace(g), Mathf.LinearToGammaSpace(b), a);
        public static Color Lerp(Color a, Color b, float t) => LerpUnclamped(a, b, Mathf.Clamp01(t));
        public static Color LerpUnclamped(Color a, Color b, float t) => new Color(a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t, a.a + (b.a - a.a) * t);
        public static Color HSVToRGB(float H, float S, float V)
        {
            float Channel(float n) { var k = (n + H * 6) % 6; return V - V * S * Mathf.Max(0, Mathf.Min(Mathf.Min(k, 4 - k), 1)); }
            return new Color(Channel(5), Channel(3), Channel(1));
        }
        public static Color operator +(Color a, Color b) => new Color(a.r + b.r, a.g + b.g, a.b + b.b, a.a + b.a);
        public static Color operator -(Color a, Color b) => new Color(a.r - b.r, a.g - b.g, a.b - b.b, a.a - b.a);
        public static Color operator *(Color a, Color b) => new Color(a.r * b.r, a.g * b.g, a.b * b.b, a.a * b.a);
        public static Color operator *(Color a, float b) => new Color(a.r * b, a.g * b, a.b * b, a.a * b);
        public static Color operator *(float b, Color a) => a * b;
        public static Color operator /(Color a, float b) => new Color(a.r / b, a.g / b, a.b / b, a.a / b);
        public static bool operator ==(Color lhs, Color rhs) => (Vector4)lhs == (Vector4)rhs;
        public static bool operator !=(Color lhs, Color rhs) => !(lhs == rhs);
        public static implicit operator Vector4(Color c) => new Vector4(c.r, c.g, c.b, c.a);
        public static implicit operator Color(Vector4 v) => new Color(v.x, v.y, v.z, v.w);
        public bool Equals(Color other) => r.Equals(other.r) && g.Equals(other.g) && b.Equals(other.b) && a.Equals(other.a);
        public override bool Equals(object other) => other is Color color && Equals(color);
        public override int GetHashCode() => ((Vector4)this).GetHashCode();
        public override string ToString() => string.Format(CultureInfo.InvariantCulture, "RGBA({0:F3}, {1:F3}, {2:F3}, {3:F3})", r, g, b, a);
    }

    [Serializable]
    public struct Color32
#if UNITY_6000_0_OR_NEWER
        : IEquatable<Color32>
#endif
    {
        public byte r, g, b, a;
        public Color32(byte r, byte g, byte b, byte a) { this.r = r; this.g = g; this.b = b; this.a = a; }
        static byte Byte(float value) => (byte)Math.Round(Mathf.Clamp01(value) * 255);
        public static implicit operator Color32(Color c) => new Color32(Byte(c.r), Byte(c.g), Byte(c.b), Byte(c.a));
        public static implicit operator Color(Color32 c) => new Color(c.r / 255f, c.g / 255f, c.b / 255f, c.a / 255f);
        public bool Equals(Color32 other) => r == other.r && g == other.g && b == other.b && a == other.a;
        public override bool Equals(object other) => other is Color32 color && Equals(color);
        public override int GetHashCode() => r | g << 8 | b << 16 | a << 24;
        public override string ToString() => $"RGBA({r}, {g}, {b}, {a})";
    }

    [Serializable]
    public struct Bounds : IEquatable<Bounds>
    {
        [SerializeField] Vector3 m_Center, m_Extent;
        public Bounds(Vector3 center, Vector3 size) { m_Center = center; m_Extent = size * .5f; }
        public Vector3 center { get => m_Center; set => m_Center = value; }
        public Vector3 extents { get => m_Extent; set => m_Extent = value; }
        public Vector3 size { get => m_Extent * 2; set => m_Extent = value * .5f; }
        public Vector3 min { get => m_Center - m_Extent; set => SetMinMax(value, max); }
        public Vector3 max { get => m_Center + m_Extent; set => SetMinMax(min, value); }
        public void SetMinMax(Vector3 min, Vector3 max) { m_Extent = (max - min) * .5f; m_Center = min + m_Extent; }
        public void Encapsulate(Vector3 point) => SetMinMax(Vector3.Min(min, point), Vector3.Max(max, point));
        public void Encapsulate(Bounds bounds) { Encapsulate(bounds.min); Encapsulate(bounds.max); }
        public void Expand(float amount) => m_Extent += Vector3.one * (amount * .5f);
        public bool Contains(Vector3 point) { var d = point - m_Center; return Mathf.Abs(d.x) <= m_Extent.x && Mathf.Abs(d.y) <= m_Extent.y && Mathf.Abs(d.z) <= m_Extent.z; }
        public bool Intersects(Bounds bounds) { Vector3 l = min, h = max, m = bounds.min, n = bounds.max; return l.x <= n.x && h.x >= m.x && l.y <= n.y && h.y >= m.y && l.z <= n.z && h.z >= m.z; }
        public Vector3 ClosestPoint(Vector3 point) => Vector3.Max(min, Vector3.Min(max, point));
        public static bool operator ==(Bounds lhs, Bounds rhs) => lhs.m_Center == rhs.m_Center && lhs.m_Extent == rhs.m_Extent;
        public static bool operator !=(Bounds lhs, Bounds rhs) => !(lhs == rhs);
        public bool Equals(Bounds other) => m_Center.Equals(other.m_Center) && m_Extent.Equals(other.m_Extent);
        public override bool Equals(object other) => other is Bounds bounds && Equals(bounds);
        public override int GetHashCode() => m_Center.GetHashCode() ^ m_Extent.GetHashCode() << 2;
        public override string ToString() => $"Center: {m_Center}, Extents: {m_Extent}";
    }

    [Serializable]
    public struct Rect : IEquatable<Rect>
    {
        [SerializeField] float m_XMin, m_YMin, m_Width, m_Height;
        public Rect(float x, float y, float width, float height) { m_XMin = x; m_YMin = y; m_Width = width; m_Height = height; }
        public Rect(Vector2 position, Vector2 size) : this(position.x, position.y, size.x, size.y) { }
        public static Rect zero => new Rect(0, 0, 0, 0);
        public static Rect MinMaxRect(float xmin, float ymin, float xmax, float ymax) => new Rect(xmin, ymin, xmax - xmin, ymax - ymin);
        public float x { get => m_XMin; set => m_XMin = value; }
        public float y { get => m_YMin; set => m_YMin = value; }
        public float width { get => m_Width; set => m_Width = value; }
        public float height { get => m_Height; set => m_Height = value; }
        public float xMin { get => m_XMin; set { m_Width += m_XMin - value; m_XMin = value; } }
        public float yMin { get => m_YMin; set { m_Height += m_YMin - value; m_YMin = value; } }
        public float xMax { get => m_XMin + m_Width; set => m_Width = value - m_XMin; }
        public float yMax { get => m_YMin + m_Height; set => m_Height = value - m_YMin; }
        public Vector2 position { get => new Vector2(x, y); set { x = value.x; y = value.y; } }
        public Vector2 size { get => new Vector2(width, height); set { width = value.x; height = value.y; } }
        public Vector2 center { get => position + size / 2; set => position = value - size / 2; }
        public Vector2 min { get => position; set { xMin = value.x; yMin = value.y; } }
        public Vector2 max { get => new Vector2(xMax, yMax); set { xMax = value.x; yMax = value.y; } }
        public bool Contains(Vector2 point) => point.x >= xMin && point.x < xMax && point.y >= yMin && point.y < yMax;
        public bool Contains(Vector3 point) => Contains((Vector2)point);
        public bool Overlaps(Rect other) => other.xMax > xMin && other.xMin < xMax && other.yMax > yMin && other.yMin < yMax;
        public static bool operator ==(Rect lhs, Rect rhs) => lhs.Equals(rhs);
        public static bool operator !=(Rect lhs, Rect rhs) => !lhs.Equals(rhs);
        public bool Equals(Rect other) => x == other.x && y == other.y && width == other.width && height == other.height;
        public override bool Equals(object other) => other is Rect rect && Equals(rect);
        public override int GetHashCode() => x.GetHashCode() ^ width.GetHashCode() << 2 ^ y.GetHashCode() >> 2 ^ height.GetHashCode() >> 1;
        public override string ToString() => string.Format(CultureInfo.InvariantCulture, "(x:{0:F2}, y:{1:F2}, width:{2:F2}, height:{3:F2})", x, y, width, height);
    }

    [Serializable]
    public struct RectInt
    {
        [SerializeField] int m_XMin, m_YMin, m_Width, m_Height;
        public RectInt(int xMin, int yMin, int width, int height) { m_XMin = xMin; m_YMin = yMin; m_Width = width; m_Height = height; }
        public int x { get => m_XMin; set => m_XMin = value; }
        public int y { get => m_YMin; set => m_YMin = value; }
        public int width { get => m_Width; set => m_Width = value; }
        public int height { get => m_Height; set => m_Height = value; }
    }

    public struct Ray
    {
        Vector3 m_Direction;
        public Ray(Vector3 origin, Vector3 direction) { this.origin = origin; m_Direction = direction.normalized; }
        public Vector3 origin { get; set; }
        public Vector3 direction { get => m_Direction; set => m_Direction = value.normalized; }
        public Vector3 GetPoint(float distance) => origin + m_Direction * distance;
    }

    public struct Plane
    {
        public Plane(Vector3 inNormal, Vector3 inPoint) { this.normal = inNormal.normalized; distance = -Vector3.Dot(this.normal, inPoint); }
        public Plane(Vector3 inNormal, float d) { this.normal = inNormal.normalized; distance = d; }
        public Vector3 normal { get; set; }
        public float distance { get; set; }
        public float GetDistanceToPoint(Vector3 point) => Vector3.Dot(normal, point) + distance;
        public bool GetSide(Vector3 point) => GetDistanceToPoint(point) > 0;
        public bool Raycast(Ray ray, out float enter)
        {
            float along = Vector3.Dot(ray.direction, normal), from = -Vector3.Dot(ray.origin, normal) - distance;
            if (Mathf.Approximately(along, 0)) { enter = 0; return false; }
            enter = from / along;
            return enter > 0;
        }
    }
}
