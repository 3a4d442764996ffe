using System;
using UnityEngine;
using UnityEngine.UIElements;

namespace Lumivox
{
    /// <summary>Hue, saturation and brightness with a field for the hexadecimal notation: UI Toolkit has no colour picker in players.</summary>
    public sealed class ColorMixer : VisualElement
    {
        readonly VisualElement swatch = new VisualElement { name = "swatch" };
        readonly TextField hex = new TextField { name = "hex", isDelayed = true, tooltip = "The colour as red, green and blue in hexadecimal notation." };
        readonly Slider hue = Channel("hue", "Hue"), saturation = Channel("saturation", "Saturation"), brightness = Channel("brightness", "Brightness");

        /// <summary>Another colour was chosen.</summary>
        public event Action<Color> Changed;

        public ColorMixer()
        {
            style.flexDirection = FlexDirection.Row;
            style.alignItems = Align.Center;
            swatch.style.width = swatch.style.height = 18;
            swatch.style.marginRight = 4;
            hex.style.width = 72;
            Add(swatch);
            Add(hex);
            foreach (var slider in new[] { hue, saturation, brightness })
            {
                slider.RegisterValueChangedCallback(e =>
                {
                    e.StopPropagation();
                    Choose(Mixed(hue.value, saturation.value, brightness.value));
                });
                Add(slider);
            }
            hex.RegisterValueChangedCallback(e =>
            {
                e.StopPropagation();
                var text = e.newValue.Trim().TrimStart('#');
                if (text.Length != 6 || !ColorUtility.TryParseHtmlString("#" + text, out var color))
                {
                    ShowHex();
                    return;
                }
                Show(color);
                Changed?.Invoke(color);
            });
        }

        /// <summary>What is shown.</summary>
        public Color Value { get; private set; } = Color.white;

        /// <summary>Shows a colour without an event.</summary>
        public void Show(Color color)
        {
            color.a = 1;
            if (color != Value || hex.value == "")
            {
                var (h, s, v) = Parts(color);
                // Grey has no hue and black no saturation: what was chosen before stays.
                if (s > 0 && v > 0) hue.SetValueWithoutNotify(h);
                if (v > 0) saturation.SetValueWithoutNotify(s);
                brightness.SetValueWithoutNotify(v);
            }
            Value = color;
            ShowHex();
        }

        void Choose(Color color)
        {
            Value = color;
            ShowHex();
            Changed?.Invoke(color);
        }

        void ShowHex()
        {
            hex.SetValueWithoutNotify("#" + ColorUtility.ToHtmlStringRGB(Value));
            swatch.style.backgroundColor = Value;
        }

        /// The colour of a hue (red at 0, green at a third, blue at two thirds), a saturation and a brightness.
        internal static Color Mixed(float hue, float saturation, float brightness)
        {
            float Part(float offset)
            {
                var at = (offset + hue * 6) % 6;
                return brightness - brightness * saturation * Mathf.Clamp01(Mathf.Min(at, 4 - at));
            }
            return new Color(Part(5), Part(3), Part(1), 1);
        }

        /// Hue, saturation and brightness of a colour.
        internal static (float hue, float saturation, float brightness) Parts(Color color)
        {
            var high = Mathf.Max(color.r, Mathf.Max(color.g, color.b));
            var extent = high - Mathf.Min(color.r, Mathf.Min(color.g, color.b));
            if (extent <= 0) return (0, 0, high);
            var hue = high == color.r ? (color.g - color.b) / extent : high == color.g ? 2 + (color.b - color.r) / extent : 4 + (color.r - color.g) / extent;
            return ((hue + 6) % 6 / 6, extent / high, high);
        }

        static Slider Channel(string name, string title)
        {
            var slider = new Slider(0, 1) { name = name, tooltip = title };
            slider.style.width = 90;
            return slider;
        }
    }
}
