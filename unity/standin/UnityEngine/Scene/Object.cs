using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine.SceneManagement;

namespace UnityEngine
{
    [Flags]
    public enum HideFlags { None = 0, HideInHierarchy = 1, HideInInspector = 2, DontSaveInEditor = 4, NotEditable = 8, DontSaveInBuild = 16, DontUnloadUnusedAsset = 32, DontSave = 52, HideAndDontSave = 61 }
    public enum FindObjectsInactive { Exclude, Include }
    public enum FindObjectsSortMode { None, InstanceID }

    public class Object
    {
        internal int instanceID;
        internal bool isDestroyed;
        /// Whether it lies in a file: such are not destroyed by mistake.
        internal bool isAsset;
        string m_Name = "";
        HideFlags m_HideFlags;

        public Object()
        {
            if (StandIn.Objects.isReplacing) return;
            instanceID = StandIn.Objects.Register(this);
        }

        public string name
        {
            get { StandIn.Threads.Main("get_name"); Alive(); return ownName; }
            set { StandIn.Threads.Main("set_name"); Alive(); ownName = value; }
        }
        public HideFlags hideFlags
        {
            get { StandIn.Threads.Main("get_hideFlags"); return m_HideFlags; }
            set { StandIn.Threads.Main("set_hideFlags"); m_HideFlags = value; }
        }
        /// A component is called as its object.
        internal virtual string ownName { get => m_Name; set => m_Name = value; }
        /// The name, for messages from any thread.
        internal string label => m_Name;

        internal void Alive()
        {
            if (isDestroyed) throw new MissingReferenceException($"The object of type '{GetType().Name}' has been destroyed but you are still trying to access it.\nYour script should either check if it is null or you should not destroy the object.");
        }

        public int GetInstanceID()
        {
            if (!StandIn.Threads.isMain) throw new InvalidOperationException("EnsureRunningOnMainThread can only be called from the main thread");
            return instanceID;
        }
        public EntityId GetEntityId() => new EntityId(instanceID);
        public override int GetHashCode() => instanceID;
        public override bool Equals(object other) => other is Object item ? this == item : other is null && this == null;
        public override string ToString() => isDestroyed ? "null" : $"{m_Name} ({GetType().FullName})";
        public static implicit operator bool(Object exists) => exists != null;
        public static bool operator ==(Object x, Object y)
        {
            bool noA = x is null || x.isDestroyed, noB = y is null || y.isDestroyed;
            return noA || noB ? noA && noB : x.instanceID == y.instanceID;
        }
        public static bool operator !=(Object x, Object y) => !(x == y);

        /// What happens to it when it is destroyed; once.
        internal virtual void OnDestroyed() { }
        internal void TakeIdentity(Object other) { instanceID = other.instanceID; m_Name = other.m_Name; m_HideFlags = other.m_HideFlags; isAsset = other.isAsset; }

        public static void Destroy(Object obj) => Destroy(obj, 0);
        public static void Destroy(Object obj, float t)
        {
            StandIn.Threads.Main("Destroy");
            if (obj == null) return;
            if (!Application.isPlaying) { Debug.LogError("Destroy may not be called from edit mode! Use DestroyImmediate instead.\nDestroying an object in edit mode destroys it permanently."); return; }
            if (obj is Transform) { Debug.LogError("Can't destroy Transform component of '" + obj.label + "'. If you want to destroy the game object, please call 'Destroy' on the game object instead. Destroying the transform component is not allowed."); return; }
            if (t > 0) throw new NotImplementedException("the stand-in destroys at the end of a frame only");
            StandIn.Objects.DestroyLater(obj);
        }
        public static void DestroyImmediate(Object obj) => DestroyImmediate(obj, false);
        public static void DestroyImmediate(Object obj, bool allowDestroyingAssets)
        {
            StandIn.Threads.Main("DestroyImmediate");
            if (obj == null) return;
            if (StandIn.Messages.isValidating) { Debug.LogError($"Destroying {(obj is GameObject ? "GameObjects" : obj is Component ? "components" : "assets")} immediately is not permitted during physics trigger/contact, animation event callbacks, rendering callbacks or OnValidate. You must use Destroy instead."); return; }
            if (obj.isAsset && !allowDestroyingAssets) { Debug.LogError("Destroying assets is not permitted to avoid data loss.\nIf you really want to remove an asset use DestroyImmediate (theObject, true);"); return; }
            if (obj is Transform transform && !transform.gameObject.isDying) { Debug.LogError("Can't destroy Transform component of '" + obj.label + "'. If you want to destroy the game object, please call 'Destroy' on the game object instead. Destroying the transform component is not allowed."); return; }
            StandIn.Objects.DestroyNow(obj);
        }
        public static void DontDestroyOnLoad(Object target)
        {
            StandIn.Threads.Main("DontDestroyOnLoad");
            if (!Application.isPlaying) throw new InvalidOperationException($"The following game object is invoking the DontDestroyOnLoad method: {target.label}. Notice that DontDestroyOnLoad can only be used in play mode and, as such, cannot be part of an editor script.");
            var item = target is GameObject gameObject ? gameObject : ((Component)target).gameObject;
            if (item.transform.parent != null) { Debug.LogWarning("DontDestroyOnLoad only works for root GameObjects or components on root GameObjects."); return; }
            foreach (var at in item.transform.WithChildren()) at.gameObject.isLasting = true;
        }

