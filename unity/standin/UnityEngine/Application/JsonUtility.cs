using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Runtime.Serialization;
using System.Text;

namespace UnityEngine
{
    /// JSON of what is serialised: keys are fields, keys without a field are passed over, and what is null comes as an
    /// instance with its defaults.
    public static class JsonUtility
    {
        public static string ToJson(object obj) => ToJson(obj, false);
        public static string ToJson(object obj, bool prettyPrint)
        {
            if (obj == null) return "";
            if (prettyPrint) throw new NotImplementedException("the stand-in writes JSON in one line");
            var text = new StringBuilder();
            Write(text, obj, obj.GetType());
            return text.ToString();
        }
        public static T FromJson<T>(string json) => (T)FromJson(json, typeof(T));
        public static object FromJson(string json, Type type)
        {
            if (string.IsNullOrEmpty(json)) return null;
            if (typeof(Object).IsAssignableFrom(type)) throw new ArgumentException("Cannot deserialize JSON to new instances of type '" + type.Name + ".'");
            var value = Parse(json);
            if (value == null) return null;
            return Read(value, type, null, 0);
        }
        public static void FromJsonOverwrite(string json, object objectToOverwrite) => Fill((Dictionary<string, object>)Parse(json), objectToOverwrite, 0);

        static object Parse(string json)
        {
            int at = 0;
            var value = Value(json, ref at);
            Space(json, ref at);
            if (at != json.Length) throw new ArgumentException("JSON parse error: The document root must not follow by other values.");
            return value;
        }
        static void Space(string json, ref int at) { while (at < json.Length && char.IsWhiteSpace(json[at])) at++; }
        static ArgumentException Wrong(int at) => new ArgumentException($"JSON parse error: Invalid value. (at character {at})");
        static object Value(string json, ref int at)
        {
            Space(json, ref at);
            if (at >= json.Length) throw Wrong(at);
            switch (json[at])
            {
                case '{':
                    var map = new Dictionary<string, object>();
                    for (at++; ;)
                    {
                        Space(json, ref at);
                        if (Take(json, ref at, '}')) return map;
                        if (map.Count > 0 && !Take(json, ref at, ',')) throw Wrong(at);
                        Space(json, ref at);
                        var key = Text(json, ref at);
                        Space(json, ref at);
                        if (!Take(json, ref at, ':')) throw Wrong(at);
                        map[key] = Value(json, ref at);
                    }
                case '[':
                    var list = new List<object>();
                    for (at++; ;)
                    {
                        Space(json, ref at);
                        if (Take(json, ref at, ']')) return list;
                        if (list.Count > 0 && !Take(json, ref at, ',')) throw Wrong(at);
                        list.Add(Value(json, ref at));
                    }
                case '"': return Text(json, ref at);
                default:
                    foreach (var (word, value) in new (string, object)[] { ("true", true), ("false", false), ("null", null) })
                        if (string.CompareOrdinal(json, at, word, 0, word.Length) == 0) { at += word.Length; return value; }
                    int start = at;
                    while (at < json.Length && "+-.0123456789eE".IndexOf(json[at]) >= 0) at++;
                    return at > start ? json.Substring(start, at - start).ToCharArray() : throw Wrong(at);
            }
        }
        static bool Take(string json, ref int at, char what) { if (at >= json.Length || json[at] != what) return false; at++; return true; }
        static string Text(string json, ref int at)
        {
            if (!Take(json, ref at, '"')) throw Wrong(at);
            var text = new StringBuilder();
            for (; ; at++)
            {
                if (at >= json.Length) throw Wrong(at);
                if (json[at] == '"') { at++; return text.ToString(); }
                if (json[at] != '\\') { text.Append(json[at]); continue; }
                if (++at >= json.Length) throw Wrong(at);
                switch (json[at])
                {
                    case 'n': text.Append('\n'); break;
                    case 'r': text.Append('\r'); break;
                    case 't': text.Append('\t'); break;
                    case 'b': text.Append('\b'); break;
                    case 'f': text.Append('\f'); break;
                    case 'u': text.Append((char)int.Parse(json.Substring(at + 1, 4), NumberStyles.HexNumber, CultureInfo.InvariantCulture)); at += 4; break;
                    default: text.Append(json[at]); break;
                }
            }
        }

