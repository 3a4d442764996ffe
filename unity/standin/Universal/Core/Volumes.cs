// Settings that depend on where a camera is. The stand-in has one stack, whose components tests set.
using System;
using System.Collections.Generic;

namespace UnityEngine.Rendering
{
    public abstract class VolumeParameter { public virtual bool overrideState { get; set; } }

    public class VolumeParameter<T> : VolumeParameter
    {
        public virtual T value { get; set; }
        public VolumeParameter() { }
        internal VolumeParameter(T value) => this.value = value;
    }

    public class IntParameter : VolumeParameter<int> { public IntParameter(int value, bool overrideState = false) : base(value) { } }
    public class NoInterpIntParameter : VolumeParameter<int> { public NoInterpIntParameter(int value, bool overrideState = false) : base(value) { } }
    public class FloatParameter : VolumeParameter<float> { public FloatParameter(float value, bool overrideState = false) : base(value) { } }
    public class MinFloatParameter : FloatParameter { public MinFloatParameter(float value, float min, bool overrideState = false) : base(value) { } }
    public class ClampedFloatParameter : FloatParameter { public ClampedFloatParameter(float value, float min, float max, bool overrideState = false) : base(value) { } }
    public class ColorParameter : VolumeParameter<Color> { public ColorParameter(Color value, bool overrideState = false) : base(value) { } }
    public class CubemapParameter : VolumeParameter<Texture> { public CubemapParameter(Texture value, bool overrideState = false) : base(value) { } }

    public class VolumeComponent : ScriptableObject { public bool active = true; }

    public sealed class VolumeStack
    {
        internal VolumeStack() { }
        readonly Dictionary<Type, VolumeComponent> components = new Dictionary<Type, VolumeComponent>();
        public T GetComponent<T>() where T : VolumeComponent
        {
            if (!components.TryGetValue(typeof(T), out var component)) components[typeof(T)] = component = ScriptableObject.CreateInstance<T>();
            return (T)component;
        }
    }

    public sealed class VolumeManager
    {
        VolumeManager() { }
        public static VolumeManager instance { get; } = new VolumeManager();
        public VolumeStack stack { get; set; } = new VolumeStack();
    }

    /// Switches by number.
    public struct BitArray128
    {
        ulong low, high;
        public bool this[uint index]
        {
            get => ((index < 64 ? low : high) >> (int)(index & 63) & 1) != 0;
            set
            {
                var bit = 1ul << (int)(index & 63);
                if (index < 64) low = value ? low | bit : low & ~bit; else high = value ? high | bit : high & ~bit;
            }
        }
    }
}
