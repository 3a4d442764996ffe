// Inspectors, windows, menus and the editor's own life.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;
using Object = UnityEngine.Object;

namespace UnityEditor
{
    public class CustomEditor : Attribute
    {
        internal readonly Type inspectedType;
        public CustomEditor(Type inspectedType) : this(inspectedType, false) { }
        public CustomEditor(Type inspectedType, bool editorForChildClasses) { this.inspectedType = inspectedType; }
    }

    public sealed class CanEditMultipleObjects : Attribute { }
    [AttributeUsage(AttributeTargets.Class)] public class InitializeOnLoadAttribute : Attribute { }
    [AttributeUsage(AttributeTargets.Method)] public class InitializeOnLoadMethodAttribute : Attribute { }

    [AttributeUsage(AttributeTargets.Method, AllowMultiple = true)]
    public sealed class MenuItem : Attribute
    {
        public string menuItem;
        public bool validate;
        public int priority;
        public MenuItem(string itemName) : this(itemName, false) { }
        public MenuItem(string itemName, bool isValidateFunction) : this(itemName, isValidateFunction, 1000) { }
        public MenuItem(string itemName, bool isValidateFunction, int priority) { menuItem = itemName; validate = isValidateFunction; this.priority = priority; }
    }

    public sealed class MenuCommand
    {
        public Object context;
        public int userData;
        public MenuCommand(Object inContext, int inUserData) { context = inContext; userData = inUserData; }
        public MenuCommand(Object inContext) : this(inContext, 0) { }
    }

    [Flags] public enum GizmoType { Pickable = 1, NotInSelectionHierarchy = 2, NonSelected = 32, Selected = 4, Active = 8, InSelectionHierarchy = 16 }

    public sealed class DrawGizmo : Attribute
    {
        public GizmoType drawOptions;
        public Type drawnType;
        public DrawGizmo(GizmoType gizmo) { drawOptions = gizmo; }
        public DrawGizmo(GizmoType gizmo, Type drawnGizmoType) { drawOptions = gizmo; drawnType = drawnGizmoType; }
    }

    public class Editor : ScriptableObject
    {
        SerializedObject cached;
        public Object target { get => targets[0]; set => throw new NotImplementedException("the stand-in's editors keep what they edit"); }
        public Object[] targets { get; internal set; }
        public SerializedObject serializedObject => cached ?? (cached = new SerializedObject(targets));
        public virtual VisualElement CreateInspectorGUI() => null;
        public virtual void OnInspectorGUI() { }
        public virtual bool HasPreviewGUI() => false;
        public virtual bool RequiresConstantRepaint() => false;
        public virtual Texture2D RenderStaticPreview(string assetPath, Object[] subAssets, int width, int height) => null;
        public void Repaint() { }

        public static Editor CreateEditor(Object targetObject) => CreateEditor(new[] { targetObject });
        public static Editor CreateEditor(Object[] targetObjects)
        {
            var type = StandIn.EditorTypes.Of<Editor>().FirstOrDefault(one => one.GetCustomAttribute<CustomEditor>()?.inspectedType == targetObjects[0].GetType());
            if (type == null) throw new InvalidOperationException($"there is no custom editor for {targetObjects[0].GetType().Name}");
            if (targetObjects.Length > 1 && type.GetCustomAttribute<CanEditMultipleObjects>() == null) throw new InvalidOperationException("Multi-object editing not supported.");
            var editor = (Editor)StandIn.Objects.Make(type);
            editor.hideFlags = HideFlags.HideAndDontSave;
            editor.targets = targetObjects;
            editor.Begin();
            return editor;
        }
    }

    public class EditorWindow : ScriptableObject
    {
        static readonly List<EditorWindow> open = new List<EditorWindow>();
        internal StandIn.Panel panel;
        public GUIContent titleContent { get; set; } = new GUIContent();
        public VisualElement rootVisualElement { get; } = new VisualElement();
        public Vector2 minSize { get; set; }
        public Vector2 maxSize { get; set; }
        public Rect position { get; set; } = new Rect(0, 0, 800, 600);
        public bool hasUnsavedChanges { get; protected set; }
        public string saveChangesMessage { get; protected set; }
        public virtual void SaveChanges() => hasUnsavedChanges = false;
        public virtual void DiscardChanges() => hasUnsavedChanges = false;

        public static T GetWindow<T>() where T : EditorWindow => GetWindow<T>(null);
        public static T GetWindow<T>(string title) where T : EditorWindow => GetWindow<T>(false, title);
        public static T GetWindow<T>(bool utility) where T : EditorWindow => GetWindow<T>(utility, null);
        public static T GetWindow<T>(bool utility, string title) where T : EditorWindow => GetWindow<T>(utility, title, true);
        public static T GetWindow<T>(bool utility, string title, bool focus) where T : EditorWindow
        {
            var window = open.OfType<T>().FirstOrDefault();
            if (window != null)
            {
                // It comes to the front, where it gets its contents at last.
                window.Fill(EditorApplication.isUpdating);
                return window;
            }
            return CreateWindow<T>(title);
        }
        public static T CreateWindow<T>(string title, params Type[] desiredDockNextTo) where T : EditorWindow
        {
            var window = CreateInstance<T>();
            window.titleContent = new GUIContent(title ?? typeof(T).FullName);
            window.Show();
            return window;
        }
        public static bool HasOpenInstances<T>() where T : EditorWindow => open.OfType<T>().Any();

