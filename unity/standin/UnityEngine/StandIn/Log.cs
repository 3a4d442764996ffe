// What is logged, and what a test expects to be.
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;

namespace StandIn
{
    public static class Log
    {
        public struct Entry { public LogType type; public string message; public string stack; }
        static readonly List<Entry> all = new List<Entry>();
        static readonly List<(LogType type, string part)> expected = new List<(LogType, string)>();
        /// Whether messages are printed as they come.
        public static bool isPrinted = Environment.GetEnvironmentVariable("STANDIN_LOG") == "1";

        public static Entry[] entries { get { lock (all) return all.ToArray(); } }
        /// Says that such a message will be logged: it must be, and does not fail the test.
        public static void Expect(LogType type, string part) { lock (all) expected.Add((type, part)); }
        public static int Count(LogType type, string part = "") => entries.Count(entry => entry.type == type && entry.message.Contains(part));

        internal static void Add(LogType type, string message, string stack)
        {
            lock (all) all.Add(new Entry { type = type, message = message, stack = stack });
            if (isPrinted) Console.WriteLine($"    [{type}] {message}");
        }
        public static void Clear() { lock (all) { all.Clear(); expected.Clear(); } }

        /// What is wrong about what was logged since the last `Clear`, a line each.
        public static string Faults()
        {
            lock (all)
            {
                var left = new List<Entry>(all.Where(entry => entry.type != LogType.Log));
                var lines = new List<string>();
                foreach (var (type, part) in expected)
                {
                    int at = left.FindIndex(entry => entry.type == type && entry.message.Contains(part));
                    if (at < 0) lines.Add($"expected to be logged, but was not: [{type}] {part}");
                    else left.RemoveAt(at);
                }
                // A warning is no fault, unless a test says otherwise by looking.
                lines.AddRange(left.Where(entry => entry.type != LogType.Warning).Select(entry => $"logged: [{entry.type}] {entry.message}{(entry.stack == null ? "" : "\n" + entry.stack)}"));
                return string.Join("\n", lines);
            }
        }
    }

    public static class Half
    {
        public static ushort FromSingle(float value)
        {
            int bits = BitConverter.SingleToInt32Bits(value), sign = bits >> 16 & 0x8000, exponent = (bits >> 23 & 0xff) - 112, mantissa = bits & 0x7fffff;
            if (exponent == 0xff - 112) return (ushort)(sign | 0x7c00 | (mantissa != 0 ? 0x200 : 0));
            if (exponent >= 31) return (ushort)(sign | 0x7c00);
            if (exponent <= 0)
            {
                if (exponent < -10) return (ushort)sign;
                mantissa |= 0x800000;
                int shift = 14 - exponent, half = mantissa >> shift, rest = mantissa & (1 << shift) - 1, middle = 1 << shift - 1;
                if (rest > middle || rest == middle && (half & 1) == 1) half++;
                return (ushort)(sign | half);
            }
            int rounded = exponent << 10 | mantissa >> 13, left = mantissa & 0x1fff;
            if (left > 0x1000 || left == 0x1000 && (rounded & 1) == 1) rounded++;
            return (ushort)(sign | rounded);
        }
        public static float ToSingle(ushort half)
        {
            int sign = (half & 0x8000) << 16, exponent = half >> 10 & 31, mantissa = half & 0x3ff;
            if (exponent == 0) return (sign != 0 ? -1 : 1) * mantissa * 5.9604645e-8f;
            if (exponent == 31) return BitConverter.Int32BitsToSingle(sign | 0x7f800000 | mantissa << 13);
            return BitConverter.Int32BitsToSingle(sign | exponent + 112 << 23 | mantissa << 13);
        }
    }
}
