// Scene documents as assets: a prefab-like object with volumes, lights and a camera, as importers of models make them.
using System;
using System.Collections.Generic;
using System.IO;
using Lumivox.Native;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Lumivox.Editor
{
    static class SceneImport
    {
        /// <summary>Whether a file begins as scene documents do.</summary>
        public static bool IsScene(string path) => Border.Fault == null && LumivoxScene.IsOne(StoredScans.ProjectFile(path));

        /// <summary>Makes all that a document says, or nothing, and then says why.</summary>
        public static void Import(AssetImportContext ctx, bool allowOutsideData)
        {
            var name = Path.GetFileName(ctx.assetPath);
            var progress = default(LumivoxProgress);
            using (var stopped = new System.Threading.CancellationTokenSource())
            {
                void Show()
                {
                    var text = string.IsNullOrEmpty(progress.stage) ? "Reading" : progress.stage;
                    if (EditorUtility.DisplayCancelableProgressBar("Import " + name, text, progress.fraction)) stopped.Cancel();
                }
                LumivoxRuntime.IsMakingAssets = true;
                try
                {
                    using (var opened = EditorWork.Wait(LumivoxScene.Open(StoredScans.ProjectFile(ctx.assetPath), now => progress = now, stopped.Token, allowOutsideData, one => one), Show))
                    {
                        foreach (var file in Border.TakeText(Library.lumivox_scene_files(opened.Pointer)).Split('\n')) Depend(ctx, file);
                        var assets = new ImportedAssets(ctx);
                        var scene = SceneReader.Make(opened, Path.GetFileNameWithoutExtension(ctx.assetPath), assets);
                        foreach (var (id, asset) in assets.Kept) ctx.AddObjectToAsset(id, asset);
                        ctx.AddObjectToAsset("scene", scene.gameObject);
                        ctx.SetMainObject(scene.gameObject);
                        foreach (var note in scene.notes) ctx.LogImportWarning($"{name}: {note}");
                    }
                }
                catch (OperationCanceledException)
                {
                    ctx.LogImportError($"{name} was not imported: it was stopped. Choose 'Reimport' to try again.");
                }
                catch (LumivoxException error)
                {
                    ctx.LogImportError($"{name} was not imported: {error.Message}");
                }
                finally
                {
                    LumivoxRuntime.IsMakingAssets = false;
                    EditorUtility.ClearProgressBar();
                }
            }
        }

        /// <summary>When a file of the project that the scene names is another, the scene is imported again.</summary>
        static void Depend(AssetImportContext ctx, string file)
        {
            var project = StoredScans.ProjectFile("Assets").Replace('\\', '/');
            var full = string.IsNullOrEmpty(file) ? "" : Path.GetFullPath(file).Replace('\\', '/');
            if (full.StartsWith(project + "/", StringComparison.Ordinal) && File.Exists(full)) ctx.DependsOnSourceAsset("Assets" + full.Substring(project.Length));
        }

        /// <summary>Scans lie among Unity's results of the import, each in a file with a number.</summary>
        sealed class ImportedAssets : ISceneAssets
        {
            readonly AssetImportContext ctx;
            readonly string guid;
            int count;
            public readonly List<(string, Object)> Kept = new List<(string, Object)>();

            public ImportedAssets(AssetImportContext ctx)
            {
                this.ctx = ctx;
                guid = AssetDatabase.AssetPathToGUID(ctx.assetPath);
            }

            public LumivoxVolumeAsset Scan(VolumeHandle opened)
            {
                var made = LumivoxVolumeAsset.Of(opened);
                try
                {
                    var number = count++;
                    StoredScans.Keep(ctx, into => EditorWork.Wait(made.Save(into), () => EditorUtility.DisplayProgressBar("Import " + Path.GetFileName(ctx.assetPath), "Writing the scans", 1)), number.ToString());
                    return LumivoxVolumeAsset.Stored(StoredScans.IdOf(guid, number), opened);
                }
                finally
                {
                    // With it goes the handle.
                    Object.DestroyImmediate(made);
                }
            }

            public void Keep(string name, ScriptableObject asset) => Kept.Add((name, asset));
        }
    }
}
