namespace Lumivox.Editor
{
    /// <summary>Scans that a transfer function is seen on.</summary>
    static class VolumesOf
    {
        /// <summary>A scan in the scene that is shown with it; null where there is none.</summary>
        public static LumivoxVolumeAsset One(LumivoxTransferFunction function)
        {
            foreach (var volume in LumivoxVolume.All)
                if (volume.transferFunction == function && volume.volume != null) return volume.volume;
            return null;
        }
    }
}
