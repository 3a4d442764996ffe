using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine.Rendering;

namespace UnityEngine
{
    [System.Flags] public enum CameraType { Game = 1, SceneView = 2, Preview = 4, VR = 8, Reflection = 16 }
    public enum CameraClearFlags { Skybox = 1, Color = 2, SolidColor = 2, Depth = 3, Nothing = 4 }
    [Flags] public enum DepthTextureMode { None = 0, Depth = 1, DepthNormals = 2, MotionVectors = 4 }
    public enum RenderingPath { UsePlayerSettings = -1, VertexLit = 0, Forward = 1, DeferredShading = 3 }
    public enum StereoTargetEyeMask { None, Left, Right, Both }

    public sealed class Camera : Behaviour, StandIn.IEngineComponent
    {
        public enum StereoscopicEye { Left, Right }
        public enum MonoOrStereoscopicEye { Left, Right, Mono }
        public delegate void CameraCallback(Camera cam);
        public static CameraCallback onPreCull, onPreRender, onPostRender;

        static readonly List<Camera> all = new List<Camera>();
        internal readonly List<(CameraEvent at, CommandBuffer commands)> commandBuffers = new List<(CameraEvent, CommandBuffer)>();
        Matrix4x4? view, projection, unjittered;
        internal readonly Matrix4x4?[] eyeViews = new Matrix4x4?[2], eyeProjections = new Matrix4x4?[2];
        internal StandIn.CameraTargets targets;

        public float fieldOfView { get; set; } = 60;
        public float nearClipPlane { get; set; } = .3f;
        public float farClipPlane { get; set; } = 1000;
        public bool orthographic { get; set; }
        public float orthographicSize { get; set; } = 5;
        public float depth { get; set; }
        public int cullingMask { get; set; } = -1;
        public int eventMask { get; set; } = -1;
        public ulong overrideSceneCullingMask { get; set; }
        public UnityEngine.SceneManagement.Scene scene { get; set; }
        public CameraType cameraType { get; set; } = CameraType.Game;
        public CameraClearFlags clearFlags { get; set; } = CameraClearFlags.Skybox;
        public Color backgroundColor { get; set; } = new Color(.192f, .302f, .475f, 0);
        public DepthTextureMode depthTextureMode { get; set; }
        public bool allowHDR { get; set; } = true;
        public bool allowMSAA { get; set; } = true;
        public bool allowDynamicResolution { get; set; }
        public bool forceIntoRenderTexture { get; set; }
        public bool useOcclusionCulling { get; set; } = true;
        public bool useJitteredProjectionMatrixForTransparentRendering { get; set; } = true;
        public RenderingPath renderingPath { get; set; } = RenderingPath.UsePlayerSettings;
        public RenderingPath actualRenderingPath => renderingPath == RenderingPath.UsePlayerSettings ? RenderingPath.Forward : renderingPath;
        public RenderTexture targetTexture { get; set; }
        public int targetDisplay { get; set; }
        public Rect rect { get; set; } = new Rect(0, 0, 1, 1);
        public StereoTargetEyeMask stereoTargetEye { get; set; } = StereoTargetEyeMask.Both;
        public float stereoSeparation { get; set; } = .022f;
        public float stereoConvergence { get; set; } = 10;
        public bool stereoEnabled => StandIn.Headset.isOn && cameraType == CameraType.Game && stereoTargetEye != StereoTargetEyeMask.None && targetTexture == null;
        public MonoOrStereoscopicEye stereoActiveEye { get; internal set; } = MonoOrStereoscopicEye.Mono;
        public RenderTexture activeTexture => targetTexture;

