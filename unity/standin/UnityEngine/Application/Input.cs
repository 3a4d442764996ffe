// Keys and the devices of a headset, as far as scripts ask for them.
using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public enum KeyCode
    {
        None = 0, Backspace = 8, Tab = 9, Return = 13, Escape = 27, Space = 32, Comma = 44, Minus = 45, Period = 46,
        A = 97, B, C, D, E, F, G, H, I, J, K, L, M, N, O, P, Q, R, S, T, U, V, W, X, Y, Z,
        Delete = 127, KeypadEnter = 271, UpArrow = 273, DownArrow = 274, RightArrow = 275, LeftArrow = 276, Insert = 277, Home = 278, End = 279, PageUp = 280, PageDown = 281,
        LeftShift = 304, LeftControl = 306, LeftAlt = 308,
    }

    /// The old input manager, which projects may have turned off.
    public class Input
    {
        public static bool GetKey(KeyCode key)
        {
            StandIn.Threads.Main("GetKeyInt");
            if (StandIn.Keys.hasOnlyInputSystem) throw new InvalidOperationException("You are trying to read Input using the UnityEngine.Input class, but you have switched active Input handling to Input System package in Player Settings.");
            return StandIn.Keys.held.Contains(key);
        }
    }
}

namespace UnityEngine.XR
{
    public enum XRNode { LeftEye, RightEye, CenterEye, Head, LeftHand, RightHand }

    public struct InputFeatureUsage<T> : IEquatable<InputFeatureUsage<T>>
    {
        public string name { get; set; }
        public InputFeatureUsage(string usageName) => name = usageName;
        public bool Equals(InputFeatureUsage<T> other) => name == other.name;
        public override bool Equals(object obj) => obj is InputFeatureUsage<T> other && Equals(other);
        public override int GetHashCode() => name?.GetHashCode() ?? 0;
        public static bool operator ==(InputFeatureUsage<T> a, InputFeatureUsage<T> b) => a.Equals(b);
        public static bool operator !=(InputFeatureUsage<T> a, InputFeatureUsage<T> b) => !a.Equals(b);
    }

    public static class CommonUsages
    {
        public static InputFeatureUsage<bool> primaryButton = new InputFeatureUsage<bool>("PrimaryButton"), secondaryButton = new InputFeatureUsage<bool>("SecondaryButton");
        public static InputFeatureUsage<float> trigger = new InputFeatureUsage<float>("Trigger"), grip = new InputFeatureUsage<float>("Grip");
        public static InputFeatureUsage<Vector3> devicePosition = new InputFeatureUsage<Vector3>("DevicePosition"), centerEyePosition = new InputFeatureUsage<Vector3>("CenterEyePosition");
        public static InputFeatureUsage<Quaternion> deviceRotation = new InputFeatureUsage<Quaternion>("DeviceRotation"), centerEyeRotation = new InputFeatureUsage<Quaternion>("CenterEyeRotation");
    }

    public struct InputDevice : IEquatable<InputDevice>
    {
        internal StandIn.Devices.Device device;
        StandIn.Devices.Device Known { get { StandIn.Threads.Main("InputDevice"); return device != null && StandIn.Devices.all.ContainsValue(device) ? device : null; } }
        public bool isValid => Known != null;
        public string name => Known?.name;
        /// False, and nothing, of a device that is gone or has no such feature.
        bool Get<T>(InputFeatureUsage<T> usage, out T value)
        {
            value = default;
            if (Known == null || !Known.features.TryGetValue(usage.name ?? "", out var known) || !(known is T of)) return false;
            value = of;
            return true;
        }
        public bool TryGetFeatureValue(InputFeatureUsage<bool> usage, out bool value) => Get(usage, out value);
        public bool TryGetFeatureValue(InputFeatureUsage<float> usage, out float value) => Get(usage, out value);
        public bool TryGetFeatureValue(InputFeatureUsage<Vector2> usage, out Vector2 value) => Get(usage, out value);
        public bool TryGetFeatureValue(InputFeatureUsage<Vector3> usage, out Vector3 value) => Get(usage, out value);
        public bool TryGetFeatureValue(InputFeatureUsage<Quaternion> usage, out Quaternion value) => Get(usage, out value);
        public bool Equals(InputDevice other) => device == other.device;
        public override bool Equals(object obj) => obj is InputDevice other && Equals(other);
        public override int GetHashCode() => device?.GetHashCode() ?? 0;
        public static bool operator ==(InputDevice a, InputDevice b) => a.Equals(b);
        public static bool operator !=(InputDevice a, InputDevice b) => !a.Equals(b);
    }

    public class InputDevices
    {
        public static InputDevice GetDeviceAtXRNode(XRNode node)
        {
            StandIn.Threads.Main("GetDeviceAtXRNode");
            return new InputDevice { device = StandIn.Devices.all.TryGetValue(node, out var found) ? found : null };
        }
    }
}

namespace StandIn
{
    /// Keys that a test holds down.
    public static class Keys
    {
        public static readonly HashSet<UnityEngine.KeyCode> held = new HashSet<UnityEngine.KeyCode>();
        /// Whether the project has turned the old input manager off.
        public static bool hasOnlyInputSystem;
        internal static void Reset() { held.Clear(); hasOnlyInputSystem = false; }
    }

    /// What a test has at hand: a headset's eyes, controllers, and what they tell.
    public static class Devices
    {
        internal sealed class Device { internal string name; internal readonly Dictionary<string, object> features = new Dictionary<string, object>(); }
        internal static readonly Dictionary<UnityEngine.XR.XRNode, Device> all = new Dictionary<UnityEngine.XR.XRNode, Device>();
        public static void Connect(UnityEngine.XR.XRNode node) => all[node] = new Device { name = node.ToString() };
        public static void Disconnect(UnityEngine.XR.XRNode node) => all.Remove(node);
        public static void Tell<T>(UnityEngine.XR.XRNode node, UnityEngine.XR.InputFeatureUsage<T> usage, T value) => all[node].features[usage.name] = value;
        internal static void Reset() => all.Clear();
    }
}
