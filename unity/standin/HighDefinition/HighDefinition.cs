// The part of the High Definition Render Pipeline that custom passes, lights and skies are. HDRenderPipeline draws
// cameras with it.
using System;
using System.Collections.Generic;

namespace UnityEngine.Rendering.HighDefinition
{
    public enum CustomPassInjectionPoint { BeforeRendering = 0, BeforeTransparent = 1, BeforePostProcess = 2, AfterPostProcess = 3, BeforePreRefraction = 4, AfterOpaqueDepthAndNormal = 5, AfterOpaqueAndSky = 6 }

    public class HDRenderPipelineAsset
#if UNITY_6000_0_OR_NEWER
        : RenderPipelineAsset<HDRenderPipeline>
#else
        : RenderPipelineAsset
#endif
    {
        HDRenderPipelineAsset() { }
        public RenderPipelineSettings currentPlatformRenderPipelineSettings { get; set; } = new RenderPipelineSettings { supportCustomPass = true };
        protected override RenderPipeline CreatePipeline() => new HDRenderPipeline(this);
    }

    public struct RenderPipelineSettings { public bool supportCustomPass; }

    public enum FrameSettingsField { None = -1, Postprocess = 15, CustomPass = 6, ExposureControl = 32, AtmosphericScattering = 27 }

    public struct FrameSettings
    {
        /// All is on until it is turned off.
        ulong off;
        public bool IsEnabled(FrameSettingsField field) => (off >> (int)field & 1) == 0;
        public void SetEnabled(FrameSettingsField field, bool value) => off = value ? off & ~(1ul << (int)field) : off | 1ul << (int)field;
    }

    public struct FrameSettingsOverrideMask { public BitArray128 mask; }

    public enum HDCameraFrameHistoryType { ColorBufferMipChain, Exposure, TemporalAntialiasing }

    public class HDCamera
    {
        internal readonly RTHandle[] exposures = new RTHandle[2];
        internal HDCamera() { }
        public Camera camera;
        /// Null where nothing of that kind is kept.
        public RTHandle GetPreviousFrameRT(int id) => id == (int)HDCameraFrameHistoryType.Exposure ? exposures[1] : null;
        /// What the volumes set where this camera is, for the layers that it minds.
        public VolumeStack volumeStack { get; internal set; }
        /// As the camera overrides them.
        public FrameSettings frameSettings { get; internal set; }
        public int actualWidth { get; internal set; }
        public int actualHeight { get; internal set; }
        internal HDAdditionalCameraData.AntialiasingMode antialiasing { get; set; }
    }

    public class HDAdditionalCameraData : MonoBehaviour
    {
        public enum AntialiasingMode { None, FastApproximateAntialiasing, TemporalAntialiasing, SubpixelMorphologicalAntiAliasing }
        public AntialiasingMode antialiasing;
        public enum ClearColorMode { Sky, Color, None }
        public ClearColorMode clearColorMode;
        public Color backgroundColorHDR = new Color(.025f, .07f, .19f, 0);
        public bool customRenderingSettings;
        FrameSettings own;
        public ref FrameSettings renderingPathCustomFrameSettings => ref own;
        public FrameSettingsOverrideMask renderingPathCustomFrameSettingsOverrideMask;
        internal FrameSettings Overridden()
        {
            var result = new FrameSettings();
            if (!customRenderingSettings) return result;
            foreach (FrameSettingsField field in Enum.GetValues(typeof(FrameSettingsField)))
                if (field != FrameSettingsField.None && renderingPathCustomFrameSettingsOverrideMask.mask[(uint)field]) result.SetEnabled(field, own.IsEnabled(field));
            return result;
        }
    }

    public struct CustomPassContext
    {
        public readonly ScriptableRenderContext renderContext;
        public readonly CommandBuffer cmd;
        public readonly HDCamera hdCamera;
        public readonly RTHandle cameraColorBuffer;
        public readonly RTHandle cameraDepthBuffer;
        internal CustomPassContext(ScriptableRenderContext renderContext, CommandBuffer cmd, HDCamera hdCamera, RTHandle cameraColorBuffer, RTHandle cameraDepthBuffer)
        {
            this.renderContext = renderContext;
            this.cmd = cmd;
            this.hdCamera = hdCamera;
            this.cameraColorBuffer = cameraColorBuffer;
            this.cameraDepthBuffer = cameraDepthBuffer;
        }
    }

