using System;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    public enum PrimitiveType { Sphere, Capsule, Cylinder, Cube, Plane, Quad }

    public sealed class GameObject : Object
    {
        internal readonly List<Component> components = new List<Component>();
        internal bool isDying;
        bool self = true;
        /// Kept out of the scene, as a prefab's objects are.
        internal bool isPrefab;
        /// Kept when scenes change.
        internal bool isLasting;
        public GameObject() : this("New Game Object") { }
        public GameObject(string name) : this(name, Type.EmptyTypes) { }
        public GameObject(string name, params Type[] components)
        {
            StandIn.Threads.Main("Internal_CreateGameObject");
            this.name = name;
            Add(typeof(Transform));
            foreach (var type in components) if (type != typeof(Transform)) AddComponent(type);
        }
        public Transform transform { get { Alive(); return (Transform)components[0]; } }
        public GameObject gameObject => this;
        public int layer { get; set; }
        public string tag { get; set; } = "Untagged";
        public bool isStatic { get; set; }
        public bool CompareTag(string tag) => this.tag == tag;
        public UnityEngine.SceneManagement.Scene scene => isPrefab ? default : new UnityEngine.SceneManagement.Scene { handleOf = isLasting ? 2 : Root.apart > 0 ? Root.apart : 1 };
        /// The preview scene that it was moved to, if any.
        internal int apart;
        GameObject Root { get { var at = (Transform)components[0]; while (!(at.above is null)) at = at.above; return at.owner; } }
        public bool activeSelf { get { Alive(); return self; } }
        public bool activeInHierarchy { get { Alive(); for (var at = transform; !(at is null); at = at.above) if (!at.gameObject.self) return false; return !isPrefab; } }
        internal override bool isInScene => !isPrefab;
        internal override bool isActive => activeInHierarchy;
        public void SetActive(bool value)
        {
            StandIn.Threads.Main("SetActive");
            Alive();
            if (self == value) return;
            self = value;
            StandIn.Lifecycle.Refresh(this);
        }

        public T AddComponent<T>() where T : Component => (T)AddComponent(typeof(T));
        public Component AddComponent(Type componentType)
        {
            StandIn.Threads.Main("AddComponent");
            Alive();
            if (!typeof(Component).IsAssignableFrom(componentType) || componentType.IsAbstract) { Debug.LogError($"Can't add component '{componentType.Name}' to {label} because it is no component that can be made."); return null; }
            if (componentType == typeof(Transform)) { Debug.LogError("Can't add component 'Transform' to " + label + " because such a component is already added to the game object!"); return null; }
            for (var at = componentType; at != null && at != typeof(Component); at = at.BaseType)
                if (Attribute.IsDefined(at, typeof(DisallowMultipleComponent), false) && components.Any(at.IsInstanceOfType))
                {
                    Debug.LogError($"Can't add component '{componentType.Name}' to {label} because a '{at.Name}' is already added to the game object!\nA GameObject can only contain one '{at.Name}' component.");
                    return null;
                }
            foreach (RequireComponent required in componentType.GetCustomAttributes(typeof(RequireComponent), true))
                foreach (var other in new[] { required.m_Type0, required.m_Type1, required.m_Type2 })
                    if (other != null && !components.Any(other.IsInstanceOfType)) AddComponent(other);
            var made = Add(componentType);
            StandIn.Lifecycle.Added(made);
            return made;
        }
        internal Component Add(Type type)
        {
            StandIn.Objects.ownerOfNext = this;
            var made = (Component)StandIn.Objects.Make(type);
            components.Add(made);
            return made;
        }

        public T GetComponent<T>() { StandIn.Threads.Main("GetComponent"); Alive(); foreach (var item in components) if (item is T found) return found; return default; }
        public Component GetComponent(Type type) { StandIn.Threads.Main("GetComponent"); Alive(); return components.FirstOrDefault(type.IsInstanceOfType); }
        public bool TryGetComponent<T>(out T component) { component = GetComponent<T>(); return component != null; }
        public T[] GetComponents<T>() { StandIn.Threads.Main("GetComponents"); Alive(); return components.OfType<T>().ToArray(); }
        public void GetComponents<T>(List<T> results) { StandIn.Threads.Main("GetComponents"); Alive(); results.Clear(); foreach (var item in components) if (item is T found) results.Add(found); }
        public T GetComponentInChildren<T>() => GetComponentInChildren<T>(false);
        public T GetComponentInChildren<T>(bool includeInactive) => GetComponentsInChildren<T>(includeInactive).FirstOrDefault();
        public T[] GetComponentsInChildren<T>() => GetComponentsInChildren<T>(false);
        public T[] GetComponentsInChildren<T>(bool includeInactive) => transform.WithChildren().Where(at => includeInactive || at.gameObject.activeInHierarchy).SelectMany(at => at.gameObject.components).OfType<T>().ToArray();
        public void GetComponentsInChildren<T>(bool includeInactive, List<T> results) { results.Clear(); Collect(transform, includeInactive, results); }
        public void GetComponentsInChildren<T>(List<T> results) => GetComponentsInChildren(false, results);
        static void Collect<T>(Transform at, bool includeInactive, List<T> results)
        {
            if (!includeInactive && !at.owner.activeInHierarchy) return;
            foreach (var item in at.owner.components) if (item is T found) results.Add(found);
            for (int i = 0; i < at.childCount; i++) Collect(at.GetChild(i), includeInactive, results);
        }
        /// In which scenes' views it is drawn: the editor's scenes have a bit each.
        public ulong sceneCullingMask => isPrefab ? 0 : StandIn.PreviewScenes.MaskOf(scene) ?? 0xe000000000000000ul;
        public T GetComponentInParent<T>() => GetComponentInParent<T>(false);
        public T GetComponentInParent<T>(bool includeInactive) { for (var at = transform; !(at is null); at = at.above) if (includeInactive || at.gameObject.activeInHierarchy) foreach (var item in at.gameObject.components) if (item is T found) return found; return default; }
        public T[] GetComponentsInParent<T>() => GetComponentsInParent<T>(false);
        public T[] GetComponentsInParent<T>(bool includeInactive) { var found = new List<T>(); for (var at = transform; !(at is null); at = at.above) if (includeInactive || at.gameObject.activeInHierarchy) found.AddRange(at.gameObject.components.OfType<T>()); return found.ToArray(); }
        public static GameObject Find(string name) => StandIn.Objects.All().OfType<GameObject>().FirstOrDefault(item => item.activeInHierarchy && item.label == name);
        /// A metre wide, in the pipeline's own material.
        public static GameObject CreatePrimitive(PrimitiveType type)
        {
            if (type != PrimitiveType.Sphere && type != PrimitiveType.Cube) throw new NotImplementedException($"the stand-in draws no {type}");
            var made = new GameObject(type.ToString(), typeof(MeshFilter), typeof(MeshRenderer));
            made.GetComponent<MeshFilter>().sharedMesh = Mesh.own.Values.First(mesh => mesh.shape == type);
            made.GetComponent<MeshRenderer>().sharedMaterial = Renderer.Default;
            return made;
        }

        internal override void OnDestroyed()
        {
            isDying = true;
            foreach (var child in transform.Children()) StandIn.Objects.DestroyNow(child.gameObject);
            foreach (var component in components.ToArray().Reverse()) StandIn.Objects.DestroyNow(component);
        }
    }

    public class Component : Object
    {
        internal GameObject owner;
        public Component()
        {
            owner = StandIn.Objects.ownerOfNext;
            StandIn.Objects.ownerOfNext = null;
        }
        public GameObject gameObject { get { Alive(); return owner; } }
        public Transform transform { get { Alive(); return owner.transform; } }
        public string tag { get => gameObject.tag; set => gameObject.tag = value; }
        internal override string ownName { get => gameObject.name; set => gameObject.name = value; }
        public bool CompareTag(string tag) => gameObject.CompareTag(tag);
        internal override bool isInScene => owner.isInScene;
        internal override bool isActive => owner.activeInHierarchy;
        public T GetComponent<T>() => gameObject.GetComponent<T>();
        public Component GetComponent(Type type) => gameObject.GetComponent(type);
        public bool TryGetComponent<T>(out T component) => gameObject.TryGetComponent(out component);
        public T[] GetComponents<T>() => gameObject.GetComponents<T>();
        public void GetComponents<T>(List<T> results) => gameObject.GetComponents(results);
        public T GetComponentInChildren<T>() => gameObject.GetComponentInChildren<T>();
        public T GetComponentInChildren<T>(bool includeInactive) => gameObject.GetComponentInChildren<T>(includeInactive);
        public T[] GetComponentsInChildren<T>() => gameObject.GetComponentsInChildren<T>();
        public T[] GetComponentsInChildren<T>(bool includeInactive) => gameObject.GetComponentsInChildren<T>(includeInactive);
        public T GetComponentInParent<T>() => gameObject.GetComponentInParent<T>();
        public T[] GetComponentsInParent<T>() => gameObject.GetComponentsInParent<T>();
        public T[] GetComponentsInParent<T>(bool includeInactive) => gameObject.GetComponentsInParent<T>(includeInactive);
        public override string ToString() => isDestroyed ? "null" : $"{owner.label} ({GetType().FullName})";
        internal override void OnDestroyed() => owner.components.Remove(this);
    }

    public class Behaviour : Component
    {
        bool on = true;
        public bool enabled
        {
            get { StandIn.Threads.Main("get_enabled"); Alive(); return on; }
            set { StandIn.Threads.Main("set_enabled"); Alive(); if (on == value) return; on = value; StandIn.Lifecycle.Refresh(this); }
        }
        internal bool isOn => on;
        internal void TakeOver(bool on) => this.on = on;
        /// Called on what is no script when it is switched or moved.
        internal virtual void OnEngineRefresh() { }
        public bool isActiveAndEnabled => !isDestroyed && on && owner.activeInHierarchy;
    }

    public class MonoBehaviour : Behaviour
    {
        internal bool isAwake, isRunning, isStarted;
        internal Action update, lateUpdate, fixedUpdate;
        public MonoBehaviour()
        {
            if (owner is null && !StandIn.Objects.isReplacing) Debug.LogWarning("You are trying to create a MonoBehaviour using the 'new' keyword.  This is not allowed.  MonoBehaviours can only be added using AddComponent(). Alternatively, your script can inherit from ScriptableObject or no base class at all");
        }
        public bool useGUILayout { get; set; } = true;
        public bool runInEditMode { get; set; }
        public bool didAwake => isAwake;
        public bool didStart => isStarted;
        public static void print(object message) => Debug.Log(message);
        public Coroutine StartCoroutine(System.Collections.IEnumerator routine)
        {
            StandIn.Threads.Main("StartCoroutine");
            if (!isActiveAndEnabled) { Debug.LogError($"Coroutine couldn't be started because the the game object '{owner.label}' is inactive!"); return null; }
            return StandIn.Coroutines.Start(this, routine);
        }
        public void StopCoroutine(Coroutine routine) => StandIn.Coroutines.Stop(this, routine);
        public void StopAllCoroutines() => StandIn.Coroutines.Stop(this, null);
#if UNITY_2022_3_OR_NEWER
        readonly System.Threading.CancellationTokenSource ended = new System.Threading.CancellationTokenSource();
        public System.Threading.CancellationToken destroyCancellationToken => ended.Token;
#endif
        internal override void OnDestroyed()
        {
            StandIn.Lifecycle.Ended(this);
            ended.Cancel();
            base.OnDestroyed();
        }
    }

    public class YieldInstruction { }
    public sealed class Coroutine : YieldInstruction { internal Coroutine() { } internal MonoBehaviour owner; internal System.Collections.IEnumerator routine; internal bool isDone; }
    public sealed class WaitForEndOfFrame : YieldInstruction { }
    public abstract class CustomYieldInstruction : System.Collections.IEnumerator
    {
        public abstract bool keepWaiting { get; }
        public object Current => null;
        public bool MoveNext() => keepWaiting;
        public virtual void Reset() { }
    }
    public sealed class WaitUntil : CustomYieldInstruction { readonly Func<bool> predicate; public WaitUntil(Func<bool> predicate) => this.predicate = predicate; public override bool keepWaiting => !predicate(); }
    public sealed class WaitWhile : CustomYieldInstruction { readonly Func<bool> predicate; public WaitWhile(Func<bool> predicate) => this.predicate = predicate; public override bool keepWaiting => predicate(); }
}
