using UnityEngine;

namespace Lumivox
{
    /// <summary>Which eye a pass is for, where a headset draws one after the other and its pipeline does not say.</summary>
    internal sealed class Eyes
    {
        Camera camera;
        int frame = -1;
        int next;

        /// <summary>The eye of a pass that begins now: the first of a camera in a frame is the left one.</summary>
        public int Next(Camera of)
        {
            if (!ReferenceEquals(camera, of) || frame != Time.frameCount) (camera, frame, next) = (of, Time.frameCount, 0);
            var eye = next;
            next = (next + 1) % 2;
            return eye;
        }
    }
}
