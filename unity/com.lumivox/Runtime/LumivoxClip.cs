using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>
    /// Cuts a <see cref="LumivoxVolume"/> open: of the scan, what the shape keeps is seen. It belongs to the nearest volume
    /// above it; up to <see cref="Most"/> may hang from one, moved and turned at will, and what each of them keeps is seen.
    /// </summary>
    /// <remarks>
    /// The cut shows tissue as it is inside, shaded as a surface. Labels of <see cref="LumivoxVolume.labels"/> can be spared:
    /// <see cref="LumivoxLabels.Look.clipped"/>.
    /// </remarks>
    [ExecuteAlways, AddComponentMenu("Lumivox/Lumivox Clip")]
    public sealed class LumivoxClip : MonoBehaviour
    {
        /// <summary>What is kept.</summary>
        public enum Shape
        {
            /// <summary>What lies on the side of the object's +y axis, whatever its scale.</summary>
            Plane = 0,
            /// <summary>What lies within a cube of one metre about the object's origin; its scale makes it a box.</summary>
            Box = 1,
            /// <summary>What lies within half a metre of the object's origin; its scale makes it an ellipsoid.</summary>
            Sphere = 2,
        }

        [SerializeField, Tooltip("What is kept: the side of the object's +y axis, what lies within a cube of one metre, or within a ball of one metre across, about its origin. Its transform moves, turns and scales it.")]
        Shape m_Shape;
        [SerializeField, Tooltip("Whether what the shape would keep is cut away, and the rest kept.")]
        bool m_Inverted;

        /// <summary>Of a volume's shapes, so many cut it.</summary>
        public const int Most = 1024;

        static readonly List<LumivoxClip> all = new List<LumivoxClip>();

        [NonSerialized] LumivoxVolume owner;

        /// <summary>Something that is seen, or warned of, is another.</summary>
        public event Action changed;

        /// <summary>What is kept.</summary>
        public Shape shape
        {
            get => m_Shape;
            set
            {
                m_Shape = (Shape)Mathf.Clamp((int)value, (int)Shape.Plane, (int)Shape.Sphere);
                Change();
            }
        }

        /// <summary>Whether what the shape would keep is cut away, and the rest kept.</summary>
        public bool inverted
        {
            get => m_Inverted;
            set
            {
                m_Inverted = value;
                Change();
            }
        }

        /// <summary>The volume that it cuts; null where there is none, or it is not enabled.</summary>
        public LumivoxVolume volume => owner != null ? owner : null;

        /// <summary>Why it cuts nothing, in sentences for people; empty where it does.</summary>
        public List<string> GetWarnings()
        {
            var warnings = new List<string>();
            if (isActiveAndEnabled && volume == null) warnings.Add("It cuts nothing: neither its object nor one above has a Lumivox Volume.");
            if (volume != null && volume.Clips.IndexOf(this) >= Most) warnings.Add($"It cuts nothing: {Most} shapes cut a volume at most.");
            var size = Mathf.Abs(transform.localToWorldMatrix.determinant);
            if (!(size > 0f) || float.IsInfinity(size)) warnings.Add("The object's scale is 0 along an axis, or not finite: it cuts nothing.");
            return warnings;
        }

        /// <summary>Writes shapes behind those that are there.</summary>
        internal static void Put(List<LumivoxClip> of, ref ClipShape[] into, ref int count)
        {
            if (into.Length < count + of.Count) Array.Resize(ref into, 2 * (count + of.Count));
            foreach (var clip in of)
            {
                into[count].worldFromShape = clip.transform.localToWorldMatrix;
                into[count].kind = (uint)clip.m_Shape;
                into[count].inverted = clip.m_Inverted ? 1u : 0u;
                count++;
            }
        }

        /// <summary>A volume came: shapes below it are its own.</summary>
        internal static void FindVolumes()
        {
            foreach (var clip in all) clip.Attach(clip.Above());
        }

        LumivoxVolume Above()
        {
            for (var at = transform; at != null; at = at.parent)
                if (at.TryGetComponent(out LumivoxVolume found)) return found;
            return null;
        }

        void Attach(LumivoxVolume to)
        {
            if (ReferenceEquals(owner, to)) return;
            // A volume that is gone has nothing to leave.
            if (!ReferenceEquals(owner, null)) owner.Clips.Remove(this);
            owner = to;
            if (!ReferenceEquals(owner, null)) owner.Clips.Add(this);
            Change();
        }

        void Change()
        {
            changed?.Invoke();
            LumivoxRuntime.RequestFrames();
        }

        void OnEnable()
        {
            if (LumivoxRuntime.IsMakingAssets) return;
            all.Add(this);
            Attach(Above());
        }

        void OnDisable()
        {
            all.Remove(this);
            Attach(null);
        }

        void OnTransformParentChanged()
        {
            if (isActiveAndEnabled) Attach(Above());
        }

        void OnValidate()
        {
            m_Shape = (Shape)Mathf.Clamp((int)m_Shape, (int)Shape.Plane, (int)Shape.Sphere);
            Change();
        }

#if UNITY_EDITOR
        static readonly Color faint = new Color(1f, 0.75f, 0.25f, 0.3f), strong = new Color(1f, 0.75f, 0.25f, 0.9f);

        void OnDrawGizmos() => Draw(faint);

        void OnDrawGizmosSelected() => Draw(strong);

        void Draw(Color color)
        {
            if (!isActiveAndEnabled) return;
            Gizmos.color = color;
            if (m_Shape == Shape.Plane)
            {
                // Its scale says nothing: it is drawn as large as the scan, with a line to the side that is kept.
                var size = Mathf.Max(0.05f, Reach);
                var kept = m_Inverted ? -0.5f : 0.5f;
                Gizmos.matrix = Matrix4x4.TRS(transform.position, transform.rotation, Vector3.one * size);
                Gizmos.DrawWireCube(Vector3.zero, new Vector3(1f, 0f, 1f));
                Gizmos.DrawLine(Vector3.zero, new Vector3(0f, kept, 0f));
                return;
            }
            Gizmos.matrix = transform.localToWorldMatrix;
            if (m_Shape == Shape.Box) Gizmos.DrawWireCube(Vector3.zero, Vector3.one);
            else Gizmos.DrawWireSphere(Vector3.zero, 0.5f);
        }

        /// How far the scan that it cuts reaches, in the scene's metres.
        float Reach => volume != null ? Mathf.Pow(Mathf.Abs(volume.transform.localToWorldMatrix.determinant), 1f / 3f) * volume.localBounds.size.magnitude : 0.2f;
#endif
    }
}