        public void Show()
        {
            if (open.Contains(this)) return;
            open.Add(this);
            hideFlags = HideFlags.DontSave;
            panel = new StandIn.Panel(rootVisualElement, position.width, position.height);
            Fill(EditorApplication.isUpdating);
        }
        bool isFilled;
        /// Contents are made at once, or with the panel's next turn: while assets are imported, and after scripts were loaded.
        void Fill(bool isLater)
        {
            if (isFilled) return;
            if (isLater)
            {
                rootVisualElement.schedule.Execute(() => Fill(EditorApplication.isUpdating));
                return;
            }
            isFilled = true;
            StandIn.Messages.Send(this, "CreateGUI");
            panel.Update();
        }
        internal static void Turn() { foreach (var window in open.ToArray()) window.panel.Advance(0); }
        /// A domain reload leaves windows open, which begin anew.
        internal static void TakeReplaced()
        {
            open.RemoveAll(window => StandIn.Objects.Find(window.instanceID) == null);
            for (var i = 0; i < open.Count; i++)
            {
                var window = open[i] = (EditorWindow)StandIn.Objects.Find(open[i].instanceID);
                window.panel = new StandIn.Panel(window.rootVisualElement, window.position.width, window.position.height);
                window.Fill(true);
            }
        }
        public void ShowUtility() => Show();
        public void Focus() { }
        public void Repaint() { }
        public void ShowNotification(GUIContent notification) { }
        /// It is destroyed, and its elements are in no panel any more.
        public void Close()
        {
            if (this == null) return;
            open.Remove(this);
            panel.Detach(rootVisualElement);
            DestroyImmediate(this, true);
        }
        internal override void OnDestroyed()
        {
            open.Remove(this);
            base.OnDestroyed();
        }
    }

    public sealed class Selection
    {
        public static Action selectionChanged;
        static Object[] selected = Array.Empty<Object>();
        public static Object[] objects
        {
            get => selected;
            set
            {
                selected = value ?? Array.Empty<Object>();
                selectionChanged?.Invoke();
            }
        }
        public static Object activeObject { get => selected.FirstOrDefault(); set => objects = value == null ? null : new[] { value }; }
        public static GameObject activeGameObject { get => activeObject as GameObject; set => activeObject = value; }
        public static GameObject[] gameObjects => selected.OfType<GameObject>().ToArray();
        public static bool Contains(Object obj) => selected.Contains(obj);
    }

    public sealed class EditorApplication
    {
        public delegate void CallbackFunction();
        public static CallbackFunction update;
        public static CallbackFunction delayCall;
        public static event Action<PlayModeStateChange> playModeStateChanged;
        public static event Action quitting;
        public static event Action hierarchyChanged;
        public static bool isPlaying
        {
            get => Application.isPlaying;
            set => throw new NotImplementedException("the stand-in plays by StandIn.Domain");
        }
        public static bool isPlayingOrWillChangePlaymode => isPlaying;
        public static bool isCompiling => false;
        public static bool isUpdating => AssetDatabase.isImporting;
        public static double timeSinceStartup => Environment.TickCount / 1000.0;
        public static void QueuePlayerLoopUpdate() { }
        public static void Exit(int returnValue) => StandIn.EditorHost.ExitCode = returnValue;
        public static void RepaintHierarchyWindow() { }
        internal static void Send(PlayModeStateChange change) => playModeStateChanged?.Invoke(change);
        internal static void Quit() => quitting?.Invoke();
        internal static void ChangeHierarchy() => hierarchyChanged?.Invoke();
        internal static void ForgetListeners()
        {
            update = delayCall = null;
            playModeStateChanged = null;
            quitting = hierarchyChanged = null;
        }
    }

    public enum PlayModeStateChange { EnteredEditMode, ExitingEditMode, EnteredPlayMode, ExitingPlayMode }

    public static class AssemblyReloadEvents
    {
        public delegate void AssemblyReloadCallback();
        public static event AssemblyReloadCallback beforeAssemblyReload;
        public static event AssemblyReloadCallback afterAssemblyReload;

        static AssemblyReloadEvents() => StandIn.EditorReload.Hook();
        internal static void SendBefore() => beforeAssemblyReload?.Invoke();
        internal static void SendAfter() => afterAssemblyReload?.Invoke();
        internal static void ForgetListeners()
        {
            beforeAssemblyReload = null;
            afterAssemblyReload = null;
        }
    }

