using System;
using System.Globalization;

namespace UnityEngine
{
    [Serializable]
    public struct Quaternion : IEquatable<Quaternion>
    {
        public float x, y, z, w;
        public Quaternion(float x, float y, float z, float w) { this.x = x; this.y = y; this.z = z; this.w = w; }
        public static Quaternion identity => new Quaternion(0, 0, 0, 1);
        public Quaternion normalized { get { var n = (float)Math.Sqrt(Dot(this, this)); return n < Mathf.Epsilon ? identity : new Quaternion(x / n, y / n, z / n, w / n); } }
        public void Normalize() => this = normalized;
        public static Quaternion Normalize(Quaternion q) => q.normalized;
        public static float Dot(Quaternion a, Quaternion b) => a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
        public static Quaternion Inverse(Quaternion rotation) => new Quaternion(-rotation.x, -rotation.y, -rotation.z, rotation.w);
        public static Quaternion AngleAxis(float angle, Vector3 axis)
        {
            axis = axis.normalized;
            float half = angle * Mathf.Deg2Rad / 2, sine = Mathf.Sin(half);
            return new Quaternion(axis.x * sine, axis.y * sine, axis.z * sine, Mathf.Cos(half));
        }
        /// Z, then x, then y, in degrees.
        public static Quaternion Euler(float x, float y, float z) => AngleAxis(y, Vector3.up) * AngleAxis(x, Vector3.right) * AngleAxis(z, Vector3.forward);
        public static Quaternion Euler(Vector3 euler) => Euler(euler.x, euler.y, euler.z);
        public Vector3 eulerAngles
        {
            get
            {
                var m = Matrix4x4.Rotate(this);
                float sine = Mathf.Clamp(-m.m12, -1, 1), pitch = Mathf.Asin(sine), yaw, roll;
                if (Mathf.Abs(sine) < .99999f) { yaw = Mathf.Atan2(m.m02, m.m22); roll = Mathf.Atan2(m.m10, m.m11); }
                else { yaw = Mathf.Atan2(-m.m20, m.m00); roll = 0; }
                return new Vector3(Mathf.Repeat(pitch * Mathf.Rad2Deg, 360), Mathf.Repeat(yaw * Mathf.Rad2Deg, 360), Mathf.Repeat(roll * Mathf.Rad2Deg, 360));
            }
            set => this = Euler(value);
        }
        public static Quaternion LookRotation(Vector3 forward) => LookRotation(forward, Vector3.up);
        public static Quaternion LookRotation(Vector3 forward, Vector3 upwards)
        {
            var z = forward.normalized;
            if (z == Vector3.zero) { Debug.Log("Look rotation viewing vector is zero"); return identity; }
            var x = Vector3.Cross(upwards, z).normalized;
            if (x == Vector3.zero) x = Vector3.Cross(Mathf.Abs(z.y) > .9f ? Vector3.forward : Vector3.up, z).normalized;
            var y = Vector3.Cross(z, x);
            var m = Matrix4x4.identity;
            m.SetColumn(0, x); m.SetColumn(1, y); m.SetColumn(2, z);
            return m.rotation;
        }
        public static Quaternion FromToRotation(Vector3 fromDirection, Vector3 toDirection)
        {
            fromDirection = fromDirection.normalized; toDirection = toDirection.normalized;
            var cosine = Vector3.Dot(fromDirection, toDirection);
            if (cosine > .999999f) return identity;
            if (cosine < -.999999f) { var axis = Vector3.Cross(fromDirection, Mathf.Abs(fromDirection.x) < .9f ? Vector3.right : Vector3.up); return AngleAxis(180, axis); }
            return AngleAxis(Mathf.Acos(cosine) * Mathf.Rad2Deg, Vector3.Cross(fromDirection, toDirection));
        }
        public static float Angle(Quaternion a, Quaternion b) { var dot = Mathf.Min(Mathf.Abs(Dot(a, b)), 1); return dot > 1 - 1e-6f ? 0 : Mathf.Acos(dot) * 2 * Mathf.Rad2Deg; }
        public static Quaternion Slerp(Quaternion a, Quaternion b, float t)
        {
            t = Mathf.Clamp01(t);
            var cosine = Dot(a, b);
            if (cosine < 0) { b = new Quaternion(-b.x, -b.y, -b.z, -b.w); cosine = -cosine; }
            float angle = Mathf.Acos(Mathf.Min(cosine, 1)), sine = Mathf.Sin(angle);
            float p = sine < 1e-4f ? 1 - t : Mathf.Sin((1 - t) * angle) / sine, q = sine < 1e-4f ? t : Mathf.Sin(t * angle) / sine;
            return new Quaternion(a.x * p + b.x * q, a.y * p + b.y * q, a.z * p + b.z * q, a.w * p + b.w * q).normalized;
        }
        public static Quaternion Lerp(Quaternion a, Quaternion b, float t) => Slerp(a, b, t);
        public static Quaternion operator *(Quaternion lhs, Quaternion rhs) => new Quaternion(
            lhs.w * rhs.x + lhs.x * rhs.w + lhs.y * rhs.z - lhs.z * rhs.y, lhs.w * rhs.y + lhs.y * rhs.w + lhs.z * rhs.x - lhs.x * rhs.z,
            lhs.w * rhs.z + lhs.z * rhs.w + lhs.x * rhs.y - lhs.y * rhs.x, lhs.w * rhs.w - lhs.x * rhs.x - lhs.y * rhs.y - lhs.z * rhs.z);
        public static Vector3 operator *(Quaternion rotation, Vector3 point)
        {
            var axis = new Vector3(rotation.x, rotation.y, rotation.z);
            var t = 2 * Vector3.Cross(axis, point);
            return point + rotation.w * t + Vector3.Cross(axis, t);
        }
        public static bool operator ==(Quaternion lhs, Quaternion rhs) => Dot(lhs, rhs) > .999999f;
        public static bool operator !=(Quaternion lhs, Quaternion rhs) => !(lhs == rhs);
        public bool Equals(Quaternion other) => x.Equals(other.x) && y.Equals(other.y) && z.Equals(other.z) && w.Equals(other.w);
        public override bool Equals(object other) => other is Quaternion quaternion && Equals(quaternion);
        public override int GetHashCode() => x.GetHashCode() ^ y.GetHashCode() << 2 ^ z.GetHashCode() >> 2 ^ w.GetHashCode() >> 1;
        public override string ToString() => string.Format(CultureInfo.InvariantCulture, "({0:F5}, {1:F5}, {2:F5}, {3:F5})", x, y, z, w);
    }

