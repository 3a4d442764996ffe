using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    /// <summary>What a host lends for one view of one frame, by the names of the library's steps.</summary>
    internal struct HostTargets
    {
        /// <summary>Names of the depth to read, the colour to draw over and the depth to write.</summary>
        public ulong DepthId, ColorId, WrittenDepthId;
        /// <summary>Whom read-backs belong to.</summary>
        public ulong Ticket;
        /// <summary>The depth to read; a texture of the view's own size.</summary>
        public RenderTexture Depth;
        /// <summary>What is drawn over, and the depth that belongs to it.</summary>
        public RenderTargetIdentifier Color, WrittenDepth;
        /// <summary>Which layer of those.</summary>
        public int Slice;
        /// <summary>Pixels of the view, which begin at the first.</summary>
        public int Width, Height;
    }
}
