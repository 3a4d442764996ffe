// Runs tests in a console: methods with [Test] or [TestCase] of all assemblies beside this one whose names contain `.Tests`.
// A test that returns an IEnumerator gets a frame for each step, one that returns a Task gets frames until it is done.
// It fails by an exception, by an error that is logged and not expected, and by what it leaves alive.
//
// Those of [Category("Slow")] run where --all or a name asks for them.
//
//     StandIn.Tests.Program [--list] [--log] [--all] [PART OF A NAME]...
//     StandIn.Tests.Program --frame-cost
using System;
using System.Collections;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Threading;
using System.Threading.Tasks;
using NUnit.Framework;

namespace StandIn.Tests
{
    static class Program
    {
        sealed class Case { internal MethodInfo method; internal object[] arguments; internal string name; internal bool isSlow; }

        /// Unity's Test Framework goes by the platforms of a test's assembly definition; here its name says it.
        static bool IsOfPlayMode(MethodInfo method) => method.DeclaringType.Assembly.GetName().Name.Contains("PlayMode");

        static bool IsExplicit(MethodInfo method) => method.IsDefined(typeof(ExplicitAttribute)) || method.DeclaringType.IsDefined(typeof(ExplicitAttribute));

        static bool IsSlow(MemberInfo of) => of.GetCustomAttributes<CategoryAttribute>().Any(category => category.Name == "Slow");

        static int Main(string[] arguments)
        {
            Threads.TakeMain();
            SynchronizationContext.SetSynchronizationContext(new MainContext());
            var filters = arguments.Where(argument => !argument.StartsWith("--")).ToArray();
            Log.isPrinted |= arguments.Contains("--log");
            if (arguments.Contains("--frame-cost"))
            {
                // No test: nothing fails when it changes.
                Assemblies().Select(assembly => assembly.GetType("Lumivox.Tests.FrameCost")).Single(type => type != null).GetMethod("Print").Invoke(null, null);
                return 0;
            }
            var cases = Assemblies().SelectMany(assembly => assembly.GetTypes()).OrderBy(type => type.FullName, StringComparer.Ordinal).SelectMany(CasesOf).ToList();
            if (cases.Count == 0) { Console.Error.WriteLine("error: there are no tests"); return 2; }
            // Explicit ones have to be named from their class on, not met by chance.
            var chosen = cases.Where(one => IsExplicit(one.method) ? filters.Any(one.name.StartsWith) : filters.Length == 0 || filters.Any(one.name.Contains)).ToList();
            var slow = filters.Length > 0 || arguments.Contains("--all") ? 0 : chosen.RemoveAll(one => one.isSlow);
            if (chosen.Count == 0) { Console.Error.WriteLine($"error: no test's name contains {string.Join(" or ", filters)}"); return 2; }
            if (arguments.Contains("--list")) { foreach (var one in chosen) Console.WriteLine(one.name); return 0; }

            Domain.Remember();
            // As when the editor has compiled them.
            foreach (var assembly in Domain.Scripts()) EditorHost.Load(assembly);
            int passed = 0, failed = 0;
            foreach (var one in chosen)
            {
                var watch = Stopwatch.StartNew();
                var fault = Run(one);
                Console.WriteLine($"{one.name}: {(fault == null ? "ok" : "FAILED")}{(watch.ElapsedMilliseconds >= 500 ? $" ({watch.Elapsed.TotalSeconds:0.0} s)" : "")}");
                if (fault == null) passed++; else { failed++; Console.WriteLine("    " + fault.Trim().Replace("\n", "\n    ")); }
            }
            if (slow > 0) Console.WriteLine($"slow ones were left out, --all runs them: {slow}");
            Console.WriteLine($"{passed} passed, {failed} failed, {slow} ignored");
            return failed == 0 ? 0 : 1;
        }

        static IEnumerable<Assembly> Assemblies()
        {
            var here = Path.GetDirectoryName(typeof(Program).Assembly.Location);
            // The package's assemblies are there before tests look for what is loaded.
            foreach (var file in Directory.GetFiles(here, "*.dll").OrderBy(file => file, StringComparer.Ordinal))
            {
                var name = Path.GetFileNameWithoutExtension(file);
                if (name == "StandIn.Tests.Program" || name == "nunit.framework" || !File.Exists(file + ".stamp")) continue;
                var assembly = Assembly.LoadFrom(file);
                if (name.Contains(".Tests")) yield return assembly;
            }
        }

