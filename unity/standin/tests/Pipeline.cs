// A pipeline that is in force for a part of a test.
using System;
using System.Reflection;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.Rendering.HighDefinition;
using UnityEngine.Rendering.Universal;
using Object = UnityEngine.Object;

namespace Lumivox.Tests
{
    sealed class Pipeline : IDisposable
    {
        readonly RenderPipelineAsset asset;
        ScriptableRendererFeature feature;

        /// Built-in, HDRP, or URP by its "graph", in its "compatibility" mode, or with the package's "feature".
        public Pipeline(string kind)
        {
            LumivoxRuntime.Stop();
#if UNITY_6000_0_OR_NEWER
            StandInUniversal.usesCompatibilityMode = kind == "compatibility";
#endif
            if (kind == "Built-in") return;
            asset = kind == "HDRP" ? (RenderPipelineAsset)ScriptableObject.CreateInstance<HDRenderPipelineAsset>() : ScriptableObject.CreateInstance<UniversalRenderPipelineAsset>();
            Hook(kind == "HDRP" ? typeof(HighDefinition.LumivoxCustomPass).Assembly : typeof(Universal.LumivoxFeature).Assembly);
            GraphicsSettings.defaultRenderPipeline = asset;
        }

        /// What the engine calls when scripts are loaded.
        public static void Hook(Assembly assembly)
        {
            foreach (var type in assembly.GetTypes()) type.GetMethod("Hook", BindingFlags.Static | BindingFlags.NonPublic)?.Invoke(null, null);
        }

        /// Gives URP's renderer a feature.
        public T Add<T>() where T : ScriptableRendererFeature
        {
            var added = StandInUniversal.Add<T>((UniversalRenderPipelineAsset)asset);
            feature = added;
            return added;
        }

        /// Of URP's asset.
        public float RenderScale
        {
            get => ((UniversalRenderPipelineAsset)asset).renderScale;
            set => ((UniversalRenderPipelineAsset)asset).renderScale = value;
        }

        /// What a change of URP's asset, renderer or quality level does.
        public void Reload() => StandInUniversal.Reload((UniversalRenderPipelineAsset)asset);

        public void Dispose()
        {
            if (feature != null) StandInUniversal.Remove((UniversalRenderPipelineAsset)asset, feature);
            GraphicsSettings.defaultRenderPipeline = null;
            StandInHighDefinition.Reset();
            StandInUniversal.post = null;
            VolumeManager.instance.stack = new VolumeStack();
            if (asset != null) Object.DestroyImmediate(asset);
        }
    }
}
