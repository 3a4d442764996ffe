// Reloading the scripts' domain, as the editor does when scripts were compiled and when play mode is entered: what is
// serialised survives, all else begins anew.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEngine;
using Object = UnityEngine.Object;

namespace StandIn
{
    public static class Domain
    {
        /// What the editor tells scripts, before and after.
        public static event Action beforeReload, afterReload;

        /// Assemblies of scripts: those that know the engine and are neither its own nor the tests'.
        public static IEnumerable<Assembly> Scripts() => AppDomain.CurrentDomain.GetAssemblies().Where(assembly =>
        {
            if (assembly.IsDynamic) return false;
            var name = assembly.GetName().Name;
            return !name.StartsWith("Unity") && !name.StartsWith("StandIn") && !name.Contains(".Tests") && assembly.GetReferencedAssemblies().Any(reference => reference.Name == "UnityEngine");
        });

        public static void Reload() => Reload(Application.isPlaying);

        static void Reload(bool plays)
        {
            Threads.Main("a domain reload");
            beforeReload?.Invoke();
            var running = Lifecycle.Running();
            foreach (var script in running) { Lifecycle.Forget(script); script.isRunning = false; Messages.Send(script, "OnDisable"); }
            var objects = Objects.All();
            foreach (var item in objects.OfType<ScriptableObject>()) if (item.isEnabled) { item.isEnabled = false; Messages.Send(item, "OnDisable"); }
            foreach (var script in objects.OfType<MonoBehaviour>()) Coroutines.Stop(script, null);

            // New instances in place of the old, under the same numbers. Constructors run before statics are reset, as
            // nothing may be seen of that: they may not call the engine.
            ClearStatics();
            var map = new Dictionary<Object, Object>(new ByReference());
            foreach (var old in objects)
            {
                if (old.isDestroyed || !(old is MonoBehaviour || old is ScriptableObject) || old.GetType().Assembly == typeof(Object).Assembly) continue;
                Objects.isReplacing = true;
                Object made;
                try { made = (Object)Objects.Make(old.GetType()); }
                finally { Objects.isReplacing = false; }
                map[old] = made;
            }
            foreach (var pair in map)
            {
                var (old, made) = (pair.Key, pair.Value);
                Objects.Replace(old.instanceID, made);
                made.TakeIdentity(old);
                if (old is MonoBehaviour was)
                {
                    var now = (MonoBehaviour)made;
                    now.owner = was.owner;
                    now.TakeOver(was.isOn);
                    now.isAwake = was.isAwake;
                    now.isStarted = was.isStarted;
                    now.runInEditMode = was.runInEditMode;
                    was.owner.components[was.owner.components.IndexOf(was)] = now;
                }
            }
            foreach (var pair in map) Serializer.Copy(pair.Key, pair.Value, item => map.TryGetValue(item, out var now) ? now : item, isReload: true);
            foreach (var old in map.Keys) old.isDestroyed = true;
            Application.ForgetListeners();
            UnityEngine.Rendering.RenderPipelineManager.Forget();
            Camera.Forget();
            Application.playing = plays;

            foreach (var made in map.Values.OfType<ScriptableObject>()) { made.isEnabled = true; Messages.Send(made, "OnEnable"); }
            afterReload?.Invoke();
            foreach (var made in map.Values.OfType<MonoBehaviour>())
            {
                made.update = Messages.Bind(made, "Update");
                made.lateUpdate = Messages.Bind(made, "LateUpdate");
                made.fixedUpdate = Messages.Bind(made, "FixedUpdate");
                if (made.isDestroyed) continue;
                Messages.Send(made, "OnValidate");
                Lifecycle.Refresh(made);
            }
        }

        sealed class ByReference : IEqualityComparer<Object>
        {
            public bool Equals(Object a, Object b) => ReferenceEquals(a, b);
            public int GetHashCode(Object item) => System.Runtime.CompilerServices.RuntimeHelpers.GetHashCode(item);
        }

        /// Statics begin anew: zeros, then what initialisers say. What compiled code has taken for constant (readonly
        /// fields, after it was optimised) it may go on using.
        static void ClearStatics()
        {
            foreach (var type in Scripts().SelectMany(assembly => assembly.GetTypes()).Where(type => !type.ContainsGenericParameters))
            {
                foreach (var field in type.GetFields(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly))
                    if (!field.IsLiteral && !field.IsInitOnly && !field.FieldType.IsPointer)
                        field.SetValue(null, field.FieldType.IsValueType ? Activator.CreateInstance(field.FieldType) : null);
                type.TypeInitializer?.Invoke(null, null);
            }
        }

        static void RuntimeInitialize(params RuntimeInitializeLoadType[] when)
        {
            foreach (var kind in when)
                foreach (var type in Scripts().SelectMany(assembly => assembly.GetTypes()))
                    foreach (var method in type.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly))
                        if (method.GetCustomAttribute<RuntimeInitializeOnLoadMethodAttribute>() is RuntimeInitializeOnLoadMethodAttribute attribute && attribute.loadType == kind)
                            method.Invoke(null, null);
        }

        /// Enters play mode: with a new domain unless the project says that it keeps it.
        public static void Play(bool reloads = true)
        {
            if (Application.isPlaying) throw new InvalidOperationException("it is playing");
            if (reloads) { Reload(true); }
            else
            {
                foreach (var script in Lifecycle.Running()) { Lifecycle.Stop(script); }
                Application.playing = true;
            }
            RuntimeInitialize(RuntimeInitializeLoadType.SubsystemRegistration, RuntimeInitializeLoadType.AfterAssembliesLoaded, RuntimeInitializeLoadType.BeforeSplashScreen, RuntimeInitializeLoadType.BeforeSceneLoad);
            // The scene is loaded anew, so that everything in it wakes again.
            foreach (var script in Objects.All().OfType<MonoBehaviour>()) if (!script.isRunning) { script.isAwake = script.isStarted = false; }
            foreach (var item in Objects.All().OfType<GameObject>().Where(item => item.transform.above is null && !item.isPrefab).ToArray()) Lifecycle.Refresh(item);
            RuntimeInitialize(RuntimeInitializeLoadType.AfterSceneLoad);
        }

        /// Back to editing: objects that were made in play mode end, as they were not saved; but for those that nothing but
        /// their maker ends, by HideFlags.
        public static void Stop()
        {
            if (!Application.isPlaying) throw new InvalidOperationException("it is not playing");
            Application.Quitting();
            foreach (var script in Lifecycle.Running()) Lifecycle.Stop(script);
            Application.playing = false;
            foreach (var item in Objects.All().OfType<GameObject>().Where(item => item.isLasting && (item.hideFlags & HideFlags.DontSaveInEditor) == 0).ToArray()) Objects.DestroyNow(item);
            foreach (var script in Objects.All().OfType<MonoBehaviour>()) { script.isAwake = script.isStarted = false; }
            foreach (var item in Objects.All().OfType<GameObject>().Where(item => item.transform.above is null && !item.isPrefab).ToArray()) Lifecycle.Refresh(item);
        }
    }
}
