using System;
using System.Collections.Generic;
using System.IO;

namespace UnityEngine
{
    public enum RuntimePlatform { OSXEditor = 0, OSXPlayer = 1, WindowsPlayer = 2, WindowsEditor = 7, IPhonePlayer = 8, Android = 11, LinuxPlayer = 13, LinuxEditor = 16, WebGLPlayer = 17 }
    public enum LogType { Error, Assert, Warning, Log, Exception }
    public enum LogOption { None, NoStacktrace }
    public enum SystemLanguage { English = 10, Unknown = 43 }

    public class Application
    {
        internal static bool playing;
        public static bool isPlaying { get { StandIn.Threads.Main("get_isPlaying"); return playing; } }
        public static bool isEditor =>
#if UNITY_EDITOR
            true;
#else
            false;
#endif
        public static bool isBatchMode => true;
        public static bool isFocused => true;
        public static bool runInBackground { get; set; } = true;
        public static int targetFrameRate { get; set; } = -1;
        public static RuntimePlatform platform => isEditor ? RuntimePlatform.LinuxEditor : RuntimePlatform.LinuxPlayer;
        public static bool isMobilePlatform => false;
        public static string unityVersion =>
#if UNITY_6000_0_OR_NEWER
            "6000.0.58f2";
#else
            "2022.3.62f1";
#endif
        public static string productName => "Stand-in";
        public static string companyName => "Lumivox";
        public static string version => "1.0";
        /// Folders of a project that lasts as long as the process.
        public static string dataPath { get { StandIn.Threads.Main("get_dataPath"); return Folder("Assets"); } }
        public static string persistentDataPath { get { StandIn.Threads.Main("get_persistentDataPath"); return Folder("Persistent"); } }
        public static string temporaryCachePath { get { StandIn.Threads.Main("get_temporaryCachePath"); return Folder("Temp"); } }
        public static string streamingAssetsPath { get { StandIn.Threads.Main("get_streamingAssetsPath"); return Folder("Assets/StreamingAssets"); } }
        static string project;
        static string Folder(string name)
        {
            project ??= Environment.GetEnvironmentVariable("STANDIN_PROJECT") ?? Path.Combine(Path.GetTempPath(), "standin-" + System.Diagnostics.Process.GetCurrentProcess().Id);
            return Directory.CreateDirectory(Path.Combine(project, name)).FullName;
        }
        public delegate void LowMemoryCallback();
        public delegate void LogCallback(string condition, string stackTrace, LogType type);
        public static event LogCallback logMessageReceived, logMessageReceivedThreaded;
        public static event Action quitting;
        public static event Func<bool> wantsToQuit;
#pragma warning disable 67 // Nothing here runs low on memory or loses the focus.
        public static event LowMemoryCallback lowMemory;
        public static event Action<bool> focusChanged;
        public static event Action unloading;
#pragma warning restore 67
        public static event Events.UnityAction onBeforeRender;
        internal static void BeforeRender() => onBeforeRender?.Invoke();
        internal static void Logged(string message, string stack, LogType type)
        {
            if (StandIn.Threads.isMain) logMessageReceived?.Invoke(message, stack, type);
            logMessageReceivedThreaded?.Invoke(message, stack, type);
        }
        public static void Quit() => Quit(0);
        public static void Quit(int exitCode) { if (wantsToQuit == null || wantsToQuit()) quitting?.Invoke(); }
        internal static void Quitting() => quitting?.Invoke();
        internal static void ForgetListeners() { logMessageReceived = null; logMessageReceivedThreaded = null; quitting = null; wantsToQuit = null; onBeforeRender = null; }
    }

    public class Time
    {
        internal static int frames;
        internal static double seconds;
        internal static float delta = 1 / 60f;
        public static int frameCount { get { StandIn.Threads.Main("get_frameCount"); return frames; } }
        public static int renderedFrameCount => frameCount;
        public static float time => (float)timeAsDouble;
        public static double timeAsDouble { get { StandIn.Threads.Main("get_time"); return seconds; } }
        public static float deltaTime { get { StandIn.Threads.Main("get_deltaTime"); return delta; } }
        public static float unscaledDeltaTime => deltaTime;
        public static float smoothDeltaTime => deltaTime;
        public static float unscaledTime => time;
        public static double unscaledTimeAsDouble => timeAsDouble;
        public static float timeScale { get; set; } = 1;
        static readonly System.Diagnostics.Stopwatch watch = System.Diagnostics.Stopwatch.StartNew();
        public static float realtimeSinceStartup => (float)watch.Elapsed.TotalSeconds;
        public static double realtimeSinceStartupAsDouble => watch.Elapsed.TotalSeconds;
    }

