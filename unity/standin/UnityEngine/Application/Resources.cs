using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;

namespace UnityEngine
{
    /// What lies in folders named Resources, of the packages and of the project.
    public sealed class Resources
    {
        static readonly Dictionary<string, Object> loaded = new Dictionary<string, Object>();
        static IEnumerable<string> Files() => StandIn.Packages.Files("*").Where(file => !file.EndsWith(".meta"));
        /// What a test puts at a path, for types that the stand-in does not read from files.
        internal static readonly Dictionary<string, Object> placed = new Dictionary<string, Object>();

        static Object LoadFile(string file)
        {
            if (loaded.TryGetValue(file, out var found) && found != null) return found;
            switch (Path.GetExtension(file))
            {
                case ".compute": return loaded[file] = ComputeShader.Load(file);
                case ".shader": return loaded[file] = Shader.Load(file);
                case ".txt": case ".json": case ".csv": case ".xml": return loaded[file] = new TextAsset(File.ReadAllBytes(file)) { name = Path.GetFileNameWithoutExtension(file), isAsset = true };
                case ".bytes": return loaded[file] = new TextAsset(File.ReadAllBytes(file)) { name = Path.GetFileNameWithoutExtension(file), isAsset = true };
                default: throw new NotImplementedException($"the stand-in loads no {Path.GetExtension(file)} ({file})");
            }
        }
        internal static T LoadAssetFile<T>(string file) where T : Object => LoadFile(file) as T;
        public static Object Load(string path) => Load<Object>(path);
        public static Object Load(string path, Type systemTypeInstance) { var found = Load<Object>(path); return systemTypeInstance.IsInstanceOfType(found) ? found : null; }
        public static T Load<T>(string path) where T : Object
        {
            StandIn.Threads.Main("Resources.Load");
            if (placed.TryGetValue(path, out var put)) return put as T;
            foreach (var file in Files())
            {
                int at = file.LastIndexOf("/Resources/", StringComparison.Ordinal);
                if (at < 0 || Path.ChangeExtension(file.Substring(at + 11), null) != path) continue;
                // Several kinds of files may share a name.
                bool fits = typeof(T) == typeof(Object) || typeof(T) == typeof(ComputeShader) == (Path.GetExtension(file) == ".compute") && typeof(T) == typeof(Shader) == (Path.GetExtension(file) == ".shader");
                if (fits && LoadFile(file) is T found) return found;
            }
            return null;
        }
        public static ResourceRequest LoadAsync<T>(string path) where T : Object { var request = new ResourceRequest { asset = Load<T>(path) }; request.Finish(); return request; }
        public static T[] LoadAll<T>(string path) where T : Object => throw new NotImplementedException("the stand-in loads one resource at a time");
        public static T[] FindObjectsOfTypeAll<T>() where T : Object { StandIn.Threads.Main("FindObjectsOfTypeAll"); return StandIn.Objects.All().OfType<T>().ToArray(); }
        public static void UnloadAsset(Object assetToUnload) { }
        public static AsyncOperation UnloadUnusedAssets() { var done = new AsyncOperation(); done.Finish(); return done; }
        public static T GetBuiltinResource<T>(string path) where T : Object => Mesh.own.TryGetValue(path, out var mesh) && mesh is T found ? found : throw new NotImplementedException($"the stand-in has no {path}");
        /// A player holds what is in Resources; the editor, all.
        internal static IEnumerable<Shader> Shaders() => StandIn.Packages.Files("*.shader").Select(file => (Shader)LoadFile(file)).Concat(placed.Values.OfType<Shader>());
    }
    public class ResourceRequest : AsyncOperation { public Object asset { get; internal set; } }

    public static class ImageConversion
    {
        public static byte[] EncodeToPNG(this Texture2D tex)
        {
            var colors = tex.GetPixels();
            var picture = new StandIn.Picture(tex.width, tex.height);
            for (int i = 0; i < colors.Length; i++) picture.pixels[i] = colors[i];
            return picture.ToPng(false);
        }
        /// Becomes as large as the picture; false where it is none.
        public static bool LoadImage(this Texture2D tex, byte[] data)
        {
            if (!StandIn.Png.TryRead(data, out var width, out var height, out var pixels)) return false;
            tex.Resize(width, height);
            tex.SetPixels32(pixels);
            tex.Apply();
            return true;
        }
    }
}