        public static Object Instantiate(Object original) => StandIn.Cloning.Clone(original);
        public static T Instantiate<T>(T original) where T : Object => (T)StandIn.Cloning.Clone(original);
        public static T Instantiate<T>(T original, Transform parent) where T : Object
        {
            var clone = (T)StandIn.Cloning.Clone(original);
            var made = clone is GameObject gameObject ? gameObject : clone is Component component ? component.gameObject : null;
            if (made != null) made.transform.SetParent(parent, false);
            return clone;
        }
        public static T Instantiate<T>(T original, Vector3 position, Quaternion rotation) where T : Object
        {
            var clone = (T)StandIn.Cloning.Clone(original);
            var made = clone is GameObject gameObject ? gameObject : clone is Component component ? component.gameObject : null;
            if (made != null) made.transform.SetPositionAndRotation(position, rotation);
            return clone;
        }

        static IEnumerable<T> Find<T>(bool inactive)
        {
            StandIn.Threads.Main("FindObjectsOfType");
            return StandIn.Objects.All().Where(item => item is T && item.isInScene && (item.hideFlags & HideFlags.DontSave) != HideFlags.DontSave && (inactive || item.isActive)).OfType<T>();
        }
        internal virtual bool isInScene => false;
        internal virtual bool isActive => true;
        public static T[] FindObjectsByType<T>(FindObjectsSortMode sortMode) where T : Object => Find<T>(false).ToArray();
        public static T[] FindObjectsByType<T>(FindObjectsInactive findObjectsInactive, FindObjectsSortMode sortMode) where T : Object => Find<T>(findObjectsInactive == FindObjectsInactive.Include).ToArray();
        public static T FindFirstObjectByType<T>() where T : Object => Find<T>(false).FirstOrDefault();
        public static T FindFirstObjectByType<T>(FindObjectsInactive findObjectsInactive) where T : Object => Find<T>(findObjectsInactive == FindObjectsInactive.Include).FirstOrDefault();
        public static T FindAnyObjectByType<T>() where T : Object => Find<T>(false).FirstOrDefault();
        public static T FindAnyObjectByType<T>(FindObjectsInactive findObjectsInactive) where T : Object => Find<T>(findObjectsInactive == FindObjectsInactive.Include).FirstOrDefault();
        public static T[] FindObjectsOfType<T>() where T : Object => Find<T>(false).ToArray();
        public static T FindObjectOfType<T>() where T : Object => Find<T>(false).FirstOrDefault();
    }

    public class UnityException : SystemException { public UnityException() : base("A Unity Runtime error occurred!") { } public UnityException(string message) : base(message) { } }
    public class MissingReferenceException : SystemException { public MissingReferenceException(string message) : base(message) { } }
    public class UnassignedReferenceException : SystemException { public UnassignedReferenceException(string message) : base(message) { } }
    public class MissingComponentException : SystemException { public MissingComponentException(string message) : base(message) { } }

    public class ScriptableObject : Object
    {
        internal bool isEnabled;
        public ScriptableObject()
        {
            if (!StandIn.Objects.isMaking && !StandIn.Objects.isReplacing) Debug.LogWarning($"{GetType().Name} must be instantiated using the ScriptableObject.CreateInstance method instead of new {GetType().Name}.");
        }
        public static T CreateInstance<T>() where T : ScriptableObject => (T)CreateInstance(typeof(T));
        public static ScriptableObject CreateInstance(Type type)
        {
            StandIn.Threads.Main("CreateScriptableObjectInstanceFromType");
            if (type.IsAbstract) { Debug.LogError($"Instance of {type.Name} couldn't be created because it is abstract."); return null; }
            var made = (ScriptableObject)StandIn.Objects.Make(type);
            made.Begin();
            return made;
        }
        internal void Begin()
        {
            StandIn.Messages.Send(this, "Awake");
            isEnabled = true;
            StandIn.Messages.Send(this, "OnEnable");
        }
        internal override void OnDestroyed()
        {
            if (isEnabled) { isEnabled = false; StandIn.Messages.Send(this, "OnDisable"); }
            StandIn.Messages.Send(this, "OnDestroy");
        }
    }

