using UnityEngine;

namespace Lumivox.Editor
{
    /// <summary>The pictures that the project window shows of scans.</summary>
    static class ScanPictures
    {
        const int Side = 128;

        /// <summary>A scan that is open, as the preset that suits it shows it; null where it cannot be pictured. Waits for it.</summary>
        public static Texture2D Of(LumivoxVolumeAsset scan, int side = Side)
        {
            try
            {
                return EditorWork.Wait(scan.RequestPicture(side));
            }
            catch (LumivoxException)
            {
                // A scan without a picture is still a scan.
                return null;
            }
        }
    }
}
