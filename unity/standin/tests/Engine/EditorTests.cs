// What the stand-in's editor does as Unity's: windows, importers.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using NUnit.Framework;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEngine;
using Object = UnityEngine.Object;

namespace StandIn.Tests
{
    class Window : EditorWindow
    {
        internal readonly List<string> heard = new List<string>();
        void Awake() => heard.Add("Awake");
        void OnEnable() => heard.Add("OnEnable");
        void CreateGUI() => heard.Add("CreateGUI");
        void OnDisable() => heard.Add("OnDisable");
        void OnDestroy() => heard.Add("OnDestroy");
    }

    class Inner : ScriptableObject { public int value; }
    class Outer : ScriptableObject { public Inner inner; public ScriptableObject lost; public int value; internal int unsaved; internal int enabledCount; void OnEnable() => enabledCount++; }

    [ScriptedImporter(1, "outer")]
    class OuterImporter : ScriptedImporter
    {
        internal static Action<AssetImportContext> during;
        internal static int value;
        public override void OnImportAsset(AssetImportContext ctx)
        {
            var (outer, inner) = (ScriptableObject.CreateInstance<Outer>(), ScriptableObject.CreateInstance<Inner>());
            (outer.value, outer.unsaved, outer.inner, outer.lost, inner.value) = (value, value, inner, ScriptableObject.CreateInstance<Inner>(), value);
            ctx.AddObjectToAsset("outer", outer);
            ctx.AddObjectToAsset("inner", inner);
            ctx.SetMainObject(outer);
            during?.Invoke(ctx);
        }
    }

    [ScriptedImporter(1, "twice")] class OneImporter : ScriptedImporter { public override void OnImportAsset(AssetImportContext ctx) { } }
    [ScriptedImporter(1, "twice")] class OtherImporter : ScriptedImporter { public override void OnImportAsset(AssetImportContext ctx) { } }

    class Teller : AssetPostprocessor
    {
        internal static Action told;
        static void OnPostprocessAllAssets(string[] imported, string[] deleted, string[] moved, string[] movedFrom) => told?.Invoke();
    }

    class EditorTests
    {
        static string Full(string path) => Path.Combine(Path.GetDirectoryName(Application.dataPath), path);

        [SetUp]
        void Begin()
        {
            AssetDatabase.Reset();
            OuterImporter.during = null;
            Teller.told = null;
        }

        static Outer Import(int value)
        {
            OuterImporter.value = value;
            File.WriteAllText(Full("Assets/one.outer"), "");
            AssetDatabase.ImportAsset("Assets/one.outer");
            return AssetDatabase.LoadAssetAtPath<Outer>("Assets/one.outer");
        }

        [Test]
        void What_an_importer_made_is_loaded_from_its_file()
        {
            Outer made = null;
            OuterImporter.during = ctx => made = (Outer)ctx.mainObject;
            var outer = Import(3);
            Assert.That(made == null && outer != null && !ReferenceEquals(made, outer));
            Assert.That((outer.value, outer.unsaved, outer.inner.value, outer.lost == null, outer.name), Is.EqualTo((3, 0, 3, true, "one")));
            outer.unsaved = 8;
            Assert.That(Import(4), Is.SameAs(outer), "who is called so stays the same");
            Assert.That((outer.value, outer.unsaved, outer.inner.value, outer.enabledCount), Is.EqualTo((4, 8, 4, 1)));
        }

        [Test]
        void Importers_write_files_and_make_no_assets()
        {
            string during = null;
            OuterImporter.during = ctx =>
            {
                File.WriteAllText(Full(during = ctx.GetOutputArtifactFilePath("more")), "more");
                ctx.GetOutputArtifactFilePath("never written");
                Assert.Throws<UnityException>(() => AssetDatabase.CreateAsset(ScriptableObject.CreateInstance<Inner>(), "Assets/other.asset"));
                Assert.Throws<UnityException>(() => AssetDatabase.Refresh());
                Assert.That(EditorApplication.isUpdating);
            };
            Import(1);
            Assert.That(Dialogs.ImportErrors, Is.Empty);
            Assert.That(File.Exists(Full(during)), Is.False);
            var artifact = UnityEditor.Experimental.AssetDatabaseExperimental.LookupArtifact(new UnityEditor.Experimental.ArtifactKey(AssetDatabase.GUIDFromAssetPath("Assets/one.outer")));
            Assert.That(UnityEditor.Experimental.AssetDatabaseExperimental.GetArtifactPaths(artifact, out var paths));
            Assert.That(paths.Single(), Does.StartWith("Library/").And.EndsWith(".more"));
            Assert.That(EditorApplication.isUpdating, Is.False);
        }

        [Test]
        void An_extension_has_one_importer()
        {
            File.WriteAllText(Full("Assets/one.twice"), "");
            Log.Expect(LogType.Error, "Multiple scripted importers are targeting the extension 'twice'");
            AssetDatabase.ImportAsset("Assets/one.twice");
            Assert.That(AssetImporter.GetAtPath("Assets/one.twice"), Is.Null);
        }

        [Test]
        void A_window_gets_its_contents_later_while_files_are_imported()
        {
            Window window = null;
            Teller.told = () => window = EditorWindow.GetWindow<Window>("Window");
            Import(1);
            Assert.That(window.heard, Is.EqualTo(new[] { "Awake", "OnEnable" }));
            EditorHost.Frame();
            Assert.That(window.heard, Is.EqualTo(new[] { "Awake", "OnEnable", "CreateGUI" }));
            Assert.That(EditorWindow.GetWindow<Window>(), Is.SameAs(window));
            window.Close();
            Assert.That(window == null && window.heard.Skip(3).SequenceEqual(new[] { "OnDisable", "OnDestroy" }));
            Assert.That(EditorWindow.HasOpenInstances<Window>(), Is.False);
        }

        [Test]
        void A_window_gets_its_contents_after_a_reload_with_the_next_turn()
        {
            EditorWindow.GetWindow<Window>("Window");
            Domain.Reload();
            var window = Resources.FindObjectsOfTypeAll<Window>().Single();
            Assert.That(window.heard, Is.EqualTo(new[] { "OnEnable" }));
            EditorHost.Frame();
            Assert.That(window.heard.Last(), Is.EqualTo("CreateGUI"));
            window.Close();
        }
    }
}
