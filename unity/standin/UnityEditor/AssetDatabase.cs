// A project's assets: objects in memory under the paths of files in a real folder, imported by what claims their extension.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Security.Cryptography;
using System.Text;
using UnityEditor.AssetImporters;
using UnityEngine;
using Object = UnityEngine.Object;

namespace UnityEditor
{
    [Flags] public enum ImportAssetOptions { Default = 0, ForceUpdate = 1, ForceSynchronousImport = 8 }

    public sealed class AssetDatabase
    {
        internal sealed class Entry
        {
            public string guid;
            public AssetImporter importer;
            public AssetImportContext import;
            public readonly List<Object> objects = new List<Object>();
            public Object main;
        }

        internal static readonly Dictionary<string, Entry> entries = new Dictionary<string, Entry>();
        /// The project's folder, which has `Assets` in it.
        internal static string project => Path.GetDirectoryName(Application.dataPath);
        internal static string Full(string path) => Path.GetFullPath(Path.Combine(project, path));

        static string Clean(string path) => path?.Replace('\\', '/').TrimEnd('/');

        public static void CreateAsset(Object asset, string path)
        {
            path = Clean(path);
            if (asset == null) throw new ArgumentNullException(nameof(asset));
            if (path == null || !path.StartsWith("Assets/")) throw new UnityException($"Creating asset at path {path} failed: it is not in the project.");
            if (Path.GetExtension(path) == "") throw new UnityException($"Creating asset at path {path} failed: it has no extension.");
            if (!Directory.Exists(Path.GetDirectoryName(Full(path)))) throw new UnityException($"Creating asset at path {path} failed: its folder is not there.");
            if (Contains(asset)) throw new UnityException($"Couldn't add object to asset file because {asset.name} is already an asset at '{GetAssetPath(asset)}'!");
            if (entries.ContainsKey(path)) DeleteAsset(path);
            File.WriteAllText(Full(path), asset.GetType().FullName);
            asset.name = Path.GetFileNameWithoutExtension(path);
            asset.isAsset = true;
            var entry = new Entry { guid = NewGuid(), main = asset };
            entry.objects.Add(asset);
            entries[path] = entry;
        }

        static string NewGuid() => Guid.NewGuid().ToString("N");

        public static void AddObjectToAsset(Object objectToAdd, Object assetObject)
        {
            objectToAdd.isAsset = true;
            entries[GetAssetPath(assetObject)].objects.Add(objectToAdd);
        }

        public static void ImportAsset(string path, ImportAssetOptions options = ImportAssetOptions.Default)
        {
            path = Clean(path);
            if (!File.Exists(Full(path))) return;
            entries.TryGetValue(path, out var before);
            if (before != null && before.importer == null && Override(path) == null && !(before.main is TextAsset)) return;
            // Unity goes by the last extension.
            var extension = Path.GetExtension(path).TrimStart('.').ToLowerInvariant();
            var type = StandIn.EditorTypes.Of<ScriptedImporter>().FirstOrDefault(one => one.GetCustomAttribute<ScriptedImporterAttribute>().fileExtensions.Contains(extension));
            var chosen = StandIn.EditorTypes.Of<ScriptedImporter>().FirstOrDefault(one => one.Name == Override(path) && (one.GetCustomAttribute<ScriptedImporterAttribute>().overrideFileExtensions.Contains(extension)));
            type = chosen ?? type;
            if (type == null)
            {
                if (before == null || before.importer != null) entries[path] = new Entry { guid = before?.guid ?? NewGuid(), main = Plain(path) };
                Tell(path);
                return;
            }
            var entry = new Entry { guid = before?.guid ?? NewGuid(), importer = before?.importer?.GetType() == type ? before.importer : (AssetImporter)StandIn.Objects.Make(type) };
            entry.importer.path = path;
            entries[path] = entry;
            entry.import = new AssetImportContext(path, entry.guid);
            try { ((ScriptedImporter)entry.importer).OnImportAsset(entry.import); }
            catch (Exception error) { entry.import.LogImportError("Exception: " + error); }
            entry.import.KeepThumbnail();
            entry.objects.AddRange(entry.import.Objects.Values);
            entry.main = entry.import.mainObject;
            foreach (var one in entry.objects) one.isAsset = true;
            if (entry.main != null) entry.main.name = Path.GetFileNameWithoutExtension(path);
            Tell(path);
        }

        static Object Plain(string path)
        {
            var plain = Path.GetExtension(path) == ".tss" ? (Object)ScriptableObject.CreateInstance<UnityEngine.UIElements.ThemeStyleSheet>() : new TextAsset();
            plain.name = Path.GetFileNameWithoutExtension(path);
            plain.isAsset = true;
            return plain;
        }