        int Width => targetTexture != null ? targetTexture.width : stereoEnabled ? StandIn.Headset.width : Screen.width;
        int Height => targetTexture != null ? targetTexture.height : stereoEnabled ? StandIn.Headset.height : Screen.height;
        public int pixelWidth => Mathf.RoundToInt(Width * rect.width);
        public int pixelHeight => Mathf.RoundToInt(Height * rect.height);
        public int scaledPixelWidth => allowDynamicResolution ? Mathf.CeilToInt(pixelWidth * ScalableBufferManager.widthScaleFactor) : pixelWidth;
        public int scaledPixelHeight => allowDynamicResolution ? Mathf.CeilToInt(pixelHeight * ScalableBufferManager.heightScaleFactor) : pixelHeight;
        public Rect pixelRect { get => new Rect(rect.x * Width, rect.y * Height, pixelWidth, pixelHeight); set => rect = new Rect(value.x / Width, value.y / Height, value.width / Width, value.height / Height); }
        float? ownAspect;
        public float aspect { get => ownAspect ?? (float)pixelWidth / pixelHeight; set => ownAspect = value; }
        public void ResetAspect() => ownAspect = null;

        /// Looks along -z, as OpenGL does.
        public Matrix4x4 worldToCameraMatrix { get => view ?? Matrix4x4.Scale(new Vector3(1, 1, -1)) * Matrix4x4.TRS(transform.position, transform.rotation, Vector3.one).inverse; set => view = value; }
        public void ResetWorldToCameraMatrix() => view = null;
        public Matrix4x4 cameraToWorldMatrix => worldToCameraMatrix.inverse;
        Matrix4x4 Own() => orthographic
            ? Matrix4x4.Ortho(-orthographicSize * aspect, orthographicSize * aspect, -orthographicSize, orthographicSize, nearClipPlane, farClipPlane)
            : Matrix4x4.Perspective(fieldOfView, aspect, nearClipPlane, farClipPlane);
        public Matrix4x4 projectionMatrix { get => projection ?? Own(); set => projection = value; }
        public Matrix4x4 nonJitteredProjectionMatrix { get => unjittered ?? projectionMatrix; set => unjittered = value; }
        public void ResetProjectionMatrix() { projection = unjittered = null; }
        public Matrix4x4 previousViewProjectionMatrix => throw new NotImplementedException("the stand-in keeps no last frame's matrices");
        public Matrix4x4 GetStereoViewMatrix(StereoscopicEye eye) => eyeViews[(int)eye] ?? Matrix4x4.Translate(new Vector3((eye == StereoscopicEye.Left ? 1 : -1) * StandIn.Headset.separation / 2, 0, 0)) * worldToCameraMatrix;
        public void SetStereoViewMatrix(StereoscopicEye eye, Matrix4x4 matrix) => eyeViews[(int)eye] = matrix;
        public Matrix4x4 GetStereoProjectionMatrix(StereoscopicEye eye)
        {
            if (eyeProjections[(int)eye] is Matrix4x4 own) return own;
            // Each eye sees further to its own side.
            var matrix = projectionMatrix;
            matrix.m02 += eye == StereoscopicEye.Left ? -StandIn.Headset.shift : StandIn.Headset.shift;
            return matrix;
        }
        public void SetStereoProjectionMatrix(StereoscopicEye eye, Matrix4x4 matrix) => eyeProjections[(int)eye] = matrix;
        public Matrix4x4 GetStereoNonJitteredProjectionMatrix(StereoscopicEye eye) => GetStereoProjectionMatrix(eye);
        public void ResetStereoViewMatrices() => eyeViews[0] = eyeViews[1] = null;
        public void ResetStereoProjectionMatrices() => eyeProjections[0] = eyeProjections[1] = null;

        public void AddCommandBuffer(CameraEvent evt, CommandBuffer buffer) { StandIn.Threads.Main("AddCommandBuffer"); Alive(); commandBuffers.Add((evt, buffer ?? throw new ArgumentNullException(nameof(buffer)))); }
        public void AddCommandBufferAsync(CameraEvent evt, CommandBuffer buffer, ComputeQueueType queueType) => throw new NotImplementedException("the stand-in has one queue");
        public void RemoveCommandBuffer(CameraEvent evt, CommandBuffer buffer) { StandIn.Threads.Main("RemoveCommandBuffer"); Alive(); for (int i = commandBuffers.Count; i-- > 0;) if (commandBuffers[i].at == evt && commandBuffers[i].commands == buffer) commandBuffers.RemoveAt(i); }
        public void RemoveCommandBuffers(CameraEvent evt) => commandBuffers.RemoveAll(item => item.at == evt);
        public void RemoveAllCommandBuffers() => commandBuffers.Clear();
        public CommandBuffer[] GetCommandBuffers(CameraEvent evt) => commandBuffers.Where(item => item.at == evt).Select(item => item.commands).ToArray();
        public int commandBufferCount => commandBuffers.Count;

