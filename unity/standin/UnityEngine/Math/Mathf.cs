using System;

namespace UnityEngine
{
    public struct Mathf
    {
        public const float PI = (float)Math.PI;
        public const float Infinity = float.PositiveInfinity;
        public const float NegativeInfinity = float.NegativeInfinity;
        public const float Deg2Rad = PI / 180;
        public const float Rad2Deg = 57.29578f;
        public static readonly float Epsilon = float.Epsilon;
        public static float Sin(float f) => (float)Math.Sin(f);
        public static float Cos(float f) => (float)Math.Cos(f);
        public static float Tan(float f) => (float)Math.Tan(f);
        public static float Asin(float f) => (float)Math.Asin(f);
        public static float Acos(float f) => (float)Math.Acos(f);
        public static float Atan(float f) => (float)Math.Atan(f);
        public static float Atan2(float y, float x) => (float)Math.Atan2(y, x);
        public static float Sqrt(float f) => (float)Math.Sqrt(f);
        public static float Abs(float f) => Math.Abs(f);
        public static int Abs(int value) => Math.Abs(value);
        public static float Min(float a, float b) => a < b ? a : b;
        public static int Min(int a, int b) => a < b ? a : b;
        public static float Max(float a, float b) => a > b ? a : b;
        public static int Max(int a, int b) => a > b ? a : b;
        public static float Min(params float[] values) { if (values.Length == 0) return 0; var least = values[0]; foreach (var value in values) least = Min(least, value); return least; }
        public static float Max(params float[] values) { if (values.Length == 0) return 0; var most = values[0]; foreach (var value in values) most = Max(most, value); return most; }
        public static int Min(params int[] values) { if (values.Length == 0) return 0; var least = values[0]; foreach (var value in values) least = Min(least, value); return least; }
        public static int Max(params int[] values) { if (values.Length == 0) return 0; var most = values[0]; foreach (var value in values) most = Max(most, value); return most; }
        public static float Pow(float f, float p) => (float)Math.Pow(f, p);
        public static float Exp(float power) => (float)Math.Exp(power);
        public static float Log(float f) => (float)Math.Log(f);
        public static float Log(float f, float p) => (float)Math.Log(f, p);
        public static float Log10(float f) => (float)Math.Log10(f);
        public static float Ceil(float f) => (float)Math.Ceiling(f);
        public static float Floor(float f) => (float)Math.Floor(f);
        public static float Round(float f) => (float)Math.Round(f);
        public static int CeilToInt(float f) => (int)Math.Ceiling(f);
        public static int FloorToInt(float f) => (int)Math.Floor(f);
        public static int RoundToInt(float f) => (int)Math.Round(f);
        public static float Sign(float f) => f >= 0 ? 1 : -1;
        public static float Clamp(float value, float min, float max) => value < min ? min : value > max ? max : value;
        public static int Clamp(int value, int min, int max) => value < min ? min : value > max ? max : value;
        public static float Clamp01(float value) => Clamp(value, 0, 1);
        public static float Lerp(float a, float b, float t) => a + (b - a) * Clamp01(t);
        public static float LerpUnclamped(float a, float b, float t) => a + (b - a) * t;
        public static float InverseLerp(float a, float b, float value) => a != b ? Clamp01((value - a) / (b - a)) : 0;
        public static float SmoothStep(float from, float to, float t) { t = Clamp01(t); t = -2 * t * t * t + 3 * t * t; return to * t + from * (1 - t); }
        public static float MoveTowards(float current, float target, float maxDelta) => Abs(target - current) <= maxDelta ? target : current + Sign(target - current) * maxDelta;
        public static float Repeat(float t, float length) => Clamp(t - Floor(t / length) * length, 0, length);
        public static float DeltaAngle(float current, float target) { var delta = Repeat(target - current, 360); return delta > 180 ? delta - 360 : delta; }
        public static bool Approximately(float a, float b) => Abs(b - a) < Max(1e-6f * Max(Abs(a), Abs(b)), Epsilon * 8);
        public static int NextPowerOfTwo(int value) { var power = 1; while (power < value) power <<= 1; return power; }
        public static bool IsPowerOfTwo(int value) => (value & value - 1) == 0;
        public static float GammaToLinearSpace(float value) => value <= .04045f ? value / 12.92f : value < 1 ? Pow((value + .055f) / 1.055f, 2.4f) : Pow(value, 2.2f);
        public static float LinearToGammaSpace(float value) => value <= 0 ? 0 : value <= .0031308f ? 12.92f * value : value < 1 ? 1.055f * Pow(value, .4166667f) - .055f : Pow(value, .45454545f);
        public static ushort FloatToHalf(float val) => StandIn.Half.FromSingle(val);
        public static float HalfToFloat(ushort val) => StandIn.Half.ToSingle(val);

        /// The approximation after Krystek that lights with a temperature are known to use, as a linear colour.
        public static Color CorrelatedColorTemperatureToRGB(float kelvin)
        {
            double t = Math.Max(1000, Math.Min(40000, kelvin)) / 1000;
            double red = t < 6.57 ? 1 : Math.Max(0, 1.35651 + .216422 * t + .000633715 * t * t) / Math.Max(1e-9, -3.24223 + .918711 * t);
            double green = t < 6.57 ? (-399.809 + 414.271 * t + 111.543 * t * t) / (2779.24 + 164.143 * t + 84.7356 * t * t) : (1370.38 + 734.616 * t + .689955 * t * t) / (-4625.69 + 1699.87 * t);
            double blue = t < 6.57 ? (348.963 + -523.53 * t + 183.62 * t * t) / (2848.82 + -214.52 * t + 78.8614 * t * t) : 1;
            return new Color(Clamp01((float)red), Clamp01((float)green), Clamp01((float)blue), 1);
        }
    }
}