        static IEnumerable<Case> CasesOf(Type type)
        {
            if (type.IsAbstract && !type.IsSealed || type.ContainsGenericParameters) yield break;
            foreach (var method in type.GetMethods(BindingFlags.Instance | BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic))
            {
                var name = $"{type.Name}.{method.Name}";
                if (method.GetCustomAttribute<IgnoreAttribute>() != null) throw new NotSupportedException($"{name}: tests are not ignored");
                var isSlow = IsSlow(type) || IsSlow(method);
                foreach (var values in method.GetCustomAttributes<TestCaseAttribute>())
                    yield return new Case { method = method, isSlow = isSlow || values.Category == "Slow", arguments = values.Arguments, name = $"{name}({string.Join(", ", values.Arguments.Select(value => value ?? "null"))})" };
                if (method.GetCustomAttributes().Any(attribute => attribute is TestAttribute || attribute.GetType().Name == "UnityTestAttribute"))
                    yield return new Case { method = method, isSlow = isSlow, arguments = Array.Empty<object>(), name = name };
            }
        }

        /// What is wrong, or null.
        static string Run(Case one)
        {
            Log.Clear();
            new NUnit.Framework.Internal.TestExecutionContext.AdhocContext().EstablishExecutionEnvironment();
            var before = Alive();
            var faults = new List<string>();
            object instance = null;
            try
            {
                if (IsOfPlayMode(one.method)) Domain.Play();
                if (!one.method.IsStatic) instance = Activator.CreateInstance(one.method.DeclaringType, true);
                Call<SetUpAttribute>(one, instance);
                Finish(one.method.Invoke(instance, one.arguments));
            }
            catch (Exception error) { faults.Add(Tell(error)); }
            try { Call<TearDownAttribute>(one, instance); }
            catch (Exception error) { faults.Add(Tell(error)); }
            try
            {
                if (UnityEngine.Application.isPlaying) Domain.Stop();
                Engine.Clear();
            }
            catch (Exception error) { faults.Add("after the test: " + Tell(error)); }
            var logged = Log.Faults();
            if (logged != "") faults.Add(logged);
            var after = Alive();
            for (int i = 0; i < before.Length; i++)
                if (after[i].count > before[i].count) faults.Add($"left alive: {after[i].count - before[i].count} {after[i].what}\n{Live.Describe()}");
            return faults.Count == 0 ? null : string.Join("\n", string.Join("\n", faults).Split('\n').Where(IsTelling));
        }

        /// Of stacks, the lines that lie in sources of ours.
        static bool IsTelling(string line) => !line.TrimStart().StartsWith("at ") || line.Contains(" in ") && !line.Contains("UnityEngine.Debug.") && !line.Contains("StandIn.Tests.Program.");

        static (string what, int count)[] Alive() => new[]
        {
            ("GraphicsBuffers", Live.buffers), ("RenderTextures", Live.renderTextures), ("textures", Live.textures), ("CommandBuffers", Live.commandBuffers),
            ("preview scenes", PreviewScenes.count), ("native allocations", Live.allocations), ("safety handles", Live.safetyHandles),
        };

        static void Call<T>(Case one, object instance) where T : Attribute
        {
            var type = one.method.DeclaringType;
            foreach (var method in type.GetMethods(BindingFlags.Instance | BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic))
                if (method.GetCustomAttribute<T>() != null) Finish(method.Invoke(method.IsStatic ? null : instance, null));
        }

        static void Finish(object result)
        {
            if (result is IEnumerator steps)
            {
                while (steps.MoveNext())
                {
                    Engine.Frame();
                    EditorHost.Frame();
                }
            }
            else if (result is Task task)
            {
                for (int frames = 0; !task.IsCompleted; frames++)
                {
                    if (frames > 20000) throw new TimeoutException("the task was not done after 20000 frames");
                    Engine.Frame();
                    Thread.Sleep(1);
                }
                task.GetAwaiter().GetResult();
            }
        }

        static string Tell(Exception error)
        {
            while (error is TargetInvocationException && error.InnerException != null) error = error.InnerException;
            var own = error.GetType().Namespace == "NUnit.Framework";
            return $"{(own ? "" : error.GetType().Name + ": ")}{error.Message.Trim()}\n{error.StackTrace}";
        }
    }
}