    /// Elements are named by row and column and lie column by column.
    [Serializable]
    public struct Matrix4x4 : IEquatable<Matrix4x4>
    {
        public float m00, m10, m20, m30, m01, m11, m21, m31, m02, m12, m22, m32, m03, m13, m23, m33;
        public Matrix4x4(Vector4 column0, Vector4 column1, Vector4 column2, Vector4 column3) : this() { SetColumn(0, column0); SetColumn(1, column1); SetColumn(2, column2); SetColumn(3, column3); }
        public static Matrix4x4 identity { get { var m = new Matrix4x4(); m.m00 = m.m11 = m.m22 = m.m33 = 1; return m; } }
        public static Matrix4x4 zero => new Matrix4x4();
        public float this[int row, int column] { get => this[row + column * 4]; set => this[row + column * 4] = value; }
        public unsafe float this[int index]
        {
            get { if ((uint)index > 15) throw new IndexOutOfRangeException("Invalid matrix index!"); fixed (float* p = &m00) return p[index]; }
            set { if ((uint)index > 15) throw new IndexOutOfRangeException("Invalid matrix index!"); fixed (float* p = &m00) p[index] = value; }
        }
        public Vector4 GetColumn(int index) => new Vector4(this[0, index], this[1, index], this[2, index], this[3, index]);
        public Vector4 GetRow(int index) => new Vector4(this[index, 0], this[index, 1], this[index, 2], this[index, 3]);
        public Vector3 GetPosition() => new Vector3(m03, m13, m23);
        public void SetColumn(int index, Vector4 column) { for (int r = 0; r < 4; r++) this[r, index] = column[r]; }
        public void SetRow(int index, Vector4 row) { for (int c = 0; c < 4; c++) this[index, c] = row[c]; }
        public void SetTRS(Vector3 pos, Quaternion q, Vector3 s) => this = TRS(pos, q, s);
        public bool isIdentity => this == identity;
        public static Matrix4x4 Translate(Vector3 vector) { var m = identity; m.SetColumn(3, new Vector4(vector.x, vector.y, vector.z, 1)); return m; }
        public static Matrix4x4 Scale(Vector3 vector) { var m = identity; m.m00 = vector.x; m.m11 = vector.y; m.m22 = vector.z; return m; }
        public static Matrix4x4 Rotate(Quaternion q)
        {
            var m = identity;
            m.SetColumn(0, q * Vector3.right); m.SetColumn(1, q * Vector3.up); m.SetColumn(2, q * Vector3.forward);
            return m;
        }
        public static Matrix4x4 TRS(Vector3 pos, Quaternion q, Vector3 s)
        {
            var m = identity;
            m.SetColumn(0, q * Vector3.right * s.x); m.SetColumn(1, q * Vector3.up * s.y); m.SetColumn(2, q * Vector3.forward * s.z);
            m.SetColumn(3, new Vector4(pos.x, pos.y, pos.z, 1));
            return m;
        }
        /// As OpenGL has it: looks along -z, depth from -1 to 1.
        public static Matrix4x4 Perspective(float fov, float aspect, float zNear, float zFar)
        {
            var m = new Matrix4x4();
            float cotangent = 1 / Mathf.Tan(fov * Mathf.Deg2Rad / 2);
            m.m00 = cotangent / aspect; m.m11 = cotangent; m.m22 = -(zFar + zNear) / (zFar - zNear); m.m23 = -2 * zFar * zNear / (zFar - zNear); m.m32 = -1;
            return m;
        }
        public static Matrix4x4 Ortho(float left, float right, float bottom, float top, float zNear, float zFar)
        {
            var m = identity;
            m.m00 = 2 / (right - left); m.m11 = 2 / (top - bottom); m.m22 = -2 / (zFar - zNear);
            m.m03 = -(right + left) / (right - left); m.m13 = -(top + bottom) / (top - bottom); m.m23 = -(zFar + zNear) / (zFar - zNear);
            return m;
        }
        public static Matrix4x4 Frustum(float left, float right, float bottom, float top, float zNear, float zFar)
        {
            var m = new Matrix4x4();
            m.m00 = 2 * zNear / (right - left); m.m11 = 2 * zNear / (top - bottom); m.m02 = (right + left) / (right - left); m.m12 = (top + bottom) / (top - bottom);
            m.m22 = -(zFar + zNear) / (zFar - zNear); m.m23 = -2 * zFar * zNear / (zFar - zNear); m.m32 = -1;
            return m;
        }
        public static Matrix4x4 LookAt(Vector3 from, Vector3 to, Vector3 up) => TRS(from, Quaternion.LookRotation(to - from, up), Vector3.one);
        public float determinant
        {
            get
            {
                double s0 = (double)m00 * m11 - (double)m10 * m01, s1 = (double)m00 * m12 - (double)m10 * m02, s2 = (double)m00 * m13 - (double)m10 * m03;
                double s3 = (double)m01 * m12 - (double)m11 * m02, s4 = (double)m01 * m13 - (double)m11 * m03, s5 = (double)m02 * m13 - (double)m12 * m03;
                double c5 = (double)m22 * m33 - (double)m32 * m23, c4 = (double)m21 * m33 - (double)m31 * m23, c3 = (double)m21 * m32 - (double)m31 * m22;
                double c2 = (double)m20 * m33 - (double)m30 * m23, c1 = (double)m20 * m32 - (double)m30 * m22, c0 = (double)m20 * m31 - (double)m30 * m21;
                return (float)(s0 * c5 - s1 * c4 + s2 * c3 + s3 * c2 - s4 * c1 + s5 * c0);
            }
        }
        public unsafe Matrix4x4 inverse
        {
            get
            {
                // Gauss-Jordan in doubles, rows of eight; a singular matrix has zeros for its inverse.
                var a = stackalloc double[32];
                for (int r = 0; r < 4; r++) for (int c = 0; c < 4; c++) { a[r * 8 + c] = this[r, c]; a[r * 8 + c + 4] = r == c ? 1 : 0; }
                for (int c = 0; c < 4; c++)
                {
                    int pivot = c;
                    for (int r = c + 1; r < 4; r++) if (Math.Abs(a[r * 8 + c]) > Math.Abs(a[pivot * 8 + c])) pivot = r;
                    if (Math.Abs(a[pivot * 8 + c]) < 1e-30) return zero;
                    for (int k = 0; k < 8; k++) { var swap = a[c * 8 + k]; a[c * 8 + k] = a[pivot * 8 + k]; a[pivot * 8 + k] = swap; }
                    double by = a[c * 8 + c];
                    for (int k = 0; k < 8; k++) a[c * 8 + k] /= by;
                    for (int r = 0; r < 4; r++)
                    {
                        double factor = a[r * 8 + c];
                        if (r != c && factor != 0) for (int k = 0; k < 8; k++) a[r * 8 + k] -= factor * a[c * 8 + k];
                    }
                }
                var m = new Matrix4x4();
                for (int r = 0; r < 4; r++) for (int c = 0; c < 4; c++) m[r, c] = (float)a[r * 8 + c + 4];
                return m;
            }
        }
        public static Matrix4x4 Inverse(Matrix4x4 m) => m.inverse;
        public Matrix4x4 transpose { get { var m = new Matrix4x4(); for (int r = 0; r < 4; r++) for (int c = 0; c < 4; c++) m[r, c] = this[c, r]; return m; } }
        public static Matrix4x4 Transpose(Matrix4x4 m) => m.transpose;
        public Vector3 lossyScale
        {
            get
            {
                var scale = new Vector3(((Vector3)GetColumn(0)).magnitude, ((Vector3)GetColumn(1)).magnitude, ((Vector3)GetColumn(2)).magnitude);
                if (determinant < 0) scale.x = -scale.x;
                return scale;
            }
        }
        public Quaternion rotation
        {
            get
            {
                Vector3 scale = lossyScale, x = (Vector3)GetColumn(0) / scale.x, y = (Vector3)GetColumn(1) / scale.y, z = (Vector3)GetColumn(2) / scale.z;
                float trace = x.x + y.y + z.z;
                if (trace > 0) { float s = Mathf.Sqrt(trace + 1) * 2; return new Quaternion((y.z - z.y) / s, (z.x - x.z) / s, (x.y - y.x) / s, s / 4).normalized; }
                if (x.x > y.y && x.x > z.z) { float s = Mathf.Sqrt(1 + x.x - y.y - z.z) * 2; return new Quaternion(s / 4, (y.x + x.y) / s, (z.x + x.z) / s, (y.z - z.y) / s).normalized; }
                if (y.y > z.z) { float s = Mathf.Sqrt(1 + y.y - x.x - z.z) * 2; return new Quaternion((y.x + x.y) / s, s / 4, (z.y + y.z) / s, (z.x - x.z) / s).normalized; }
                { float s = Mathf.Sqrt(1 + z.z - x.x - y.y) * 2; return new Quaternion((z.x + x.z) / s, (z.y + y.z) / s, s / 4, (x.y - y.x) / s).normalized; }
            }
        }
        public Vector3 MultiplyPoint3x4(Vector3 point) => new Vector3(m00 * point.x + m01 * point.y + m02 * point.z + m03, m10 * point.x + m11 * point.y + m12 * point.z + m13, m20 * point.x + m21 * point.y + m22 * point.z + m23);
        public Vector3 MultiplyPoint(Vector3 point) => MultiplyPoint3x4(point) / (m30 * point.x + m31 * point.y + m32 * point.z + m33);
        public Vector3 MultiplyVector(Vector3 vector) => new Vector3(m00 * vector.x + m01 * vector.y + m02 * vector.z, m10 * vector.x + m11 * vector.y + m12 * vector.z, m20 * vector.x + m21 * vector.y + m22 * vector.z);
        public static Matrix4x4 operator *(Matrix4x4 lhs, Matrix4x4 rhs)
        {
            var m = new Matrix4x4();
            for (int r = 0; r < 4; r++) for (int c = 0; c < 4; c++) m[r, c] = lhs[r, 0] * rhs[0, c] + lhs[r, 1] * rhs[1, c] + lhs[r, 2] * rhs[2, c] + lhs[r, 3] * rhs[3, c];
            return m;
        }
        public static Vector4 operator *(Matrix4x4 lhs, Vector4 vector) => new Vector4(Vector4.Dot(lhs.GetRow(0), vector), Vector4.Dot(lhs.GetRow(1), vector), Vector4.Dot(lhs.GetRow(2), vector), Vector4.Dot(lhs.GetRow(3), vector));
        public static bool operator ==(Matrix4x4 lhs, Matrix4x4 rhs) => lhs.GetColumn(0) == rhs.GetColumn(0) && lhs.GetColumn(1) == rhs.GetColumn(1) && lhs.GetColumn(2) == rhs.GetColumn(2) && lhs.GetColumn(3) == rhs.GetColumn(3);
        public static bool operator !=(Matrix4x4 lhs, Matrix4x4 rhs) => !(lhs == rhs);
        public bool Equals(Matrix4x4 other) { for (int i = 0; i < 16; i++) if (!this[i].Equals(other[i])) return false; return true; }
        public override bool Equals(object other) => other is Matrix4x4 matrix && Equals(matrix);
        public override int GetHashCode() => GetColumn(0).GetHashCode() ^ GetColumn(1).GetHashCode() << 2 ^ GetColumn(2).GetHashCode() >> 2 ^ GetColumn(3).GetHashCode() >> 1;
        public override string ToString() => $"{GetRow(0)}\n{GetRow(1)}\n{GetRow(2)}\n{GetRow(3)}\n";
    }
}
