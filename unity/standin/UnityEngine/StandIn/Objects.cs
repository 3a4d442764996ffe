// All objects that there are, how they are made, and how they end.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Runtime.ExceptionServices;
using System.Threading;
using UnityEngine;
using Object = UnityEngine.Object;

namespace StandIn
{
    /// The main thread, and who may not be off it.
    public static class Threads
    {
        static int main = Thread.CurrentThread.ManagedThreadId;
        public static bool isMain => Thread.CurrentThread.ManagedThreadId == main;
        /// The type whose constructor runs: much of the engine may not be called from there.
        [ThreadStatic] internal static Type constructing;

        internal static void Main(string member)
        {
            if (!isMain)
                throw new UnityException($"{member} can only be called from the main thread.\nConstructors and field initializers will be executed from the loading thread when loading a scene.\nDon't use this function in the constructor or field initializers, instead move initialization code to the Awake or Start function.");
            if (constructing != null)
                throw new UnityException($"{member} is not allowed to be called from a {(typeof(MonoBehaviour).IsAssignableFrom(constructing) ? "MonoBehaviour" : "ScriptableObject")} constructor (or instance field initializer), call it in Awake or Start instead. Called from {constructing.Name}.");
        }
        public static void TakeMain() => main = Thread.CurrentThread.ManagedThreadId;
    }

    public static class Objects
    {
        static readonly Dictionary<int, Object> all = new Dictionary<int, Object>();
        static readonly List<Object> dying = new List<Object>();
        static int last;
        [ThreadStatic] internal static GameObject ownerOfNext;
        [ThreadStatic] internal static bool isMaking, isReplacing;

        internal static int Register(Object item)
        {
            if (!Threads.isMain) throw new UnityException($"{item.GetType().Name}..ctor can only be called from the main thread.");
            // Unity counts those made by scripts downwards.
            last -= 2;
            all[last] = item;
            return last;
        }
        internal static void Replace(int id, Object by) { by.instanceID = id; all[id] = by; }
        public static Object[] All() => all.Values.ToArray();
        internal static void Roots(UnityEngine.SceneManagement.Scene scene, List<GameObject> results)
        {
            foreach (var pair in all) if (pair.Value is GameObject found && found.transform.above is null && found.scene == scene) results.Add(found);
        }
        public static Object Find(int id) => all.TryGetValue(id, out var found) ? found : null;
        /// How many objects of a type there are.
        public static int Count<T>() where T : Object => all.Values.Count(item => item is T);

        /// Runs a constructor as the engine does.
        internal static object Make(Type type)
        {
            bool wasMaking = isMaking;
            var was = Threads.constructing;
            isMaking = true;
            var isScript = typeof(MonoBehaviour).IsAssignableFrom(type) || typeof(ScriptableObject).IsAssignableFrom(type);
            Threads.constructing = isScript ? type : null;
            try { return Activator.CreateInstance(type, true); }
            catch (TargetInvocationException error) { ExceptionDispatchInfo.Capture(error.InnerException).Throw(); throw; }
            finally { isMaking = wasMaking; Threads.constructing = was; }
        }

        internal static void DestroyLater(Object item) { if (!dying.Contains(item)) dying.Add(item); }
        internal static void EndFrame()
        {
            while (dying.Count > 0) { var item = dying[0]; dying.RemoveAt(0); if (item != null) DestroyNow(item); }
        }
        internal static void DestroyNow(Object item)
        {
            if (item.isDestroyed) return;
            if (item is Behaviour behaviour) Lifecycle.Stop(behaviour);
            item.OnDestroyed();
            item.isDestroyed = true;
            all.Remove(item.instanceID);
        }
        /// Ends all that is not an asset, between tests.
        public static void Clear()
        {
            foreach (var item in All().OfType<GameObject>().Where(item => item.transform.parent == null).ToArray()) if (item != null) DestroyNow(item);
            foreach (var item in All()) if (!item.isDestroyed && !item.isAsset) DestroyNow(item);
            dying.Clear();
        }
    }

    /// Calls a script's messages, `Awake` and so on, by their names.
    public static class Messages
    {
        static readonly Dictionary<(Type, string), MethodInfo> known = new Dictionary<(Type, string), MethodInfo>();

        internal static MethodInfo Find(Type type, string name)
        {
            if (known.TryGetValue((type, name), out var found)) return found;
            for (var at = type; at != null && at.Assembly != typeof(Object).Assembly && found == null; at = at.BaseType)
                found = at.GetMethod(name, BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly, null, Type.EmptyTypes, null);
            return known[(type, name)] = found;
        }

        /// Whether `OnValidate` runs, in which nothing may be destroyed at once.
        internal static bool isValidating { get; private set; }

        /// A script's exceptions are logged; the engine goes on.
        internal static bool Send(Object to, string name)
        {
            var method = Find(to.GetType(), name);
            if (method == null) return false;
            var was = isValidating;
            isValidating = name == "OnValidate";
            try { method.Invoke(to, null); }
            catch (TargetInvocationException error) { Debug.LogException(error.InnerException, to); }
            finally { isValidating = was; }
            return true;
        }
        internal static Action Bind(MonoBehaviour to, string name)
        {
            var method = Find(to.GetType(), name);
            return method == null || method.ReturnType != typeof(void) ? null : (Action)Delegate.CreateDelegate(typeof(Action), to, method);
        }
        internal static void Run(Action message, Object of)
        {
            try { using (Callbacks.Counted()) message(); }
            catch (Exception error) { Debug.LogException(error, of); }
        }
    }