    public interface ILogger { void Log(LogType logType, object message); void LogException(Exception exception); }
    public class Debug
    {
        static void Write(LogType type, object message, string stack = null)
        {
            var text = message?.ToString() ?? "Null";
            StandIn.Log.Add(type, text, stack);
            Application.Logged(text, stack ?? "", type);
        }
        public static bool isDebugBuild => true;
        public static void Log(object message) => Write(LogType.Log, message);
        public static void Log(object message, Object context) => Write(LogType.Log, message);
        public static void LogWarning(object message) => Write(LogType.Warning, message);
        public static void LogWarning(object message, Object context) => Write(LogType.Warning, message);
        public static void LogError(object message) => Write(LogType.Error, message, Environment.StackTrace);
        public static void LogError(object message, Object context) => LogError(message);
        public static void LogException(Exception exception) => Write(LogType.Exception, $"{exception.GetType().Name}: {exception.Message}", exception.StackTrace);
        public static void LogException(Exception exception, Object context) => LogException(exception);
        public static void LogFormat(string format, params object[] args) => Log(string.Format(format, args));
        public static void LogWarningFormat(string format, params object[] args) => LogWarning(string.Format(format, args));
        public static void LogErrorFormat(string format, params object[] args) => LogError(string.Format(format, args));
        public static void LogFormat(LogType logType, LogOption logOptions, Object context, string format, params object[] args) => Write(logType, string.Format(format, args));
        public static void Assert(bool condition) { if (!condition) Write(LogType.Assert, "Assertion failed", Environment.StackTrace); }
        public static void Assert(bool condition, string message) { if (!condition) Write(LogType.Assert, message, Environment.StackTrace); }
        public static void Assert(bool condition, object message) => Assert(condition, message.ToString());
        public static void LogAssertion(object message) => Write(LogType.Assert, message, Environment.StackTrace);
        public static void DrawLine(Vector3 start, Vector3 end) { }
        public static void DrawLine(Vector3 start, Vector3 end, Color color) { }
    }

    public class AsyncOperation : YieldInstruction
    {
        internal bool finished;
        public bool isDone => finished;
        public float progress => finished ? 1 : 0;
        public event Action<AsyncOperation> completed { add { if (finished) value(this); else waiting += value; } remove => waiting -= value; }
        Action<AsyncOperation> waiting;
        internal void Finish() { finished = true; waiting?.Invoke(this); waiting = null; }
    }
#if UNITY_6000_0_OR_NEWER
    /// Only what goes on with the next frame.
    public class Awaitable
    {
        Awaitable() { }
        public static Awaitable NextFrameAsync(System.Threading.CancellationToken cancellationToken = default) => throw new NotImplementedException("the stand-in has no awaitables");
    }
#endif
    public class GUIUtility
    {
        public static string systemCopyBuffer { get; set; } = "";
        public static int hotControl { get; set; }
        public static int keyboardControl { get; set; }
        public static int GetControlID(FocusType focus) => throw new NotImplementedException("the stand-in has no immediate-mode user interface");
        public static Vector2 GUIToScreenPoint(Vector2 guiPoint) => guiPoint;
    }
    public enum FocusType { Native, Keyboard, Passive }

    public sealed class Gizmos
    {
        /// What was drawn since the last frame began: a kind and a matrix each.
        internal static readonly List<(string kind, Matrix4x4 matrix, Color color)> drawn = new List<(string, Matrix4x4, Color)>();
        public static Color color { get; set; } = Color.white;
        public static Matrix4x4 matrix { get; set; } = Matrix4x4.identity;
        public static void DrawWireCube(Vector3 center, Vector3 size) => drawn.Add(("wire cube", matrix * Matrix4x4.TRS(center, Quaternion.identity, size), color));
        public static void DrawCube(Vector3 center, Vector3 size) => drawn.Add(("cube", matrix * Matrix4x4.TRS(center, Quaternion.identity, size), color));
        public static void DrawWireSphere(Vector3 center, float radius) => drawn.Add(("wire sphere", matrix * Matrix4x4.TRS(center, Quaternion.identity, Vector3.one * radius), color));
        public static void DrawSphere(Vector3 center, float radius) => drawn.Add(("sphere", matrix * Matrix4x4.TRS(center, Quaternion.identity, Vector3.one * radius), color));
        public static void DrawLine(Vector3 from, Vector3 to) => drawn.Add(("line", matrix * Matrix4x4.TRS(from, Quaternion.identity, to - from), color));
        public static void DrawIcon(Vector3 center, string name) => drawn.Add(("icon " + name, matrix * Matrix4x4.Translate(center), color));
        public static void DrawIcon(Vector3 center, string name, bool allowScaling) => DrawIcon(center, name);
    }