        public static Camera main { get { foreach (var camera in all) if (camera.isActiveAndEnabled && camera.CompareTag("MainCamera")) return camera; return null; } }
        public static Camera current { get; internal set; }
        public static Camera[] allCameras => all.Where(camera => camera.isActiveAndEnabled).OrderBy(camera => camera.depth).ToArray();
        public static int allCamerasCount { get { int count = 0; foreach (var camera in all) if (camera.isActiveAndEnabled) count++; return count; } }
        public static int GetAllCameras(Camera[] cameras)
        {
            int count = 0;
            foreach (var camera in all)
            {
                if (!camera.isActiveAndEnabled) continue;
                if (count == cameras.Length) throw new ArgumentException("Passed in array to fill with cameras is to small to hold the number of cameras. Use Camera.allCamerasCount to get the needed size.");
                // In the order in which they are drawn.
                int at = count++;
                for (; at > 0 && cameras[at - 1].depth > camera.depth; at--) cameras[at] = cameras[at - 1];
                cameras[at] = camera;
            }
            return count;
        }
        public Camera() => all.Add(this);
        internal override void OnDestroyed() { all.Remove(this); targets?.Dispose(); targets = null; base.OnDestroyed(); }
        internal override void OnEngineRefresh() { }

        public void Render() { StandIn.Threads.Main("Camera.Render"); StandIn.Engine.Render(this); }
        public bool RenderToCubemap(Cubemap cubemap) => RenderToCubemap(cubemap, 63);
        public bool RenderToCubemap(Cubemap cubemap, int faceMask)
        {
            StandIn.Threads.Main("RenderToCubemap");
            if (!cubemap.isReadable) return false;
            StandIn.Props.DrawCube(this, cubemap, faceMask);
            return true;
        }
        public bool RenderToCubemap(RenderTexture cubemap) => RenderToCubemap(cubemap, 63);
        public bool RenderToCubemap(RenderTexture cubemap, int faceMask)
        {
            StandIn.Threads.Main("RenderToCubemap");
            Alive();
            if (cubemap == null) throw new ArgumentNullException(nameof(cubemap));
            if (cubemap.dimension != UnityEngine.Rendering.TextureDimension.Cube) { Debug.LogError("Render target must be a cubemap"); return false; }
            // Another camera's picture is not drawn within this one's.
            if (current != null) { Debug.LogError("Recursive rendering is not supported"); return false; }
            if (!cubemap.Create()) return false;
            StandIn.Engine.RenderCube(this, cubemap, faceMask);
            return true;
        }
        public Ray ViewportPointToRay(Vector3 pos)
        {
            var inverse = (projectionMatrix * worldToCameraMatrix).inverse;
            Vector3 near = inverse.MultiplyPoint(new Vector3(pos.x * 2 - 1, pos.y * 2 - 1, -1)), far = inverse.MultiplyPoint(new Vector3(pos.x * 2 - 1, pos.y * 2 - 1, 1));
            return new Ray(near, far - near);
        }
        public Ray ScreenPointToRay(Vector3 pos) => ViewportPointToRay(new Vector3((pos.x - pixelRect.x) / pixelWidth, (pos.y - pixelRect.y) / pixelHeight));
        public Vector3 WorldToViewportPoint(Vector3 position) { var eye = worldToCameraMatrix.MultiplyPoint3x4(position); var clip = projectionMatrix.MultiplyPoint(eye); return new Vector3(clip.x * .5f + .5f, clip.y * .5f + .5f, -eye.z); }
        public Vector3 WorldToScreenPoint(Vector3 position) { var p = WorldToViewportPoint(position); return new Vector3(pixelRect.x + p.x * pixelWidth, pixelRect.y + p.y * pixelHeight, p.z); }
        public void CopyFrom(Camera other) => ((StandIn.IEngineComponent)other).CopyTo(this);
        void StandIn.IEngineComponent.CopyTo(Component component)
        {
            var other = (Camera)component;
            other.fieldOfView = fieldOfView; other.nearClipPlane = nearClipPlane; other.farClipPlane = farClipPlane; other.orthographic = orthographic; other.orthographicSize = orthographicSize;
            other.depth = depth; other.cullingMask = cullingMask; other.cameraType = cameraType; other.clearFlags = clearFlags; other.backgroundColor = backgroundColor; other.depthTextureMode = depthTextureMode;
            other.allowHDR = allowHDR; other.allowMSAA = allowMSAA; other.allowDynamicResolution = allowDynamicResolution; other.forceIntoRenderTexture = forceIntoRenderTexture; other.targetTexture = targetTexture;
            other.rect = rect; other.stereoTargetEye = stereoTargetEye; other.view = view; other.projection = projection; other.unjittered = unjittered; other.ownAspect = ownAspect;
        }
        internal static void Forget() { onPreCull = onPreRender = onPostRender = null; }
    }