    [Serializable]
    public abstract class CustomPass
    {
        public string name { get; set; } = "Custom Pass";
        public bool enabled = true;
        protected virtual void Setup(ScriptableRenderContext renderContext, CommandBuffer cmd) { }
        protected virtual void Execute(CustomPassContext ctx) { }
        protected virtual void Cleanup() { }
        internal void Run(CustomPassContext ctx) { using (StandIn.Callbacks.Counted()) Execute(ctx); }
    }

    [ExecuteAlways]
    public class CustomPassVolume : MonoBehaviour
    {
        internal static readonly List<CustomPassVolume> active = new List<CustomPassVolume>();
        Camera target;
        public bool isGlobal { get; set; } = true;
        public float priority;
        public List<CustomPass> customPasses = new List<CustomPass>();
        public CustomPassInjectionPoint injectionPoint = CustomPassInjectionPoint.BeforeTransparent;
        /// The only camera that it is for; null for all.
        public Camera targetCamera { get => target; set => target = value; }
        void OnEnable() => active.Add(this);
        void OnDisable() => active.Remove(this);
        internal bool IsFor(Camera camera) => target is object ? ReferenceEquals(target, camera) : isGlobal;

        internal static readonly Dictionary<CustomPassInjectionPoint, List<CustomPass>> global = new Dictionary<CustomPassInjectionPoint, List<CustomPass>>();

        // The pipeline is of scripts, too: a reload forgets what the domain before registered.
        static CustomPassVolume() => StandIn.Domain.beforeReload += global.Clear;

        public static void RegisterGlobalCustomPass(CustomPassInjectionPoint injectionPoint, CustomPass customPassInstance, float priority = 0)
        {
            if (!global.TryGetValue(injectionPoint, out var list)) global[injectionPoint] = list = new List<CustomPass>();
            list.Add(customPassInstance);
        }
        public static bool UnregisterGlobalCustomPass(CustomPass customPassInstance)
        {
            var found = false;
            foreach (var list in global.Values) found |= list.Remove(customPassInstance);
            return found;
        }
    }

    public class HDAdditionalLightData : MonoBehaviour
    {
        public float lightDimmer { get; set; } = 1;
        public float angularDiameter { get; set; } = 0.5f;
        public float shapeRadius { get; set; } = 0.025f;
        public float innerSpotPercent { get; set; }
        public bool affectDiffuse { get; set; } = true;
    }

    public enum SkyType { HDRI = 1, Gradient = 3, PhysicallyBased = 4 }
    public enum SkyIntensityMode { Exposure, Lux, Multiplier }
    public sealed class SkyIntensityParameter : VolumeParameter<SkyIntensityMode> { public SkyIntensityParameter(SkyIntensityMode value, bool overrideState = false) => this.value = value; }

    public sealed class VisualEnvironment : VolumeComponent { public NoInterpIntParameter skyType = new NoInterpIntParameter(0); }

    public abstract class SkySettings : VolumeComponent
    {
        public ClampedFloatParameter rotation = new ClampedFloatParameter(0, 0, 360);
        public SkyIntensityParameter skyIntensityMode = new SkyIntensityParameter(SkyIntensityMode.Exposure);
        public FloatParameter exposure = new FloatParameter(0);
        public MinFloatParameter multiplier = new MinFloatParameter(1, 0);
        public FloatParameter desiredLuxValue = new FloatParameter(20000);
        public MinFloatParameter upperHemisphereLuxValue = new MinFloatParameter(1, 0);
    }

    public class HDRISky : SkySettings
    {
        public CubemapParameter hdriSky = new CubemapParameter(null);
    }

    public class GradientSky : SkySettings
    {
        public ColorParameter top = new ColorParameter(Color.blue);
        public ColorParameter middle = new ColorParameter(new Color(0.3f, 0.7f, 1f));
        public ColorParameter bottom = new ColorParameter(Color.white);
        public MinFloatParameter gradientDiffusion = new MinFloatParameter(1, 0);
    }
}