        static readonly Dictionary<string, string> overrides = new Dictionary<string, string>();
        static string Override(string path) => overrides.TryGetValue(path, out var type) ? type : null;
        public static void SetImporterOverride<T>(string path) where T : ScriptedImporter
        {
            if (!typeof(T).GetCustomAttribute<ScriptedImporterAttribute>().overrideFileExtensions.Contains(Path.GetExtension(path).TrimStart('.').ToLowerInvariant())) throw new InvalidOperationException($"{typeof(T).Name} does not import {path}");
            overrides[Clean(path)] = typeof(T).Name;
            ImportAsset(path, ImportAssetOptions.ForceUpdate);
        }
        public static void ClearImporterOverride(string path)
        {
            overrides.Remove(Clean(path));
            ImportAsset(path, ImportAssetOptions.ForceUpdate);
        }
        public static Type GetImporterOverride(string path) => StandIn.EditorTypes.Of<ScriptedImporter>().FirstOrDefault(one => one.Name == Override(Clean(path)));

        public static void Refresh(ImportAssetOptions options = ImportAssetOptions.Default)
        {
            foreach (var path in entries.Keys.Where(path => !File.Exists(Full(path))).ToList()) entries.Remove(path);
            foreach (var file in Directory.EnumerateFiles(Full("Assets"), "*", SearchOption.AllDirectories).OrderBy(file => file, StringComparer.Ordinal))
            {
                var path = Clean(Path.GetRelativePath(project, file));
                if (!path.Split('/').Any(part => part.StartsWith(".") || part.EndsWith("~")) && !entries.ContainsKey(path)) ImportAsset(path);
            }
        }

        public static T LoadAssetAtPath<T>(string assetPath) where T : Object => entries.TryGetValue(Clean(assetPath), out var entry) ? entry.objects.Prepend(entry.main).OfType<T>().FirstOrDefault() : null;
        public static Object LoadMainAssetAtPath(string assetPath) => LoadAssetAtPath<Object>(assetPath);
        public static Type GetMainAssetTypeAtPath(string path) => LoadMainAssetAtPath(path)?.GetType();
        public static string GetAssetPath(Object assetObject) => entries.FirstOrDefault(pair => pair.Value.objects.Contains(assetObject) || pair.Value.main == assetObject).Key ?? "";
        public static bool Contains(Object obj) => GetAssetPath(obj) != "";
        public static bool IsMainAsset(Object obj) => entries.Values.Any(entry => entry.main == obj);
        public static bool IsSubAsset(Object obj) => Contains(obj) && !IsMainAsset(obj);
        public static string AssetPathToGUID(string path) => entries.TryGetValue(Clean(path), out var entry) ? entry.guid : "";
        public static string GUIDToAssetPath(string guid) => entries.FirstOrDefault(pair => pair.Value.guid == guid).Key ?? "";
        public static GUID GUIDFromAssetPath(string path) => new GUID(AssetPathToGUID(path));
        public static bool TryGetGUIDAndLocalFileIdentifier(Object obj, out string guid, out long localId)
        {
            guid = AssetPathToGUID(GetAssetPath(obj));
            localId = obj.GetInstanceID();
            return guid != "";
        }
        public static bool IsValidFolder(string path) => path != null && (Clean(path) == "Assets" || Clean(path).StartsWith("Assets/")) && Directory.Exists(Full(path));
        public static string CreateFolder(string parentFolder, string newFolderName)
        {
            if (!IsValidFolder(parentFolder)) return "";
            Directory.CreateDirectory(Full(parentFolder + "/" + newFolderName));
            return NewGuid();
        }
        public static string GenerateUniqueAssetPath(string path)
        {
            path = Clean(path);
            var (stem, extension) = (path.Substring(0, path.Length - Path.GetExtension(path).Length), Path.GetExtension(path));
            var unique = path;
            for (var i = 1; File.Exists(Full(unique)); i++) unique = $"{stem} {i}{extension}";
            return unique;
        }
        public static bool DeleteAsset(string path)
        {
            File.Delete(Full(path));
            return entries.Remove(Clean(path));
        }
        public static string[] FindAssets(string filter) => FindAssets(filter, null);
        public static string[] FindAssets(string filter, string[] searchInFolders)
        {
            if (!filter.StartsWith("t:")) throw new NotImplementedException("the stand-in finds assets by type only");
            return entries.Where(pair => pair.Value.objects.Append(pair.Value.main).Any(one => one != null && one.GetType().Name == filter.Substring(2))
                && (searchInFolders == null || searchInFolders.Any(folder => pair.Key.StartsWith(Clean(folder) + "/")))).Select(pair => pair.Value.guid).ToArray();
        }