    public static class ScalableBufferManager
    {
        public static float widthScaleFactor { get; private set; } = 1;
        public static float heightScaleFactor { get; private set; } = 1;
        public static void ResizeBuffers(float widthScale, float heightScale) { widthScaleFactor = widthScale; heightScaleFactor = heightScale; }
    }

    public enum LightType { Spot, Directional, Point, Rectangle, Disc, Pyramid, Box, Tube }
    public enum LightShadows { None, Hard, Soft }
    public enum LightRenderMode { Auto, ForcePixel, ForceVertex }
    [System.Flags] public enum LightmapBakeType { Realtime = 4, Baked = 2, Mixed = 1 }

    public sealed class Light : Behaviour, StandIn.IEngineComponent
    {
        public LightType type { get; set; } = LightType.Point;
        public Color color { get; set; } = Color.white;
        public float intensity { get; set; } = 1;
        public float bounceIntensity { get; set; } = 1;
        public float range { get; set; } = 10;
        public float spotAngle { get; set; } = 30;
        public float innerSpotAngle { get; set; } = 21.80208f;
        public float colorTemperature { get; set; } = 6570;
        public bool useColorTemperature { get; set; }
        public int cullingMask { get; set; } = -1;
        public int renderingLayerMask { get; set; } = 1;
        public LightShadows shadows { get; set; }
        public float shadowStrength { get; set; } = 1;
        public LightRenderMode renderMode { get; set; }
        public Texture cookie { get; set; }
        public float cookieSize { get; set; } = 10;
        public Vector2 areaSize { get; set; } = Vector2.one;
        public LightmapBakeType lightmapBakeType { get; set; } = LightmapBakeType.Realtime;
        public float dilatedRange => range;
        public LightUnit lightUnit { get; set; } = LightUnit.Candela;
        internal override void OnEngineRefresh() { }
        public void Reset() { }
        void StandIn.IEngineComponent.CopyTo(Component component)
        {
            var other = (Light)component;
            other.type = type; other.color = color; other.intensity = intensity; other.range = range; other.spotAngle = spotAngle; other.innerSpotAngle = innerSpotAngle; other.colorTemperature = colorTemperature;
            other.useColorTemperature = useColorTemperature; other.cullingMask = cullingMask; other.renderingLayerMask = renderingLayerMask; other.shadows = shadows;
        }
    }

    public sealed class ReflectionProbe : Behaviour
    {
        public Texture texture { get; internal set; }
        public static Texture defaultTexture { get; internal set; }
        internal override void OnEngineRefresh() { }
    }

