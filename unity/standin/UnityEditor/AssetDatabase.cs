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
            /// What importers call their objects: who is called so stays the same object when the file is imported again.
            public readonly Dictionary<string, Object> named = new Dictionary<string, Object>();
        }

        static bool isInImporter;
        static int depth;
        /// Whether files are being imported, or told of.
        internal static bool isImporting => depth > 0;

        /// Importers make nothing but their own results: in a process of its own, where Unity may run them, the rest throws.
        static void NotInImporter(string member)
        {
            if (isInImporter) throw new UnityException($"AssetDatabase.{member}() was called as part of running an import.");
        }

        internal static readonly Dictionary<string, Entry> entries = new Dictionary<string, Entry>();
        /// The project's folder, which has `Assets` in it.
        internal static string project => Path.GetDirectoryName(Application.dataPath);
        internal static string Full(string path) => Path.GetFullPath(Path.Combine(project, path));

        static string Clean(string path) => path?.Replace('\\', '/').TrimEnd('/');

        public static void CreateAsset(Object asset, string path)
        {
            NotInImporter("CreateAsset");
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
            NotInImporter("AddObjectToAsset");
            objectToAdd.isAsset = true;
            entries[GetAssetPath(assetObject)].objects.Add(objectToAdd);
        }

        public static void ImportAsset(string path) => ImportAsset(path, ImportAssetOptions.Default);
        public static void ImportAsset(string path, ImportAssetOptions options)
        {
            path = Clean(path);
            if (!File.Exists(Full(path))) return;
            entries.TryGetValue(path, out var before);
            if (before != null && before.importer == null && Override(path) == null && !(before.main is TextAsset)) return;
            var type = ImporterOf(path);
            depth++;
            try
            {
                if (type == null)
                {
                    if (before == null || before.importer != null) entries[path] = new Entry { guid = before?.guid ?? NewGuid(), main = Plain(path) };
                }
                else entries[path] = Imported(path, type, before);
                Tell(path);
            }
            finally
            {
                depth--;
            }
        }

        /// Unity goes by the last extension.
        static Type ImporterOf(string path)
        {
            var extension = Path.GetExtension(path).TrimStart('.').ToLowerInvariant();
            var all = StandIn.EditorTypes.Of<ScriptedImporter>().Select(type => (type, attribute: type.GetCustomAttribute<ScriptedImporterAttribute>())).ToList();
            var chosen = all.FirstOrDefault(one => one.type.Name == Override(path) && one.attribute.overrideFileExtensions.Contains(extension)).type;
            if (chosen != null) return chosen;
            var claiming = all.Where(one => one.attribute.fileExtensions.Contains(extension)).ToList();
            if (claiming.Count < 2) return claiming.Select(one => one.type).FirstOrDefault();
            Debug.LogError($"Multiple scripted importers are targeting the extension '{extension}' and have all been rejected: {string.Join(", ", claiming.Select(one => one.type.Name))}");
            return null;
        }

        static Entry Imported(string path, Type type, Entry before)
        {
            var entry = new Entry { guid = before?.guid ?? NewGuid(), importer = before?.importer?.GetType() == type ? before.importer : (AssetImporter)StandIn.Objects.Make(type) };
            entry.importer.path = path;
            // Importers may ask for their file's GUID.
            entries[path] = entry;
            entry.import = new AssetImportContext(path, entry.guid);
            isInImporter = true;
            try { ((ScriptedImporter)entry.importer).OnImportAsset(entry.import); }
            catch (Exception error) { entry.import.LogImportError("Exception: " + error); }
            finally { isInImporter = false; }
            entry.import.KeepThumbnail();
            entry.import.KeepArtifacts();
            Load(entry, before);
            if (entry.main != null) entry.main.name = Path.GetFileNameWithoutExtension(path);
            return entry;
        }

        /// What an importer made is written to a file, and ends; what is loaded of it has what is serialised, no more, and
        /// refers to assets only. What was loaded before is overwritten.
        static void Load(Entry entry, Entry before)
        {
            var map = new Dictionary<Object, Object>();
            foreach (var pair in entry.import.Objects)
            {
                Object loaded = pair.Value;
                if (pair.Value is ScriptableObject made)
                    loaded = before != null && before.named.TryGetValue(pair.Key, out var known) && known != null && known.GetType() == made.GetType() ? known : (Object)StandIn.Objects.Make(made.GetType());
                loaded.name = pair.Value.name;
                loaded.isAsset = true;
                map[pair.Value] = entry.named[pair.Key] = loaded;
                entry.objects.Add(loaded);
            }
            if (entry.import.mainObject != null) entry.main = map[entry.import.mainObject];
            foreach (var pair in map.Where(pair => pair.Key is ScriptableObject)) StandIn.Serializer.Copy(pair.Key, pair.Value, item => map.TryGetValue(item, out var own) ? own : item.isAsset ? item : null);
            foreach (var root in map.Keys.OfType<GameObject>()) BecomePrefab(root, map);
            foreach (var made in map.Keys.OfType<ScriptableObject>()) Object.DestroyImmediate(made);
            if (before != null) foreach (var gone in before.named.Values.Except(entry.objects).Where(gone => gone is ScriptableObject || gone is GameObject)) Object.DestroyImmediate(gone, true);
            foreach (var loaded in entry.objects.OfType<ScriptableObject>())
                if (loaded.isEnabled) StandIn.Messages.Send(loaded, "OnValidate");
                else loaded.Begin();
        }

        /// An object is the asset's from now on, in no scene; it refers to its own, and to assets.
        static void BecomePrefab(GameObject root, Dictionary<Object, Object> map)
        {
            var all = root.transform.WithChildren().ToArray();
            foreach (var at in all) (at.gameObject.isPrefab, at.gameObject.isAsset) = (true, true);
            StandIn.Lifecycle.Refresh(root);
            var own = new HashSet<Object>(all.SelectMany(at => at.gameObject.components));
            foreach (var script in own.OfType<MonoBehaviour>())
                StandIn.Serializer.Copy(script, script, item => map.TryGetValue(item, out var loaded) ? loaded : own.Contains(item) || item.isAsset ? item : null);
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
        public static void SetImporterOverride<T>(string path) where T : AssetImporter
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

        public static void Refresh() => Refresh(ImportAssetOptions.Default);
        public static void Refresh(ImportAssetOptions options)
        {
            NotInImporter("Refresh");
            foreach (var path in entries.Keys.Where(path => !File.Exists(Full(path))).ToList()) entries.Remove(path);
            foreach (var file in Directory.EnumerateFiles(Full("Assets"), "*", SearchOption.AllDirectories).OrderBy(file => file, StringComparer.Ordinal))
            {
                var path = Clean(Path.GetRelativePath(project, file));
                if (!path.Split('/').Any(part => part.StartsWith(".") || part.EndsWith("~")) && !entries.ContainsKey(path)) ImportAsset(path);
            }
        }

        public static T LoadAssetAtPath<T>(string assetPath) where T : Object => entries.TryGetValue(Clean(assetPath), out var entry) ? entry.objects.Prepend(entry.main).OfType<T>().FirstOrDefault() : null;
        public static Object LoadMainAssetAtPath(string assetPath) => LoadAssetAtPath<Object>(assetPath);
        public static Type GetMainAssetTypeAtPath(string assetPath) => LoadMainAssetAtPath(assetPath)?.GetType();
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
            NotInImporter("CreateFolder");
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
            NotInImporter("DeleteAsset");
            path = Clean(path);
            if (!Directory.Exists(Full(path)))
            {
                File.Delete(Full(path));
                return entries.Remove(path);
            }
            Directory.Delete(Full(path), true);
            foreach (var inside in entries.Keys.Where(one => one.StartsWith(path + "/")).ToList()) entries.Remove(inside);
            return true;
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

        public static void SaveAssets() { NotInImporter("SaveAssets"); foreach (var one in entries.Values.SelectMany(entry => entry.objects)) EditorUtility.ClearDirty(one); }
        public static void SaveAssetIfDirty(Object obj) => EditorUtility.ClearDirty(obj);
        public static void StartAssetEditing() { }
        public static void StopAssetEditing() => Refresh();

        /// An empty project.
        internal static void Reset()
        {
            entries.Clear();
            overrides.Clear();
            dependencies.Clear();
            foreach (var folder in new[] { "Assets", "Library", "Temp" })
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
                foreach (var name in entry.named.Keys.ToList()) entry.named[name] = StandIn.Objects.Find(entry.named[name].instanceID) ?? entry.named[name];
                if (!(entry.main is null)) entry.main = StandIn.Objects.Find(entry.main.instanceID) ?? entry.main;
                if (!(entry.importer is null)) entry.importer = (AssetImporter)(StandIn.Objects.Find(entry.importer.instanceID) ?? entry.importer);
            }
        }

        /// Tells whoever processes assets what was imported.
        static void Tell(params string[] imported)
        {
            var none = Array.Empty<string>();
            foreach (var type in StandIn.EditorTypes.Of<AssetPostprocessor>())
                try { type.GetMethod("OnPostprocessAllAssets", BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic)?.Invoke(null, new object[] { imported, none, none, none }); }
                catch (TargetInvocationException error) { Debug.LogException(error.InnerException); }
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
#if UNITY_6000_5_OR_NEWER
        public ArtifactKey(GUID guid) { this.guid = guid; importerType = null; }
#else
        public ArtifactKey(GUID g) { guid = g; importerType = null; }
#endif
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
        readonly List<string> requested = new List<string>();
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
        public void SetOutputArtifactFile(string extension, string path)
        {
            if (!File.Exists(path)) throw new FileNotFoundException($"{path} is not there");
            File.Copy(path, AssetDatabase.Full(GetOutputArtifactFilePath(extension)), true);
        }
        /// A file for the time of the import; afterwards it lies among the results.
        public string GetOutputArtifactFilePath(string fileName)
        {
            var path = $"Temp/Artifacts/{Name}.{fileName}";
            Directory.CreateDirectory(Path.GetDirectoryName(AssetDatabase.Full(path)));
            if (!requested.Contains(path)) requested.Add(path);
            return path;
        }
        string Name
        {
            get { using (var hash = MD5.Create()) return BitConverter.ToString(hash.ComputeHash(Encoding.UTF8.GetBytes(guid + assetPath))).Replace("-", "").ToLowerInvariant(); }
        }
        internal void KeepArtifacts()
        {
            foreach (var path in requested.Where(path => File.Exists(AssetDatabase.Full(path))))
            {
                var kept = $"Library/Artifacts/{Name.Substring(0, 2)}/{Path.GetFileName(path)}";
                Directory.CreateDirectory(Path.GetDirectoryName(AssetDatabase.Full(kept)));
                File.Delete(AssetDatabase.Full(kept));
                File.Move(AssetDatabase.Full(path), AssetDatabase.Full(kept));
                Artifacts.Add(kept);
            }
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
