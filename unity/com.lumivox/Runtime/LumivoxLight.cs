using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>
    /// What of a light Unity's own component does not say, for volumes alone: how large it is, which makes its shadows soft, and
    /// how it falls off. Lights of opened scenes have one, so that they are the same in every pipeline.
    /// </summary>
    [ExecuteAlways, DisallowMultipleComponent, RequireComponent(typeof(Light)), AddComponentMenu("Lumivox/Lumivox Light")]
    public sealed class LumivoxLight : MonoBehaviour
    {
        /// <summary>How a lamp gets weaker with the distance.</summary>
        public enum Falloff
        {
            /// <summary>As the render pipeline has it.</summary>
            Pipeline = 0,
            /// <summary>By a power of the distance, ending smoothly at the light's range.</summary>
            Power = 1,
            /// <summary>As Unity's Built-in pipeline has it, whatever the pipeline.</summary>
            BuiltIn = 2,
        }

        [SerializeField, Min(0f), Tooltip("How large it is: the radius of a lamp in metres, that of a sun in degrees of the sky. 0: as the pipeline says, a point in most.")]
        float m_Radius;
        [SerializeField, Tooltip("How a lamp gets weaker with the distance.")]
        Falloff m_Falloff = Falloff.Pipeline;
        [SerializeField, Range(0.1f, 8f), Tooltip("With the falloff Power: the power of the distance. 2 is physical.")]
        float m_Decay = 2f;
        [SerializeField, Tooltip("With the falloff Power: the light's range does not end it.")]
        bool m_IsEndless;
        [SerializeField, Range(-1f, 179f), Tooltip("Degrees across within which a spot is as bright as on its axis. -1: as the pipeline says.")]
        float m_InnerSpotAngle = -1f;
        [SerializeField, Min(-1f), Tooltip("A spot falls off by this power of the way to its edge, as Godot's. -1: between the inner angle and the outer.")]
        float m_Attenuation = -1f;

        /// <summary>How large it is: the radius of a lamp in metres, that of a sun in degrees of the sky. 0: as the pipeline says.</summary>
        public float radius { get => m_Radius; set => Put("radius", ref m_Radius, value, 0f, 1e6f); }

        /// <summary>How a lamp gets weaker with the distance.</summary>
        public Falloff falloff
        {
            get => m_Falloff;
            set
            {
                m_Falloff = (Falloff)Mathf.Clamp((int)value, 0, 2);
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>With <see cref="Falloff.Power"/>: the power of the distance, 0.1 to 8. 2 is physical.</summary>
        public float decay { get => m_Decay; set => Put("decay", ref m_Decay, value, 0.1f, 8f); }

        /// <summary>With <see cref="Falloff.Power"/>: whether the light's range does not end it.</summary>
        public bool isEndless
        {
            get => m_IsEndless;
            set
            {
                m_IsEndless = value;
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>Degrees across within which a spot is as bright as on its axis; -1: as the pipeline says.</summary>
        public float innerSpotAngle { get => m_InnerSpotAngle; set => Put("innerSpotAngle", ref m_InnerSpotAngle, value, -1f, 179f); }

        /// <summary>A spot falls off by this power of the way to its edge, as Godot's; -1: between the inner angle and the outer.</summary>
        public float attenuation { get => m_Attenuation; set => Put("attenuation", ref m_Attenuation, value, -1f, 1000f); }

        internal void Adapt(ref LightSource source)
        {
            if (m_Radius > 0f) source.radius = source.kind == LightSource.Directional ? m_Radius * Mathf.Deg2Rad : m_Radius;
            if (m_Falloff == Falloff.BuiltIn) source.falloff = LightSource.BuiltIn;
            else if (m_Falloff == Falloff.Power)
            {
                source.falloff = LightSource.InverseSquare;
                source.decay = m_Decay;
                if (m_IsEndless) source.range = float.PositiveInfinity;
            }
            if (m_InnerSpotAngle >= 0f) source.innerHalfAngle = Mathf.Min(m_InnerSpotAngle * 0.5f * Mathf.Deg2Rad, source.outerHalfAngle);
            if (m_Attenuation < 0f) return;
            source.hasAttenuation = 1;
            source.attenuation = m_Attenuation;
        }

        /// <summary>Sets it so that a light is that of a scene document.</summary>
        internal void Take(in LightSource source)
        {
            m_Radius = source.kind == LightSource.Directional ? source.radius * Mathf.Rad2Deg : source.radius;
            m_Falloff = source.falloff == LightSource.BuiltIn ? Falloff.BuiltIn : Falloff.Power;
            m_Decay = source.decay > 0f ? source.decay : 2f;
            m_IsEndless = float.IsInfinity(source.range);
            m_InnerSpotAngle = source.kind == LightSource.Spot && source.hasAttenuation == 0 ? source.innerHalfAngle * 2f * Mathf.Rad2Deg : -1f;
            m_Attenuation = source.hasAttenuation != 0 ? source.attenuation : -1f;
        }

        void Put(string property, ref float field, float value, float low, float high)
        {
            if (!Numbers.Takes($"LumivoxLight.{property}", Numbers.IsFinite(value), this)) return;
            field = Mathf.Clamp(value, low, high);
            LumivoxRuntime.RequestFrames();
        }

        void OnEnable() => LumivoxRuntime.RequestFrames();

        void OnDisable() => LumivoxRuntime.RequestFrames();

        void OnValidate()
        {
            m_Radius = Numbers.Within(m_Radius, 0f, 1e6f, 0f);
            m_Decay = Numbers.Within(m_Decay, 0.1f, 8f, 2f);
            m_InnerSpotAngle = Numbers.Within(m_InnerSpotAngle, -1f, 179f, -1f);
            m_Attenuation = Numbers.Within(m_Attenuation, -1f, 1000f, -1f);
            LumivoxRuntime.RequestFrames();
        }
    }
}