    /// A camera's own, in place of the scene's.
    public sealed class Skybox : Behaviour { public Material material { get; set; } }

    public struct LayerMask
    {
        public static int NameToLayer(string layerName) => layerName == "Default" ? 0 : layerName == "TransparentFX" ? 1 : layerName == "Ignore Raycast" ? 2 : layerName == "Water" ? 4 : layerName == "UI" ? 5 : -1;
        public static int GetMask(params string[] layerNames) => layerNames.Select(NameToLayer).Where(layer => layer >= 0).Aggregate(0, (mask, layer) => mask | 1 << layer);
    }

    public enum FogMode { Linear = 1, Exponential = 2, ExponentialSquared = 3 }

    public sealed class RenderSettings : Object
    {
        RenderSettings() { }
        public static AmbientMode ambientMode { get; set; }
        public static Color ambientSkyColor { get; set; } = new Color(.212f, .227f, .259f);
        public static Color ambientEquatorColor { get; set; } = new Color(.114f, .125f, .133f);
        public static Color ambientGroundColor { get; set; } = new Color(.047f, .043f, .035f);
        /// The flat ambient colour is the sky's.
        public static Color ambientLight { get => ambientSkyColor; set => ambientSkyColor = value; }
        public static float ambientIntensity { get; set; } = 1;
        public static SphericalHarmonicsL2 ambientProbe { get; set; }
        public static Material skybox { get; set; }
        public static Light sun { get; set; }
        public static bool fog { get; set; }
        public static FogMode fogMode { get; set; } = FogMode.ExponentialSquared;
        public static Color fogColor { get; set; } = Color.gray;
        public static float fogDensity { get; set; } = .01f;
        public static float fogStartDistance { get; set; }
        public static float fogEndDistance { get; set; } = 300;
        public static DefaultReflectionMode defaultReflectionMode { get; set; }
        public static int defaultReflectionResolution { get; set; } = 128;
        public static float reflectionIntensity { get; set; } = 1;
        public static Texture customReflectionTexture { get; set; }
        public static Cubemap customReflection { get => customReflectionTexture as Cubemap; set => customReflectionTexture = value; }
        internal static void Default()
        {
            ambientMode = AmbientMode.Skybox;
            ambientSkyColor = new Color(.212f, .227f, .259f); ambientEquatorColor = new Color(.114f, .125f, .133f); ambientGroundColor = new Color(.047f, .043f, .035f);
            ambientIntensity = reflectionIntensity = 1;
            ambientProbe = default;
            skybox = null; sun = null; fog = false; fogMode = FogMode.ExponentialSquared; fogColor = Color.gray; fogDensity = .01f; fogStartDistance = 0; fogEndDistance = 300; customReflectionTexture = null;
            ReflectionProbe.defaultTexture = null;
        }
    }
}

namespace UnityEngine.Rendering
{
    public enum ComputeQueueType { Default, Background, Urgent }
    [Flags] public enum CopyTextureSupport { None = 0, Basic = 1, Copy3D = 2, DifferentTypes = 4, TextureToRT = 8, RTToTexture = 16 }
    public enum RenderQueue { Background = 1000, Geometry = 2000, AlphaTest = 2450, GeometryLast = 2500, Transparent = 3000, Overlay = 4000 }
    public enum LightUnit { Lumen, Candela, Lux, Nits, Ev100 }
    public enum CameraEvent
    {
        BeforeDepthTexture, AfterDepthTexture, BeforeDepthNormalsTexture, AfterDepthNormalsTexture, BeforeGBuffer, AfterGBuffer, BeforeLighting, AfterLighting, BeforeFinalPass, AfterFinalPass,
        BeforeForwardOpaque, AfterForwardOpaque, BeforeImageEffectsOpaque, AfterImageEffectsOpaque, BeforeSkybox, AfterSkybox, BeforeForwardAlpha, AfterForwardAlpha, BeforeImageEffects, AfterImageEffects,
        AfterEverything, BeforeReflections, AfterReflections, BeforeHaloAndLensFlares, AfterHaloAndLensFlares,
    }
    public enum AmbientMode { Skybox = 0, Trilight = 1, Flat = 3, Custom = 4 }
    public enum DefaultReflectionMode { Skybox, Custom }

