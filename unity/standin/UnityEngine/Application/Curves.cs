using System;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    [Serializable]
    public struct Keyframe
    {
        [SerializeField] float m_Time, m_Value, m_InTangent, m_OutTangent;
        public Keyframe(float time, float value) : this(time, value, 0, 0) { }
        public Keyframe(float time, float value, float inTangent, float outTangent) { m_Time = time; m_Value = value; m_InTangent = inTangent; m_OutTangent = outTangent; }
        public float time { get => m_Time; set => m_Time = value; }
        public float value { get => m_Value; set => m_Value = value; }
        public float inTangent { get => m_InTangent; set => m_InTangent = value; }
        public float outTangent { get => m_OutTangent; set => m_OutTangent = value; }
    }
    public enum WrapMode { Default = 0, Once = 1, Clamp = 1, Loop = 2, PingPong = 4, ClampForever = 8 }

    /// Hermite pieces without weights.
    [Serializable]
    public class AnimationCurve
    {
        [SerializeField] Keyframe[] m_Keys = new Keyframe[0];
        public AnimationCurve() { }
        public AnimationCurve(params Keyframe[] keys) => this.keys = keys;
        public Keyframe[] keys { get => (Keyframe[])m_Keys.Clone(); set => m_Keys = value.OrderBy(key => key.time).ToArray(); }
        public int length => m_Keys.Length;
        public Keyframe this[int index] => m_Keys[index];
        public int AddKey(float time, float value) { if (m_Keys.Any(key => key.time == time)) return -1; keys = m_Keys.Append(new Keyframe(time, value)).ToArray(); return Array.FindIndex(m_Keys, key => key.time == time); }
        public static AnimationCurve Linear(float timeStart, float valueStart, float timeEnd, float valueEnd) { var slope = (valueEnd - valueStart) / (timeEnd - timeStart); return new AnimationCurve(new Keyframe(timeStart, valueStart, slope, slope), new Keyframe(timeEnd, valueEnd, slope, slope)); }
        public static AnimationCurve EaseInOut(float timeStart, float valueStart, float timeEnd, float valueEnd) => new AnimationCurve(new Keyframe(timeStart, valueStart), new Keyframe(timeEnd, valueEnd));
        public static AnimationCurve Constant(float timeStart, float timeEnd, float value) => new AnimationCurve(new Keyframe(timeStart, value), new Keyframe(timeEnd, value));
        public float Evaluate(float time)
        {
            if (m_Keys.Length == 0) return 0;
            if (time <= m_Keys[0].time) return m_Keys[0].value;
            for (int i = 1; i < m_Keys.Length; i++)
            {
                Keyframe a = m_Keys[i - 1], b = m_Keys[i];
                if (time > b.time) continue;
                float d = b.time - a.time, t = (time - a.time) / d, t2 = t * t, t3 = t2 * t;
                return (2 * t3 - 3 * t2 + 1) * a.value + (t3 - 2 * t2 + t) * d * a.outTangent + (-2 * t3 + 3 * t2) * b.value + (t3 - t2) * d * b.inTangent;
            }
            return m_Keys[m_Keys.Length - 1].value;
        }
    }

    [Serializable] public struct GradientColorKey { public Color color; public float time; public GradientColorKey(Color col, float time) { this.color = col; this.time = time; } }
    [Serializable] public struct GradientAlphaKey { public float alpha, time; public GradientAlphaKey(float alpha, float time) { this.alpha = alpha; this.time = time; } }
    public enum GradientMode { Blend, Fixed, PerceptualBlend }
    public enum ColorSpace { Uninitialized = -1, Gamma = 0, Linear = 1 }

    [Serializable]
    public class Gradient
    {
        [SerializeField] GradientColorKey[] m_Colors = { new GradientColorKey(Color.white, 0), new GradientColorKey(Color.white, 1) };
        [SerializeField] GradientAlphaKey[] m_Alphas = { new GradientAlphaKey(1, 0), new GradientAlphaKey(1, 1) };
        public GradientMode mode { get; set; }
        public ColorSpace colorSpace { get; set; } = ColorSpace.Uninitialized;
        public GradientColorKey[] colorKeys { get => (GradientColorKey[])m_Colors.Clone(); set => SetKeys(value, m_Alphas); }
        public GradientAlphaKey[] alphaKeys { get => (GradientAlphaKey[])m_Alphas.Clone(); set => SetKeys(m_Colors, value); }
        public void SetKeys(GradientColorKey[] colorKeys, GradientAlphaKey[] alphaKeys)
        {
            if (colorKeys.Length > 8 || alphaKeys.Length > 8) Debug.LogError("Max 8 color and alpha keys are supported in a Gradient.");
            m_Colors = colorKeys.Take(8).OrderBy(key => key.time).ToArray();
            m_Alphas = alphaKeys.Take(8).OrderBy(key => key.time).ToArray();
        }
        public Color Evaluate(float time)
        {
            if (mode == GradientMode.PerceptualBlend) throw new NotImplementedException("the stand-in blends no gradients perceptually");
            var color = At(m_Colors.Length, i => m_Colors[i].time, (i, j, t) => Color.Lerp(m_Colors[i].color, m_Colors[j].color, t), time);
            color.a = At(m_Alphas.Length, i => m_Alphas[i].time, (i, j, t) => Color.white * Mathf.Lerp(m_Alphas[i].alpha, m_Alphas[j].alpha, t), time).r;
            return color;
        }
        Color At(int count, Func<int, float> time, Func<int, int, float, Color> mix, float at)
        {
            for (int i = 0; i < count; i++)
                if (at <= time(i)) return i == 0 ? mix(0, 0, 0) : mode == GradientMode.Fixed ? mix(i, i, 0) : mix(i - 1, i, (at - time(i - 1)) / (time(i) - time(i - 1)));
            return mix(count - 1, count - 1, 0);
        }
    }
}
