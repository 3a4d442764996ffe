using UnityEngine;

namespace Lumivox
{
    /// <summary>
    /// What holds in a whole project: how volumes are drawn where no <see cref="LumivoxEffect"/> says otherwise, and how
    /// much of the GPU's memory they may fill. An asset named `LumivoxProjectSettings` in a `Resources` folder.
    /// </summary>
    [CreateAssetMenu(menuName = "Lumivox/Project Settings", fileName = ResourceName, order = 320)]
    public sealed class LumivoxProjectSettings : ScriptableObject
    {
        /// <summary>The name under which it is looked for in `Resources`.</summary>
        public const string ResourceName = "LumivoxProjectSettings";

        [SerializeField, Tooltip("How volumes are drawn where no Lumivox Effect says otherwise.")]
        LumivoxSettings m_Effect = LumivoxSettings.Default;
        [SerializeField, Min(0), Tooltip("Megabytes of the GPU's memory that voxels may fill, with the light that is kept in them. Scans that do not fit are shown at a lower resolution; light has what they leave. 0: as many as there is room for.")]
        int m_VoxelMegabytes;

        static LumivoxProjectSettings current;
        static bool isLooked;

        /// <summary>How volumes are drawn where no effect says otherwise.</summary>
        public LumivoxSettings effect
        {
            get => m_Effect;
            set
            {
                m_Effect = value.Clamped();
                LumivoxRuntime.RequestFrames();
            }
        }

        /// <summary>Megabytes of the GPU's memory that voxels may fill, with the light that is kept in them; 0: as many as there is room for. It counts when volumes are drawn for the first time.</summary>
        public int voxelMegabytes
        {
            get => m_VoxelMegabytes;
            set => m_VoxelMegabytes = Mathf.Max(0, value);
        }

        /// <summary>The project's; null where it has none.</summary>
        public static LumivoxProjectSettings Current
        {
            get
            {
                if (!isLooked)
                {
                    isLooked = true;
                    current = Resources.Load<LumivoxProjectSettings>(ResourceName);
                }
                return current;
            }
        }

        internal static LumivoxSettings Effect => Current != null ? Current.m_Effect : LumivoxSettings.Default;

        void OnEnable() => isLooked = false;

        void OnValidate()
        {
            m_Effect = m_Effect.Clamped();
            isLooked = false;
            LumivoxRuntime.RequestFrames();
        }
    }
}