    /// Nine coefficients for each of three colours.
    [Serializable]
    public unsafe struct SphericalHarmonicsL2 : IEquatable<SphericalHarmonicsL2>
    {
        fixed float values[27];
        public float this[int rgb, int coefficient] { get => values[rgb * 9 + coefficient]; set => values[rgb * 9 + coefficient] = value; }
        public void Clear() => this = default;
        public void AddAmbientLight(Color color) { for (int c = 0; c < 3; c++) this[c, 0] += color[c] * 3.5449077f * .28209479f; }
        /// Irradiance over pi, for each direction.
        public void Evaluate(Vector3[] directions, Color[] results)
        {
            for (int i = 0; i < directions.Length; i++)
            {
                Vector3 d = directions[i];
                var color = new Color(0, 0, 0, 1);
                for (int c = 0; c < 3; c++)
                    color[c] = this[c, 0] + this[c, 1] * d.y + this[c, 2] * d.z + this[c, 3] * d.x + this[c, 4] * d.x * d.y + this[c, 5] * d.y * d.z + this[c, 6] * (3 * d.z * d.z - 1) + this[c, 7] * d.x * d.z + this[c, 8] * (d.x * d.x - d.y * d.y);
                results[i] = color;
            }
        }
        public bool Equals(SphericalHarmonicsL2 other) { for (int i = 0; i < 27; i++) if (!values[i].Equals(other.values[i])) return false; return true; }
        public override bool Equals(object other) => other is SphericalHarmonicsL2 probe && Equals(probe);
        public override int GetHashCode() => values[0].GetHashCode();
        public static bool operator ==(SphericalHarmonicsL2 lhs, SphericalHarmonicsL2 rhs) => lhs.Equals(rhs);
        public static bool operator !=(SphericalHarmonicsL2 lhs, SphericalHarmonicsL2 rhs) => !lhs.Equals(rhs);
    }
}

namespace UnityEngine.XR
{
    public static class XRSettings
    {
        public enum StereoRenderingMode { MultiPass, SinglePass, SinglePassInstanced, SinglePassMultiview }
        public static bool enabled { get => StandIn.Headset.isOn; set => StandIn.Headset.isOn = value; }
        public static bool isDeviceActive => StandIn.Headset.isOn;
        public static StereoRenderingMode stereoRenderingMode => StandIn.Headset.mode;
        public static int eyeTextureWidth => StandIn.Headset.width;
        public static int eyeTextureHeight => StandIn.Headset.height;
        public static RenderTextureDescriptor eyeTextureDesc => new RenderTextureDescriptor(StandIn.Headset.width, StandIn.Headset.height, RenderTextureFormat.DefaultHDR, 32) { dimension = TextureDimension.Tex2DArray, volumeDepth = 2, vrUsage = VRTextureUsage.TwoEyes };
        public static float eyeTextureResolutionScale { get; set; } = 1;
        public static float renderViewportScale { get; set; } = 1;
        public static string loadedDeviceName => StandIn.Headset.isOn ? "Stand-in" : "";
    }
}

namespace StandIn
{
    /// A headset that a test puts on.
    public static class Headset
    {
        public static bool isOn;
        public static int width = 64, height = 64;
        /// Metres between the eyes, and how far each projection is off its centre.
        public static float separation = .064f, shift = .1f;
        public static UnityEngine.XR.XRSettings.StereoRenderingMode mode = UnityEngine.XR.XRSettings.StereoRenderingMode.SinglePassInstanced;
        internal static void Reset()
        {
            isOn = false;
            width = height = 64;
            separation = .064f;
            shift = .1f;
            mode = UnityEngine.XR.XRSettings.StereoRenderingMode.SinglePassInstanced;
        }
    }
}
