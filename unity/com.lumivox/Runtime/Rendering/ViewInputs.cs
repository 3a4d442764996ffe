using UnityEngine;
using UnityEngine.Rendering;

namespace Lumivox
{
    /// <summary>One view of one frame, as its pipeline draws it.</summary>
    internal struct ViewInputs
    {
        /// <summary>Whose view it is.</summary>
        public Camera Camera;
        /// <summary>Which eye of a headset, and how many share the frame; 0 of 1 without one.</summary>
        public int Eye, EyeCount;
        /// <summary>From the eye's space, whose -z is forward, as `Camera.cameraToWorldMatrix`.</summary>
        public Matrix4x4 WorldFromCamera;
        /// <summary>The projection in OpenGL's convention, as `Camera.projectionMatrix`, without jitter where that is known.</summary>
        public Matrix4x4 Projection;
        /// <summary>Whether the image's first row in memory is its top, as only a back buffer's may be.</summary>
        public bool IsTopFirst;
        /// <summary>Pixels that are drawn.</summary>
        public int Width, Height;
        /// <summary>Whether there is a depth to end rays at.</summary>
        public bool HasDepth;
        /// <summary>Whether that depth has a layer for each eye, and which is this view's.</summary>
        public bool IsDepthArray;
        public int DepthSlice;
        /// <summary>The texture of that depth; null: the one that shaders know as `_CameraDepthTexture`.</summary>
        public Texture DepthTexture;
        /// <summary>What is drawn over, and the depth that belongs to it.</summary>
        public RenderTargetIdentifier Color, Depth;
        /// <summary>Which layer of those.</summary>
        public int Slice;
        /// <summary>Whether the camera is shifted by part of a pixel in each frame.</summary>
        public bool IsJittered;
        /// <summary>What the pipeline multiplies all light by, besides.</summary>
        public float Exposure;
        /// <summary>Whether the pipeline's own fog lies over what is drawn, and not `RenderSettings`'.</summary>
        public bool HasOwnFog;
    }
}