    /// When scripts wake, run and end.
    public static class Lifecycle
    {
        static readonly List<MonoBehaviour> running = new List<MonoBehaviour>();
        static readonly List<MonoBehaviour> now = new List<MonoBehaviour>();

        internal static bool RunsHere(MonoBehaviour script) => Application.isPlaying || script.runInEditMode
            || Attribute.IsDefined(script.GetType(), typeof(ExecuteAlways), true) || Attribute.IsDefined(script.GetType(), typeof(ExecuteInEditMode), true);

        internal static void Added(Component component)
        {
            if (!(component is MonoBehaviour script)) { if (component is Behaviour other) other.OnEngineRefresh(); return; }
#if UNITY_EDITOR
            if (!Application.isPlaying) Messages.Send(script, "Reset");
            if (!script.isDestroyed) Messages.Send(script, "OnValidate");
#endif
            Refresh(script);
        }

        /// What a change in a hierarchy means to the scripts in it.
        internal static void Refresh(GameObject item)
        {
            foreach (var at in item.transform.WithChildren().ToArray())
                foreach (var component in at.gameObject.components.ToArray())
                    if (component is Behaviour behaviour && !behaviour.isDestroyed) Refresh(behaviour);
        }
        internal static void Refresh(Behaviour behaviour)
        {
            if (!(behaviour is MonoBehaviour script)) { behaviour.OnEngineRefresh(); return; }
            if (!RunsHere(script)) return;
            if (!script.isAwake && script.gameObject.activeInHierarchy)
            {
                script.isAwake = true;
                script.update = Messages.Bind(script, "Update");
                script.lateUpdate = Messages.Bind(script, "LateUpdate");
                script.fixedUpdate = Messages.Bind(script, "FixedUpdate");
                Messages.Send(script, "Awake");
            }
            if (script.isDestroyed) return;
            if (script.isActiveAndEnabled == script.isRunning) return;
            if (script.isActiveAndEnabled) Begin(script); else Stop(script);
        }
        static void Begin(MonoBehaviour script)
        {
            script.isRunning = true;
            running.Add(script);
            Messages.Send(script, "OnEnable");
        }
        internal static void Stop(Behaviour behaviour)
        {
            if (!(behaviour is MonoBehaviour script) || !script.isRunning) return;
            script.isRunning = false;
            running.Remove(script);
            if (!script.owner.activeInHierarchy || script.owner.isDying) Coroutines.Stop(script, null);
            Messages.Send(script, "OnDisable");
        }
        internal static void Ended(MonoBehaviour script)
        {
            Coroutines.Stop(script, null);
            if (script.isAwake) Messages.Send(script, "OnDestroy");
        }

        static void Each(Action<MonoBehaviour> action)
        {
            now.Clear();
            now.AddRange(running);
            now.Sort(byOrder);
            for (int i = 0; i < now.Count; i++) if (now[i].isRunning && !now[i].isDestroyed) action(now[i]);
        }
        static readonly Comparison<MonoBehaviour> byOrder = (a, b) => Order(a) != Order(b) ? Order(a) - Order(b) : b.instanceID - a.instanceID;
        static readonly Dictionary<Type, int> orders = new Dictionary<Type, int>();
        static int Order(MonoBehaviour script)
        {
            if (!orders.TryGetValue(script.GetType(), out var order))
                orders[script.GetType()] = order = ((DefaultExecutionOrder)Attribute.GetCustomAttribute(script.GetType(), typeof(DefaultExecutionOrder)))?.order ?? 0;
            return order;
        }
        static readonly Action<MonoBehaviour> start = script => { if (script.isStarted) return; script.isStarted = true; Messages.Send(script, "Start"); };
        static readonly Action<MonoBehaviour> update = script => { if (script.update != null) Messages.Run(script.update, script); };
        static readonly Action<MonoBehaviour> lateUpdate = script => { if (script.lateUpdate != null) Messages.Run(script.lateUpdate, script); };
        internal static void Start() => Each(start);
        internal static void Update() => Each(update);
        internal static void LateUpdate() => Each(lateUpdate);
        internal static void Gizmos()
        {
            Each(script => Messages.Send(script, "OnDrawGizmos"));
        }
        /// What the scene view calls for what is selected.
        public static void DrawGizmosSelected(MonoBehaviour script) => Messages.Send(script, "OnDrawGizmosSelected");
        /// What the inspector does after it changed a field.
        public static void Validate(Object item) => Messages.Send(item, "OnValidate");
        internal static MonoBehaviour[] Running() => running.ToArray();
        internal static void Forget(MonoBehaviour script) => running.Remove(script);
    }

    static class Coroutines
    {
        static readonly List<Coroutine> all = new List<Coroutine>();
        internal static Coroutine Start(MonoBehaviour owner, System.Collections.IEnumerator routine)
        {
            var started = new Coroutine { owner = owner, routine = routine };
            all.Add(started);
            Step(started);
            return started;
        }
        static void Step(Coroutine coroutine)
        {
            switch (coroutine.routine.Current)
            {
                case CustomYieldInstruction wait when wait.keepWaiting: return;
                case Coroutine other when !other.isDone: return;
                case AsyncOperation operation when !operation.isDone: return;
            }
            bool more = false;
            try { more = coroutine.routine.MoveNext(); }
            catch (Exception error) { Debug.LogException(error, coroutine.owner); }
            if (!more) { coroutine.isDone = true; all.Remove(coroutine); }
        }
        internal static void Update() { foreach (var coroutine in all.ToArray()) if (!coroutine.isDone) Step(coroutine); }
        internal static void Stop(MonoBehaviour owner, Coroutine which) => all.RemoveAll(coroutine => coroutine.owner == (object)owner && (which == null || coroutine == which));
    }
}