        static object Read(object value, Type type, object before, int depth)
        {
            if (type == typeof(string)) return value is string text ? text : value is char[] digits ? new string(digits) : value == null ? "" : before;
            if (type == typeof(bool)) return value is bool flag ? flag : before ?? false;
            if (type.IsPrimitive || type.IsEnum)
            {
                if (!(value is char[] number)) return before ?? Activator.CreateInstance(type);
                var written = new string(number);
                if (type.IsEnum) return Enum.ToObject(type, long.Parse(written, CultureInfo.InvariantCulture));
                if (type == typeof(float)) return float.Parse(written, CultureInfo.InvariantCulture);
                if (type == typeof(double)) return double.Parse(written, CultureInfo.InvariantCulture);
                return Convert.ChangeType(decimal.Truncate(decimal.Parse(written, NumberStyles.Float, CultureInfo.InvariantCulture)), type, CultureInfo.InvariantCulture);
            }
            if (typeof(Object).IsAssignableFrom(type)) return before;
            if (type.IsArray)
            {
                var items = value as List<object> ?? new List<object>();
                var array = Array.CreateInstance(type.GetElementType(), items.Count);
                for (int i = 0; i < items.Count; i++) array.SetValue(Read(items[i], type.GetElementType(), null, depth + 1), i);
                return array;
            }
            if (typeof(IList).IsAssignableFrom(type))
            {
                var list = (IList)Activator.CreateInstance(type);
                foreach (var item in value as List<object> ?? new List<object>()) list.Add(Read(item, type.GetGenericArguments()[0], null, depth + 1));
                return list;
            }
            if (depth > 10) return before;
            var made = before ?? (type.IsValueType ? FormatterServices.GetUninitializedObject(type) : Activator.CreateInstance(type, true));
            if (value is Dictionary<string, object> map) Fill(map, made, depth);
            return made;
        }
        static void Fill(Dictionary<string, object> map, object made, int depth)
        {
            foreach (var field in StandIn.Serializer.FieldsOf(made.GetType()))
                if (map.TryGetValue(field.Name, out var value)) field.SetValue(made, Read(value, field.FieldType, field.GetValue(made), depth + 1));
            if (made is ISerializationCallbackReceiver receiver) receiver.OnAfterDeserialize();
        }

        static void Write(StringBuilder to, object value, Type type)
        {
            if (type == typeof(string)) { Quote(to, (string)value ?? ""); return; }
            if (type == typeof(bool)) { to.Append((bool)value ? "true" : "false"); return; }
            if (type.IsEnum) { to.Append(Convert.ToInt64(value)); return; }
            if (type == typeof(float)) { to.Append(((float)value).ToString("R", CultureInfo.InvariantCulture)); return; }
            if (type.IsPrimitive) { to.Append(Convert.ToString(value, CultureInfo.InvariantCulture)); return; }
            if (typeof(Object).IsAssignableFrom(type)) { to.Append("{\"instanceID\":").Append(value is Object item && item != null ? item.GetInstanceID() : 0).Append('}'); return; }
            if (typeof(IList).IsAssignableFrom(type))
            {
                var element = type.IsArray ? type.GetElementType() : type.GetGenericArguments()[0];
                to.Append('[');
                bool first = true;
                if (value != null) foreach (var item in (IList)value) { if (!first) to.Append(','); first = false; Write(to, item, element); }
                to.Append(']');
                return;
            }
            if (value == null) { to.Append("{}"); return; }
            if (value is ISerializationCallbackReceiver receiver) receiver.OnBeforeSerialize();
            to.Append('{');
            bool any = false;
            foreach (var field in StandIn.Serializer.FieldsOf(type))
            {
                if (any) to.Append(',');
                any = true;
                Quote(to, field.Name);
                to.Append(':');
                Write(to, field.GetValue(value), field.FieldType);
            }
            to.Append('}');
        }
        static void Quote(StringBuilder to, string text)
        {
            to.Append('"');
            foreach (var letter in text)
                if (letter == '"' || letter == '\\') to.Append('\\').Append(letter);
                else if (letter < ' ') to.Append("\\u").Append(((int)letter).ToString("x4"));
                else to.Append(letter);
            to.Append('"');
        }
    }
}
