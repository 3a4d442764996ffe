using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>
    /// The light around, for volumes, in place of the scene's lighting settings: of an opened scene, or set by hand. Of several
    /// that are enabled the last one holds; a <see cref="LumivoxEffect"/> that says Studio goes before it.
    /// </summary>
    [ExecuteAlways, DisallowMultipleComponent, AddComponentMenu("Lumivox/Lumivox Environment")]
    public sealed class LumivoxEnvironment : MonoBehaviour
    {
        /// <summary>What it is.</summary>
        public enum Kind
        {
            /// <summary>One colour from everywhere.</summary>
            Uniform = 0,
            /// <summary>A gradient from straight up to straight down.</summary>
            Gradient = 1,
            /// <summary>Lumivox' studio.</summary>
            Studio = 2,
            /// <summary>A map.</summary>
            Map = 3,
        }

        [SerializeField, Tooltip("What the light is.")]
        Kind m_Kind = Kind.Studio;
        [SerializeField, ColorUsage(false, true), Tooltip("The one colour, or that from straight up.")]
        Color m_Zenith = Color.white;
        [SerializeField, ColorUsage(false, true), Tooltip("Of a gradient: from the horizon.")]
        Color m_Horizon = Color.white;
        [SerializeField, ColorUsage(false, true), Tooltip("Of a gradient: from straight down.")]
        Color m_Nadir = Color.white;
        [SerializeField, Tooltip("The map.")]
        LumivoxSky m_Sky;
        [SerializeField, Tooltip("Degrees that it turns about the vertical, as Rotation Y turns an object.")]
        float m_Rotation;
        [SerializeField, Min(0f), Tooltip("Multiplies the light.")]
        float m_Strength = 1f;

        static readonly List<LumivoxEnvironment> all = new List<LumivoxEnvironment>();

        /// <summary>What it is.</summary>
        public Kind kind
        {
            get => m_Kind;
            set
            {
                m_Kind = (Kind)Mathf.Clamp((int)value, 0, 3);
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>The one colour, or that from straight up; light above 1 is brighter than white.</summary>
        public Color zenith { get => m_Zenith; set => Put(ref m_Zenith, value); }

        /// <summary>Of a gradient: from the horizon.</summary>
        public Color horizon { get => m_Horizon; set => Put(ref m_Horizon, value); }

        /// <summary>Of a gradient: from straight down.</summary>
        public Color nadir { get => m_Nadir; set => Put(ref m_Nadir, value); }

        /// <summary>The map; without one it is dark.</summary>
        public LumivoxSky sky
        {
            get => m_Sky;
            set
            {
                m_Sky = value;
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>Degrees that it turns about the vertical, as an object's rotation about y does.</summary>
        public float rotation { get => m_Rotation; set => Put("rotation", ref m_Rotation, value, -1e6f, 1e6f); }

        /// <summary>Multiplies the light, 0 to 1e6.</summary>
        public float strength { get => m_Strength; set => Put("strength", ref m_Strength, value, 0f, 1e6f); }

        /// <summary>That of a world; null where its scene's own settings hold.</summary>
        internal static LumivoxEnvironment Of(in WorldKey key)
        {
            for (var i = all.Count - 1; i >= 0; i--)
                if (SceneVisibility.IsIn(all[i].gameObject, key)) return all[i];
            return null;
        }

        /// <summary>Tells it, as it is now, from others.</summary>
        internal ulong Number
        {
            get
            {
                var hash = EnvironmentReader.Mix(EnvironmentReader.Mix(EnvironmentReader.FirstHash, Identity.Of(this)), (int)m_Kind);
                hash = EnvironmentReader.Mix(EnvironmentReader.Mix(EnvironmentReader.Mix(hash, m_Zenith), m_Horizon), m_Nadir);
                return EnvironmentReader.Mix(EnvironmentReader.Mix(EnvironmentReader.Mix(hash, m_Rotation), m_Strength), Identity.Of(m_Sky));
            }
        }

        internal void Read(ref Surroundings surroundings)
        {
            surroundings.kind = (uint)m_Kind;
            surroundings.zenith = Numbers.Linear(m_Zenith);
            surroundings.horizon = Numbers.Linear(m_Horizon);
            surroundings.nadir = Numbers.Linear(m_Nadir);
            surroundings.rotation = m_Rotation * Mathf.Deg2Rad;
            surroundings.strength = m_Strength * EnvironmentReader.Radiance;
            surroundings.map = m_Kind == Kind.Map && m_Sky != null ? m_Sky.Pointer : System.IntPtr.Zero;
        }

        /// <summary>Takes over that of a scene document.</summary>
        internal void Take(in Surroundings surroundings, LumivoxSky of)
        {
            m_Kind = (Kind)surroundings.kind;
            m_Zenith = Gamma(surroundings.zenith);
            m_Horizon = Gamma(surroundings.horizon);
            m_Nadir = Gamma(surroundings.nadir);
            m_Rotation = surroundings.rotation * Mathf.Rad2Deg;
            m_Strength = surroundings.strength;
            m_Sky = of;
        }

        static Color Gamma(Vector3 linear) => new Color(linear.x, linear.y, linear.z, 1f).gamma;

        void Put(ref Color field, Color value)
        {
            if (!Numbers.Takes("LumivoxEnvironment's colours", Numbers.IsFinite(new Vector3(value.r, value.g, value.b)), this)) return;
            field = new Color(Mathf.Max(0f, value.r), Mathf.Max(0f, value.g), Mathf.Max(0f, value.b), 1f);
            LumivoxRuntime.RequestFrames();
        }

        void Put(string property, ref float field, float value, float low, float high)
        {
            if (!Numbers.Takes($"LumivoxEnvironment.{property}", Numbers.IsFinite(value), this)) return;
            field = Mathf.Clamp(value, low, high);
            LumivoxRuntime.RequestFrames();
        }

        void OnEnable()
        {
            if (LumivoxRuntime.IsMakingAssets) return;
            all.Add(this);
            LumivoxRuntime.RequestFrames();
        }

        void OnDisable()
        {
            all.Remove(this);
            LumivoxRuntime.RequestFrames();
        }

        void OnValidate()
        {
            m_Rotation = Numbers.Within(m_Rotation, -1e6f, 1e6f, 0f);
            m_Strength = Numbers.Within(m_Strength, 0f, 1e6f, 1f);
            LumivoxRuntime.RequestFrames();
        }
    }
}