    public class TextAsset : Object
    {
        readonly byte[] data;
        public TextAsset() : this("") { }
        public TextAsset(string text) => data = System.Text.Encoding.UTF8.GetBytes(text);
        internal TextAsset(byte[] bytes) => data = bytes;
        public byte[] bytes => (byte[])data.Clone();
        public string text => System.Text.Encoding.UTF8.GetString(data);
        public override string ToString() => text;
    }
}

namespace UnityEngine.SceneManagement
{
    public struct SceneHandle : IEquatable<SceneHandle>
    {
        readonly int scene;
        internal SceneHandle(int scene) => this.scene = scene;
        public bool Equals(SceneHandle other) => scene == other.scene;
        public override bool Equals(object obj) => obj is SceneHandle other && Equals(other);
        public override int GetHashCode() => scene;
        public override string ToString() => scene.ToString();
        public static bool operator ==(SceneHandle left, SceneHandle right) => left.Equals(right);
        public static bool operator !=(SceneHandle left, SceneHandle right) => !left.Equals(right);
    }
    public struct Scene
    {
        internal int handleOf;
#if UNITY_6000_3_OR_NEWER
        public SceneHandle handle => new SceneHandle(handleOf);
#else
        public int handle => handleOf;
#endif
        public string name
        {
            get => handleOf == 0 ? null : handleOf == 2 ? "DontDestroyOnLoad" : handleOf > 2 ? "" : "Stand-in";
            set => throw new InvalidOperationException("The stand-in's scenes keep their names.");
        }
        public string path => handleOf == 0 ? null : handleOf > 2 ? "" : "Assets/Stand-in.unity";
        public bool isLoaded => handleOf != 0;
        public bool IsValid() => handleOf == 1 || handleOf == 2 || StandIn.PreviewScenes.IsOpen(this);
        static readonly List<GameObject> counted = new List<GameObject>();
        public int rootCount
        {
            get
            {
                GetRootGameObjects(counted);
                var count = counted.Count;
                counted.Clear();
                return count;
            }
        }
        public GameObject[] GetRootGameObjects() { var own = this; return IsValid() ? StandIn.Objects.All().OfType<GameObject>().Where(item => item.transform.parent == null && item.scene == own).ToArray() : throw new ArgumentException("The scene is invalid."); }
        public void GetRootGameObjects(List<GameObject> rootGameObjects)
        {
            if (!IsValid()) throw new ArgumentException("The scene is invalid.");
            rootGameObjects.Clear();
            StandIn.Objects.Roots(this, rootGameObjects);
        }
        public static bool operator ==(Scene lhs, Scene rhs) => lhs.handleOf == rhs.handleOf;
        public static bool operator !=(Scene lhs, Scene rhs) => lhs.handleOf != rhs.handleOf;
        public override bool Equals(object other) => other is Scene scene && this == scene;
        public override int GetHashCode() => handleOf;
    }
    public enum LoadSceneMode { Single, Additive }
    public class SceneManager
    {
        public static int sceneCount => 1;
        public static void MoveGameObjectToScene(GameObject go, Scene scene)
        {
            if (!scene.IsValid()) throw new ArgumentException("SceneManager.MoveGameObjectToScene failed; the scene is not valid.");
            if (go.transform.parent != null) throw new ArgumentException("Gameobject is not a root in a scene");
            go.apart = scene.handleOf > 2 ? scene.handleOf : 0;
        }
        public static Scene GetActiveScene() => new Scene { handleOf = 1 };
        public static Scene GetSceneAt(int index) => index == 0 ? GetActiveScene() : throw new IndexOutOfRangeException($"Scene index \"{index}\" is out of range.");
#pragma warning disable 67 // Scenes are never loaded here.
        public static event Events.UnityAction<Scene, LoadSceneMode> sceneLoaded;
        public static event Events.UnityAction<Scene> sceneUnloaded;
        public static event Events.UnityAction<Scene, Scene> activeSceneChanged;
#pragma warning restore 67
    }
}