    public enum MessageType { None, Info, Warning, Error }

    public class EditorUtility
    {
        static readonly HashSet<Object> dirty = new HashSet<Object>();
        public static GameObject CreateGameObjectWithHideFlags(string name, HideFlags flags, params Type[] components)
        {
            var made = new GameObject(name, components) { hideFlags = flags };
            return made;
        }
        public static void SetDirty(Object target) => dirty.Add(target);
        public static bool IsDirty(Object target) => dirty.Contains(target);
        public static void ClearDirty(Object target) => dirty.Remove(target);
        public static void DisplayProgressBar(string title, string info, float progress) => StandIn.Dialogs.ProgressBars.Add((title, info, progress));
        public static bool DisplayCancelableProgressBar(string title, string info, float progress)
        {
            StandIn.Dialogs.ProgressBars.Add((title, info, progress));
            return StandIn.Dialogs.CancelsProgress;
        }
        public static void ClearProgressBar() => StandIn.Dialogs.ProgressBars.Add((null, null, 0));
        public static bool DisplayDialog(string title, string message, string ok) => DisplayDialog(title, message, ok, "");
        public static bool DisplayDialog(string title, string message, string ok, string cancel) => StandIn.Dialogs.Answer(title, message);
        public static string OpenFolderPanel(string title, string folder, string defaultName) => StandIn.Dialogs.Path(title);
        public static string OpenFilePanel(string title, string directory, string extension) => StandIn.Dialogs.Path(title);
        public static string OpenFilePanelWithFilters(string title, string directory, string[] filters) => StandIn.Dialogs.Path(title);
        public static string SaveFilePanel(string title, string directory, string defaultName, string extension) => StandIn.Dialogs.Path(title);
        public static string SaveFilePanelInProject(string title, string defaultName, string extension, string message) => StandIn.Dialogs.Path(title);
        public static string SaveFilePanelInProject(string title, string defaultName, string extension, string message, string path) => StandIn.Dialogs.Path(title);
        public static string FormatBytes(long bytes) => bytes < 1 << 20 ? $"{bytes / 1024.0:0.0} KB" : $"{bytes / 1048576.0:0.0} MB";
        public static void RevealInFinder(string path) { }
        public static bool IsPersistent(Object target) => AssetDatabase.Contains(target);
        public static void FocusProjectWindow() { }
    }

    public sealed class EditorGUIUtility : GUIUtility
    {
        public static bool isProSkin => true;
        public static float pixelsPerPoint => 1;
        public static float singleLineHeight => 18;
        public static void PingObject(Object obj) { }
        public static GUIContent IconContent(string name) => IconContent(name, null);
        public static GUIContent IconContent(string name, string text) => new GUIContent(text ?? "");
    }

    public sealed class EditorGUI
    {
        static readonly Stack<bool> changes = new Stack<bool>();
        public static void BeginChangeCheck() => changes.Push(false);
        public static bool EndChangeCheck() => changes.Pop();
        internal static void Change() { if (changes.Count > 0) { changes.Pop(); changes.Push(true); } }
    }

    public sealed class GameObjectUtility
    {
        public static void SetParentAndAlign(GameObject child, GameObject parent)
        {
            if (parent == null) return;
            child.transform.SetParent(parent.transform, false);
            child.layer = parent.layer;
        }
        public static void EnsureUniqueNameForSibling(GameObject self) { }
    }

    public sealed class PrefabUtility
    {
        public static void RecordPrefabInstancePropertyModifications(Object targetObject) { }
    }

    public class SearchableEditorWindow : EditorWindow { }

    public class SceneView : SearchableEditorWindow
    {
        public class SceneViewState { public bool fogEnabled { get; internal set; } = true; }
        public static SceneView currentDrawingSceneView { get; internal set; }
        public static SceneView lastActiveSceneView { get; internal set; }
        public SceneViewState sceneViewState { get; set; } = new SceneViewState();
        internal Camera viewed;
        public Camera camera => viewed;
        public static void RepaintAll() => StandIn.Dialogs.SceneRepaints++;
    }

    public class SceneVisibilityManager : ScriptableSingleton<SceneVisibilityManager>
    {
        readonly HashSet<GameObject> hidden = new HashSet<GameObject>();
        public bool IsHidden(GameObject gameObject, bool includeDescendants = false) => hidden.Contains(gameObject);
        public void Hide(GameObject gameObject, bool includeDescendants) => hidden.Add(gameObject);
        public void Show(GameObject gameObject, bool includeDescendants) => hidden.Remove(gameObject);
    }

    public class ScriptableSingleton<T> : ScriptableObject where T : ScriptableObject
    {
        static T made;
        protected ScriptableSingleton() { }
        public static T instance => made != null ? made : made = Make();
        static T Make()
        {
            var one = CreateInstance<T>();
            one.hideFlags = HideFlags.HideAndDontSave;
            return one;
        }
    }
}
