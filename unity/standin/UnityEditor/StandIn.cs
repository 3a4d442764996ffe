// What tests steer the editor with.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;

namespace StandIn
{
    /// Dialogs answer as a test says, and note what they said.
    public static class Dialogs
    {
        public static readonly List<(string title, string info, float progress)> ProgressBars = new List<(string, string, float)>();
        public static readonly List<(string title, string message)> Shown = new List<(string, string)>();
        public static readonly List<string> ImportErrors = new List<string>();
        public static readonly Queue<string> Paths = new Queue<string>();
        public static readonly Queue<bool> Answers = new Queue<bool>();
        public static bool CancelsProgress;
        public static int SceneRepaints;

        internal static string Path(string title) => Paths.Count > 0 ? Paths.Dequeue() : throw new InvalidOperationException($"nobody told which path to choose for '{title}'");
        internal static bool Answer(string title, string message)
        {
            Shown.Add((title, message));
            return Answers.Count == 0 || Answers.Dequeue();
        }

        public static void Reset()
        {
            ProgressBars.Clear();
            Shown.Clear();
            ImportErrors.Clear();
            Paths.Clear();
            Answers.Clear();
            CancelsProgress = false;
            SceneRepaints = 0;
        }
    }

    public static class EditorTypes
    {
        public static IEnumerable<Type> All => AppDomain.CurrentDomain.GetAssemblies().Where(assembly => !assembly.IsDynamic && !assembly.GetName().Name.StartsWith("System")).SelectMany(Types);
        public static IEnumerable<Type> Of<T>() => All.Where(type => typeof(T).IsAssignableFrom(type) && !type.IsAbstract && type != typeof(T));
        static IEnumerable<Type> Types(Assembly assembly)
        {
            try { return assembly.GetTypes(); }
            catch (ReflectionTypeLoadException error) { return error.Types.Where(type => type != null); }
        }
    }

    /// What a domain reload is to the editor: scripts' listeners are gone, and what loads with them is loaded anew.
    static class EditorReload
    {
        static bool isHooked;

        public static void Hook()
        {
            if (isHooked) return;
            isHooked = true;
            Domain.beforeReload += () =>
            {
                AssemblyReloadEvents.SendBefore();
                AssemblyReloadEvents.ForgetListeners();
                EditorApplication.ForgetListeners();
                Undo.undoRedoPerformed = null;
                Selection.selectionChanged = null;
                Bindings.Clear();
            };
            Domain.loaded += () =>
            {
                AssetDatabase.TakeReplaced();
                foreach (var assembly in Domain.Scripts()) EditorHost.Load(assembly);
            };
            Domain.afterReload += () =>
            {
                EditorWindow.TakeReplaced();
                AssemblyReloadEvents.SendAfter();
            };
        }
    }

    /// The editor's menus, inspectors and scene view, as a person uses them.
    public static class EditorHost
    {
        static EditorHost() => EditorReload.Hook();

        /// Runs what waits to run when the editor or its scripts are loaded.
        public static void Load(Assembly assembly)
        {
            foreach (var type in assembly.GetTypes()) if (type.GetCustomAttribute<InitializeOnLoadAttribute>() != null) type.TypeInitializer?.Invoke(null, null);
            foreach (var type in assembly.GetTypes())
            {
                foreach (var method in type.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic))
                    if (method.GetCustomAttribute<InitializeOnLoadMethodAttribute>() != null) method.Invoke(null, null);
            }
        }

        /// What the editor was asked to end with, if it was.
        public static int? ExitCode;

        /// Chooses from the menus. A disabled item cannot be chosen.
        public static void Menu(string item, UnityEngine.Object context = null)
        {
            if (!IsMenuEnabled(item)) throw new InvalidOperationException($"the menu item '{item}' is disabled");
            var method = Items(item, false).FirstOrDefault() ?? throw new InvalidOperationException($"there is no menu item '{item}'");
            Undo.IncrementCurrentGroup();
            method.Invoke(null, method.GetParameters().Length == 0 ? null : new object[] { new MenuCommand(context) });
        }

        public static bool IsMenuEnabled(string item) => Items(item, true).All(method => (bool)method.Invoke(null, method.GetParameters().Length == 0 ? null : new object[] { new MenuCommand(null) }));

        static IEnumerable<MethodInfo> Items(string item, bool validates) => EditorTypes.All.SelectMany(type => type.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic))
            .Where(method => method.GetCustomAttributes<MenuItem>().Any(one => one.validate == validates && one.menuItem.Split('#', '%', '&')[0].TrimEnd(' ', '_') == item));

        /// The inspector of objects, in a panel.
        public static (Editor editor, Panel panel) Inspect(params UnityEngine.Object[] targets)
        {
            var editor = Editor.CreateEditor(targets);
            var root = new VisualElement();
            var panel = new Panel(root, 400, 900);
            root.Add(new InspectorElement(editor));
            panel.Update();
            return (editor, panel);
        }

        /// Draws the gizmos that are drawn of a selected component, and its editor's handles.
        public static void DrawScene(Editor editor, Component component)
        {
            foreach (var method in EditorTypes.All.SelectMany(type => type.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic)))
                if (method.GetCustomAttribute<DrawGizmo>() != null && method.GetParameters()[0].ParameterType == component.GetType()) method.Invoke(null, new object[] { component, GizmoType.Selected | GizmoType.Active });
            if (component is MonoBehaviour script)
            {
                Messages.Send(script, "OnDrawGizmos");
                Messages.Send(script, "OnDrawGizmosSelected");
            }
            if (editor != null) Messages.Send(editor, "OnSceneGUI");
        }

        /// A frame of the editor: what waits for the next one, and what runs in each.
        public static void Frame()
        {
            var later = EditorApplication.delayCall;
            EditorApplication.delayCall = null;
            later?.Invoke();
            EditorApplication.update?.Invoke();
            (System.Threading.SynchronizationContext.Current as MainContext)?.Run();
            EditorWindow.Turn();
            Bindings.Refresh();
        }
    }
}