    public static class Random
    {
        static System.Random source = new System.Random(1);
        public static float value => (float)source.NextDouble();
        public static float Range(float minInclusive, float maxInclusive) => minInclusive + (maxInclusive - minInclusive) * value;
        public static int Range(int minInclusive, int maxExclusive) => maxExclusive <= minInclusive ? minInclusive : source.Next(minInclusive, maxExclusive);
        public static void InitState(int seed) => source = new System.Random(seed);
    }

    public sealed class Screen
    {
        public static int width { get; internal set; } = 640;
        public static int height { get; internal set; } = 480;
        public static float dpi => 96;
    }
}

namespace UnityEngine.Events
{
    public delegate void UnityAction();
    public delegate void UnityAction<T0>(T0 arg0);
    public delegate void UnityAction<T0, T1>(T0 arg0, T1 arg1);
    [Serializable]
    public abstract class UnityEventBase
    {
        internal abstract void Clear();
        public void RemoveAllListeners() => Clear();
    }
    [Serializable]
    public class UnityEvent : UnityEventBase
    {
        readonly List<UnityAction> calls = new List<UnityAction>();
        public void AddListener(UnityAction call) => calls.Add(call);
        public void RemoveListener(UnityAction call) => calls.Remove(call);
        internal override void Clear() => calls.Clear();
        public void Invoke() { foreach (var call in calls.ToArray()) call(); }
    }
    [Serializable]
    public class UnityEvent<T0> : UnityEventBase
    {
        readonly List<UnityAction<T0>> calls = new List<UnityAction<T0>>();
        public void AddListener(UnityAction<T0> call) => calls.Add(call);
        public void RemoveListener(UnityAction<T0> call) => calls.Remove(call);
        internal override void Clear() => calls.Clear();
        public void Invoke(T0 arg0) { foreach (var call in calls.ToArray()) call(arg0); }
    }
}

namespace UnityEngine.Profiling
{
    public class Sampler { internal Sampler() { } }
    public sealed class CustomSampler : Sampler
    {
        internal CustomSampler() { }
        public static CustomSampler Create(string name, bool collectGpuData = false) => new CustomSampler();
        public void Begin() { }
        public void End() { }
    }
    public sealed class Profiler
    {
        Profiler() { }
        public static bool enabled { get; set; }
        public static void BeginSample(string name) => StandIn.Samples.Begin(name);
        public static void EndSample() => StandIn.Samples.End();
    }
}

namespace Unity.Profiling
{
    public readonly struct ProfilerMarker
    {
        readonly string name;
        public ProfilerMarker(string name) => this.name = name;
        public void Begin() => StandIn.Samples.Begin(name);
        public void End() => StandIn.Samples.End();
        public AutoScope Auto() { Begin(); return new AutoScope(true); }
        public struct AutoScope : IDisposable { readonly bool begun; internal AutoScope(bool begun) => this.begun = begun; public void Dispose() { if (begun) StandIn.Samples.End(); } }
    }
}

namespace StandIn
{
    /// Profiler samples: how deep they are nested, so that one without an end is seen.
    public static class Samples
    {
        [ThreadStatic] static int depth;
        public static int open => depth;
        internal static void Begin(string name) => depth++;
        internal static void End() { if (--depth < 0) { depth = 0; UnityEngine.Debug.LogError("Non matching Profiler.EndSample"); } }
    }
}

namespace UnityEngine.Assertions
{
    public static class Assert
    {
        public static void IsTrue(bool condition) => IsTrue(condition, "Assertion failure. Value was False");
        public static void IsTrue(bool condition, string message) => Debug.Assert(condition, message);
        public static void IsFalse(bool condition) => IsFalse(condition, "Assertion failure. Value was True");
        public static void IsFalse(bool condition, string message) => Debug.Assert(!condition, message);
        public static void IsNotNull<T>(T value) where T : class => IsNotNull(value, "Assertion failure. Value was Null");
        public static void IsNotNull<T>(T value, string message) where T : class => Debug.Assert(value != null, message);
        public static void AreEqual<T>(T expected, T actual) => Debug.Assert(EqualityComparer<T>.Default.Equals(expected, actual), $"Assertion failure. Values are not equal.\nExpected: {expected} == {actual}");
    }
}