        /// What tests say that an asset, such as a scene, refers to.
        internal static readonly Dictionary<string, string[]> dependencies = new Dictionary<string, string[]>();
        public static string[] GetDependencies(string pathName, bool recursive) => GetDependencies(new[] { pathName }, recursive);
        public static string[] GetDependencies(string[] pathNames, bool recursive)
        {
            var found = new List<string>();
            void Add(string path)
            {
                if (found.Contains(path)) return;
                found.Add(path);
                if (recursive && dependencies.TryGetValue(path, out var more)) foreach (var one in more) Add(one);
            }
            foreach (var path in pathNames)
            {
                Add(path);
                if (!recursive && dependencies.TryGetValue(path, out var more)) found.AddRange(more);
            }
            return found.Distinct().ToArray();
        }
        public static string[] GetAllAssetPaths() => entries.Keys.ToArray();
        public static Object[] LoadAllAssetsAtPath(string assetPath) => entries.TryGetValue(Clean(assetPath), out var entry) ? entry.objects.Where(one => one != null).ToArray() : Array.Empty<Object>();

        public static void SaveAssets() { foreach (var one in entries.Values.SelectMany(entry => entry.objects)) EditorUtility.ClearDirty(one); }
        public static void SaveAssetIfDirty(Object obj) => EditorUtility.ClearDirty(obj);
        public static void StartAssetEditing() { }
        public static void StopAssetEditing() => Refresh();

        /// An empty project.
        internal static void Reset()
        {
            entries.Clear();
            overrides.Clear();
            dependencies.Clear();
            foreach (var folder in new[] { "Assets", "Library" })
            {
                if (Directory.Exists(Full(folder))) Directory.Delete(Full(folder), true);
                Directory.CreateDirectory(Full(folder));
            }
        }

        /// Objects are others after a domain reload, under the same numbers.
        internal static void TakeReplaced()
        {
            foreach (var entry in entries.Values)
            {
                for (var i = 0; i < entry.objects.Count; i++) entry.objects[i] = StandIn.Objects.Find(entry.objects[i].instanceID) ?? entry.objects[i];
                if (!(entry.main is null)) entry.main = StandIn.Objects.Find(entry.main.instanceID) ?? entry.main;
                if (!(entry.importer is null)) entry.importer = (AssetImporter)(StandIn.Objects.Find(entry.importer.instanceID) ?? entry.importer);
            }
        }

        /// Tells whoever processes assets what was imported.
        static void Tell(params string[] imported)
        {
            var none = Array.Empty<string>();
            foreach (var type in StandIn.EditorTypes.Of<AssetPostprocessor>())
                type.GetMethod("OnPostprocessAllAssets", BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic)?.Invoke(null, new object[] { imported, none, none, none });
        }
    }

    public class AssetImporter : Object
    {
        internal string path;
        public string assetPath => path;
        public string userData { get; set; } = "";
        public static AssetImporter GetAtPath(string path) => AssetDatabase.entries.TryGetValue(path, out var entry) ? entry.importer : null;
        public void SaveAndReimport() => AssetDatabase.ImportAsset(path, ImportAssetOptions.ForceUpdate);
    }

    public class AssetPostprocessor
    {
        public string assetPath { get; set; }
        public AssetImportContext context { get; internal set; }
        public virtual uint GetVersion() => 0;
        public virtual int GetPostprocessOrder() => 0;
    }

    public sealed class PlayerSettings : Object
    {
        PlayerSettings() { }
        internal static Object[] preloaded = Array.Empty<Object>();
        public static Object[] GetPreloadedAssets() => preloaded;
    }

    public class EditorBuildSettingsScene
    {
        public string path { get; set; }
        public bool enabled { get; set; }
        public EditorBuildSettingsScene(string path, bool enabled) { this.path = path; this.enabled = enabled; }
    }

    public class EditorBuildSettings : Object { EditorBuildSettings() { } public static EditorBuildSettingsScene[] scenes { get; set; } = Array.Empty<EditorBuildSettingsScene>(); }
}

namespace UnityEditor.Experimental
{
#if UNITY_6000_5_OR_NEWER
    using ArtifactID = ImportResultID;
#endif

    public struct ArtifactKey
    {
        public GUID guid;
        public Type importerType;
        public ArtifactKey(GUID g) { guid = g; importerType = null; }
        public bool isValid => !guid.Empty();
    }

    // It has another name since 6000.5.
#if UNITY_6000_5_OR_NEWER
    public struct ImportResultID
#else
    public struct ArtifactID
#endif
    {
        internal string guid;
        public bool isValid => guid != null;
    }

    public sealed class AssetDatabaseExperimental
    {
        public static ArtifactID LookupArtifact(ArtifactKey artifactKey)
        {
            var entry = AssetDatabase.entries.Values.FirstOrDefault(one => one.guid == artifactKey.guid.ToString());
            return entry?.import == null ? default : new ArtifactID { guid = entry.guid };
        }
        public static bool GetArtifactPaths(ArtifactID hash, out string[] paths)
        {
            var entry = AssetDatabase.entries.Values.FirstOrDefault(one => one.guid == hash.guid);
            paths = entry?.import?.Artifacts.ToArray() ?? Array.Empty<string>();
            return paths.Length > 0;
        }
    }
}

