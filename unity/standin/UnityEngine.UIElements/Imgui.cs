// Types of UnityEngine that interfaces share: modifiers, alignment, contents.
using System;

namespace UnityEngine
{
    [Flags] public enum EventModifiers { None = 0, Shift = 1, Control = 2, Alt = 4, Command = 8, Numeric = 16, CapsLock = 32, FunctionKey = 64 }
    public enum TextAnchor { UpperLeft, UpperCenter, UpperRight, MiddleLeft, MiddleCenter, MiddleRight, LowerLeft, LowerCenter, LowerRight }
    public enum FontStyle { Normal, Bold, Italic, BoldAndItalic }
    public enum ScaleMode { StretchToFill, ScaleAndCrop, ScaleToFit }

    public class GUIContent
    {
        public string text { get; set; } = "";
        public string tooltip { get; set; } = "";
        public Texture image { get; set; }
        public GUIContent() { }
        public GUIContent(string text) { this.text = text ?? ""; }
        public GUIContent(string text, string tooltip) { this.text = text; this.tooltip = tooltip; }
    }

    public sealed class GUIStyle { }

    public class ColorUtility
    {
        static int Byte(float channel) => Math.Max(0, Math.Min(255, (int)Math.Round(channel * 255)));
        public static string ToHtmlStringRGB(Color color) => $"{Byte(color.r):X2}{Byte(color.g):X2}{Byte(color.b):X2}";
        public static bool TryParseHtmlString(string htmlString, out Color color)
        {
            color = new Color(1, 1, 1, 1);
            if (htmlString == null || htmlString.Length != 7 || htmlString[0] != '#' || !int.TryParse(htmlString.Substring(1), System.Globalization.NumberStyles.HexNumber, System.Globalization.CultureInfo.InvariantCulture, out var rgb)) return false;
            color = new Color((rgb >> 16) / 255f, (rgb >> 8 & 255) / 255f, (rgb & 255) / 255f, 1);
            return true;
        }
    }
}