namespace UnityEditor.AssetImporters
{
    [AttributeUsage(AttributeTargets.Class, Inherited = false)]
    public class ScriptedImporterAttribute : Attribute
    {
        public int version { get; }
        public int importQueuePriority { get; }
        public string[] fileExtensions { get; }
        public string[] overrideFileExtensions { get; } = Array.Empty<string>();
        public bool AllowCaching;
        public ScriptedImporterAttribute(int version, string ext) : this(version, new[] { ext }) { }
        public ScriptedImporterAttribute(int version, string[] exts) : this(version, exts, Array.Empty<string>()) { }
        public ScriptedImporterAttribute(int version, string[] exts, string[] overrideExts) : this(version, exts, overrideExts, 0) { }
        public ScriptedImporterAttribute(int version, string[] exts, string[] overrideExts, int importQueueOffset)
        {
            this.version = version;
            fileExtensions = exts ?? Array.Empty<string>();
            overrideFileExtensions = overrideExts ?? Array.Empty<string>();
            importQueuePriority = importQueueOffset;
        }
    }

    public abstract class ScriptedImporter : AssetImporter { public abstract void OnImportAsset(AssetImportContext ctx); }

    public class ScriptedImporterEditor : AssetImporterEditor { }

    public abstract class AssetImporterEditor : Editor
    {
        protected void ApplyRevertGUI() { }
        public virtual bool showImportedObject => true;
    }

    public class AssetImportContext
    {
        readonly string guid;
        internal readonly Dictionary<string, Object> Objects = new Dictionary<string, Object>();
        internal readonly List<string> Artifacts = new List<string>(), Errors = new List<string>(), Warnings = new List<string>(), SourceDependencies = new List<string>();
        internal Texture2D thumbnail;
        internal AssetImportContext(string path, string guid) { assetPath = path; this.guid = guid; }
        public string assetPath { get; }
        public Object mainObject { get; private set; }
        public void AddObjectToAsset(string identifier, Object obj) => AddObjectToAsset(identifier, obj, null);
        public void AddObjectToAsset(string identifier, Object obj, Texture2D thumbnail)
        {
            if (obj == null) throw new ArgumentNullException(nameof(obj));
            if (Objects.ContainsKey(identifier)) throw new ArgumentException($"{identifier} was added already");
            Objects.Add(identifier, obj);
            if (thumbnail != null) this.thumbnail = thumbnail;
        }
        /// The project window's own, which outlives what the importer made.
        internal void KeepThumbnail()
        {
            if (thumbnail == null) return;
            var copy = new Texture2D(thumbnail.width, thumbnail.height, TextureFormat.RGBA32, false) { isAsset = true };
            copy.LoadRawTextureData(thumbnail.GetRawTextureData());
            copy.Apply();
            StandIn.Live.Remove(copy);
            thumbnail = copy;
        }
        public void SetMainObject(Object obj)
        {
            if (!Objects.ContainsValue(obj)) throw new ArgumentException("the main object has to be added before");
            mainObject = obj;
        }
        public void DependsOnSourceAsset(string path) => SourceDependencies.Add(path);
        public void LogImportError(string msg, Object obj = null) { Errors.Add(msg); StandIn.Dialogs.ImportErrors.Add(msg); }
        public void LogImportWarning(string msg, Object obj = null) => Warnings.Add(msg);
        public void SetOutputArtifactFile(string fileName, string filePath)
        {
            if (!File.Exists(filePath)) throw new FileNotFoundException($"{filePath} is not there");
            File.Copy(filePath, AssetDatabase.Full(GetOutputArtifactFilePath(fileName)), true);
        }
        public string GetOutputArtifactFilePath(string fileName)
        {
            string name;
            using (var hash = MD5.Create()) name = BitConverter.ToString(hash.ComputeHash(Encoding.UTF8.GetBytes(guid + assetPath))).Replace("-", "").ToLowerInvariant();
            var path = $"Library/Artifacts/{name.Substring(0, 2)}/{name}.{fileName}";
            Directory.CreateDirectory(Path.GetDirectoryName(AssetDatabase.Full(path)));
            if (!Artifacts.Contains(path)) Artifacts.Add(path);
            return path;
        }
    }
}

namespace UnityEditor
{
    public class FileUtil
    {
        /// A name in the project's own folder for what is there for a moment only.
        public static string GetUniqueTempPathInProject() => $"Temp/UnityTempFile-{Guid.NewGuid():N}";
    }
}
