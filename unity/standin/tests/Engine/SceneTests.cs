using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using NUnit.Framework;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using Object = UnityEngine.Object;

namespace StandIn.Tests
{
    [ExecuteAlways]
    class Everywhere : MonoBehaviour
    {
        internal readonly List<string> heard = new List<string>();
        public int number = 3;
        [SerializeField] internal Inner inner = new Inner();
        [NonSerialized] public int unkept = 5;
        public Everywhere friend;
        public List<Vector3> points = new List<Vector3>();
        public Asset asset;
        internal int hidden = 1;
        internal Inner never;
        [Serializable] internal class Inner { public string text = "a"; public float[] values = { 1 }; int own = 2; internal int Own { get => own; set => own = value; } }
        void Awake() => heard.Add("Awake");
        void OnEnable() => heard.Add("OnEnable");
        void Start() => heard.Add("Start");
        void Update() => heard.Add("Update");
        void LateUpdate() => heard.Add("LateUpdate");
        void OnDisable() => heard.Add("OnDisable");
        void OnDestroy() => heard.Add("OnDestroy");
    }
    class OnlyInPlay : MonoBehaviour { internal int awakened, started; void Awake() => awakened++; void Start() => started++; }
    [RequireComponent(typeof(Camera))] [DisallowMultipleComponent] class Needy : MonoBehaviour { }
    class Asset : ScriptableObject { public int value = 1; internal int enabledCount; void OnEnable() => enabledCount++; }
    class Hasty : MonoBehaviour { readonly string early = Application.dataPath; internal string Early => early; }
    class Failing : MonoBehaviour { void Awake() => throw new InvalidOperationException("on purpose"); }

    class ObjectTests
    {
        [Test]
        void A_destroyed_object_is_null()
        {
            var item = new GameObject("item");
            var light = item.AddComponent<Light>();
            Object.DestroyImmediate(item);
            Assert.That(item == null && light == null && !light);
            Assert.That(ReferenceEquals(item, null), Is.False);
            Assert.Throws<MissingReferenceException>(() => item.SetActive(true));
        }

        [Test]
        void Destroy_is_for_play_mode_and_waits_for_the_end_of_the_frame()
        {
            var item = new GameObject();
            Log.Expect(LogType.Error, "Destroy may not be called from edit mode");
            Object.Destroy(item);
            Assert.That(item != null);
            Domain.Play(false);
            Object.Destroy(item);
            Assert.That(item != null);
            Engine.Frame();
            Assert.That(item == null);
        }

        [Test]
        void Messages_come_in_their_order()
        {
            var item = new GameObject();
            var script = item.AddComponent<Everywhere>();
            Engine.Frame();
            script.enabled = false;
            script.enabled = true;
            item.SetActive(false);
            Engine.Frame();
            var heard = script.heard;
            Object.DestroyImmediate(item);
            Assert.That(heard, Is.EqualTo(new[] { "Awake", "OnEnable", "Start", "Update", "LateUpdate", "OnDisable", "OnEnable", "OnDisable", "OnDestroy" }));
        }

        [Test]
        void Without_ExecuteAlways_scripts_run_in_play_mode_only()
        {
            var item = new GameObject();
            var script = item.AddComponent<OnlyInPlay>();
            Engine.Frame();
            Assert.That(script.awakened, Is.Zero);
            Domain.Play(false);
            script = item.GetComponent<OnlyInPlay>();
            Engine.Frame();
            Assert.That((script.awakened, script.started), Is.EqualTo((1, 1)));
            Domain.Stop();
        }

        [Test]
        void Components_need_and_exclude_others()
        {
            var item = new GameObject();
            item.AddComponent<Needy>();
            Assert.That(item.GetComponent<Camera>() != null);
            Log.Expect(LogType.Error, "Can't add component 'Needy'");
            Assert.That(item.AddComponent<Needy>(), Is.Null);
        }

        [Test]
        void A_constructor_may_not_call_the_engine() => Assert.Throws<UnityException>(() => new GameObject().AddComponent<Hasty>());

        [Test]
        void An_exception_in_a_message_is_logged()
        {
            Domain.Play(false);
            Log.Expect(LogType.Exception, "InvalidOperationException: on purpose");
            new GameObject().AddComponent<Failing>();
        }

        [Test]
        void The_engine_belongs_to_the_main_thread()
        {
            var item = new GameObject("item");
            var faults = new List<Exception>();
            void Try(Action action) { try { action(); } catch (Exception error) { faults.Add(error); } }
            var thread = new Thread(() =>
            {
                Try(() => item.name = "other");
                Try(() => _ = Application.isPlaying);
                Try(() => item.GetInstanceID());
                Try(() => _ = item.transform.position);
                Try(() => new GraphicsBuffer(GraphicsBuffer.Target.Raw, 1, 4));
                Try(() => _ = Application.persistentDataPath);
                Try(() => _ = Time.time);
                Try(() => ScriptableObject.CreateInstance<Asset>());
            });
            thread.Start();
            thread.Join();
            Assert.That(faults.Count, Is.EqualTo(8));
            // This one is asked in C#.
            Assert.That(faults[2], Is.TypeOf<InvalidOperationException>());
            faults.RemoveAt(2);
            Assert.That(faults.Select(fault => fault.GetType()), Is.All.EqualTo(typeof(UnityException)));
            Assert.That(faults[0].Message, Does.StartWith("set_name can only be called from the main thread."));
        }

        [Test]
        void Transforms_follow_their_parents()
        {
            Transform parent = new GameObject("parent").transform, child = new GameObject("child").transform;
            parent.SetPositionAndRotation(new Vector3(1, 2, 3), Quaternion.Euler(0, 90, 0));
            parent.localScale = Vector3.one * 2;
            child.SetParent(parent, false);
            child.localPosition = Vector3.forward;
            Assert.That(child.position == new Vector3(3, 2, 3), child.position.ToString("F5"));
            child.SetParent(null, true);
            Assert.That(child.position == new Vector3(3, 2, 3) && child.localScale == Vector3.one * 2);
            Assert.That(child.forward == Vector3.right, child.forward.ToString());
            child.hasChanged = false;
            child.SetParent(parent);
            parent.position = Vector3.zero;
            Assert.That(child.hasChanged);
        }

        [Test]
        void A_rotation_is_a_rotation_however_it_is_written()
        {
            var random = new System.Random(3);
            for (int i = 0; i < 100; i++)
            {
                float Angle() => (float)random.NextDouble() * 360 - 180;
                var rotation = Quaternion.Euler(Angle() / 2.01f, Angle(), Angle());
                Assert.That(Quaternion.Angle(rotation, Quaternion.Euler(rotation.eulerAngles)), Is.LessThan(.2));
                Assert.That(Quaternion.Angle(rotation, Matrix4x4.Rotate(rotation).rotation), Is.LessThan(.2));
                var matrix = Matrix4x4.TRS(new Vector3(1, 2, 3), rotation, new Vector3(2, 3, 4));
                Assert.That((matrix * matrix.inverse).isIdentity);
            }
            Assert.That(Quaternion.Euler(0, 90, 0) * Vector3.forward == Vector3.right);
            Assert.That(Quaternion.Euler(90, 0, 0) * Vector3.forward == Vector3.down);
        }

        [Test]
        void Projections_are_reversed_and_flipped_for_textures()
        {
            var projection = Matrix4x4.Perspective(60, 2, .5f, 100);
            foreach (var texture in new[] { false, true })
            {
                var device = GL.GetGPUProjectionMatrix(projection, texture);
                Assert.That(device.MultiplyPoint(new Vector3(0, 0, -.5f)).z, Is.EqualTo(1).Within(1e-5));
                Assert.That(device.MultiplyPoint(new Vector3(0, 0, -100)).z, Is.EqualTo(0).Within(1e-5));
                Assert.That(device.MultiplyPoint(new Vector3(0, 1, -1)).y > 0, Is.EqualTo(!texture));
            }
        }

        [Test]
        void Clones_have_their_own_values_and_refer_to_their_own_parts()
        {
            var prefab = new GameObject("prefab");
            var script = prefab.AddComponent<Everywhere>();
            var child = new GameObject("child").AddComponent<Everywhere>();
            child.transform.SetParent(prefab.transform);
            script.friend = child;
            script.number = 8;
            script.hidden = 9;
            script.points.Add(Vector3.up);
            var clone = Object.Instantiate(script);
            Assert.That(clone.friend, Is.SameAs(clone.transform.GetChild(0).GetComponent<Everywhere>()));
            Assert.That((clone.number, clone.hidden, clone.points.Count), Is.EqualTo((8, 1, 1)));
            Assert.That(clone.points, Is.Not.SameAs(script.points));
            Assert.That(clone.gameObject.name, Is.EqualTo("prefab(Clone)"));
        }
    }

    class DomainTests
    {
        [Test]
        void A_reload_keeps_what_is_serialised()
        {
            var item = new GameObject("item");
            var before = item.AddComponent<Everywhere>();
            var asset = ScriptableObject.CreateInstance<Asset>();
            asset.value = 12;
            before.number = 7;
            before.unkept = before.hidden = 6;
            before.inner.text = "b";
            before.inner.Own = 4;
            before.inner.values = new[] { 2f, 3f };
            before.friend = before;
            before.asset = asset;
            Engine.Frame();
            Domain.Reload();
            var after = item.GetComponent<Everywhere>();
            Assert.That(after, Is.Not.SameAs(before));
            Assert.That(before == null && after.GetInstanceID() == before.GetInstanceID());
            Assert.That(before.heard.Last(), Is.EqualTo("OnDisable"));
            Assert.That(after.heard, Is.EqualTo(new[] { "OnEnable" }), "awake it was before");
            // Private fields, too, unlike in clones; and out of nothing comes an empty object.
            Assert.That((after.number, after.unkept, after.hidden), Is.EqualTo((7, 5, 6)));
            Assert.That((after.inner.text, after.inner.Own, after.inner.values.Length), Is.EqualTo(("b", 4, 2)));
            Assert.That(before.never, Is.Null);
            Assert.That(after.never.text, Is.EqualTo("a"));
            Assert.That(after.friend, Is.SameAs(after));
            Assert.That(asset == null && after.asset.value == 12 && after.asset.enabledCount == 2);
        }

        [Test]
        void Play_mode_wakes_the_scene_and_goes_back()
        {
            var item = new GameObject();
            item.AddComponent<Everywhere>();
            Domain.Play();
            var script = item.GetComponent<Everywhere>();
            Assert.That(Application.isPlaying);
            Assert.That(script.heard.Count(word => word == "OnEnable") - script.heard.Count(word => word == "OnDisable"), Is.EqualTo(1));
            var lasting = new GameObject("lasting");
            Object.DontDestroyOnLoad(lasting);
            Assert.That(lasting.scene.name, Is.EqualTo("DontDestroyOnLoad"));
            Domain.Stop();
            Assert.That(lasting == null && !Application.isPlaying);
        }

        [TestCase(false)]
        [TestCase(true)]
        void Scripts_are_other_instances_in_play_mode_and_after_it(bool reloads)
        {
            var item = new GameObject("item");
            var edited = item.AddComponent<Everywhere>();
            edited.number = 7;
            edited.hidden = 8;
            edited.friend = edited;
            edited.asset = ScriptableObject.CreateInstance<Asset>();
            edited.asset.value = 5;
            var hidden = new GameObject("hidden") { hideFlags = HideFlags.HideAndDontSave }.AddComponent<Everywhere>();
            Domain.Play(reloads);
            Assert.That(edited == null && edited.heard.Last() == (reloads ? "OnDisable" : "OnDestroy"));
            Assert.That(hidden == null, Is.EqualTo(reloads), "what is not saved is not loaded anew");
            var played = item.GetComponent<Everywhere>();
            Assert.That(played.heard, Is.EqualTo(new[] { "Awake", "OnEnable" }));
            Assert.That((played.number, played.asset.value, played.hidden, played.friend == played), Is.EqualTo((7, 5, 1, true)), "what is serialised is kept, no more");
            played.number = 9;
            played.asset.value = 6;
            var made = new GameObject("made in play mode");
            Domain.Stop();
            Assert.That(made == null && played == null);
            var after = item.GetComponent<Everywhere>();
            Assert.That((after.number, after.asset.value, after.friend == after), Is.EqualTo((7, 5, true)), "the scene is what it was");
            Assert.That(after.heard, Is.EqualTo(new[] { "Awake", "OnEnable" }));
        }
    }

    enum Wide : ulong { None, Some }
    class Keeper : ScriptableObject
    {
        public Dictionary<string, int> dictionary = new Dictionary<string, int>();
        public HashSet<int> set = new HashSet<int>();
        public DateTime time = new DateTime(1);
        public (int, int) pair = (1, 1);
        public Wide wide;
        public int[,] grid = new int[1, 1];
        public List<List<int>> lists = new List<List<int>>();
        public int Property { get; set; } = 1;
        public static int shared = 1;
        public readonly int constant = 1;
        public Bounds bounds;
        public Matrix4x4 matrix;
        public Vector3Int place;
        public List<Vector2> points = new List<Vector2>();
        public ScriptableObject toDestroy;
        void OnValidate() { if (toDestroy != null) DestroyImmediate(toDestroy); }
    }

    class SerialisationTests
    {
        [Test]
        void Some_types_are_serialised_and_others_are_not()
        {
            var names = Serializer.FieldsOf(typeof(Keeper)).Select(field => field.Name);
            Assert.That(names, Is.EquivalentTo(new[] { "bounds", "matrix", "place", "points", "toDestroy" }));
            var keeper = ScriptableObject.CreateInstance<Keeper>();
            keeper.bounds = new Bounds(Vector3.one, Vector3.one * 2);
            keeper.matrix = Matrix4x4.Translate(Vector3.one);
            keeper.wide = Wide.Some;
            var clone = Object.Instantiate(keeper);
            Assert.That((clone.bounds, clone.matrix, clone.wide), Is.EqualTo((keeper.bounds, keeper.matrix, Wide.None)));
        }

        [Test]
        void Nothing_is_destroyed_at_once_while_it_is_validated()
        {
            var keeper = ScriptableObject.CreateInstance<Keeper>();
            keeper.toDestroy = ScriptableObject.CreateInstance<Asset>();
            Log.Expect(LogType.Error, "Destroying assets immediately is not permitted");
            Lifecycle.Validate(keeper);
            Assert.That(keeper.toDestroy != null);
        }
    }

    unsafe class CollectionTests
    {
        [Test]
        void A_disposed_array_is_not_used()
        {
            var array = new NativeArray<int>(4, Allocator.Persistent);
            var copy = array;
            array[3] = 5;
            Assert.That(copy[3], Is.EqualTo(5));
            Assert.Throws<IndexOutOfRangeException>(() => copy[4] = 1);
            array.Dispose();
            Assert.Throws<ObjectDisposedException>(() => _ = copy[0]);
            Assert.Throws<ObjectDisposedException>(() => copy.Dispose());
        }

        [Test]
        void Memory_that_was_converted_needs_a_safety_handle()
        {
            var memory = stackalloc int[4];
            var array = NativeArrayUnsafeUtility.ConvertExistingDataToNativeArray<int>(memory, 4, Allocator.None);
            Assert.Throws<NullReferenceException>(() => _ = array[0]);
            var handle = AtomicSafetyHandle.Create();
            NativeArrayUnsafeUtility.SetAtomicSafetyHandle(ref array, handle);
            array[0] = 3;
            Assert.That(memory[0], Is.EqualTo(3));
            AtomicSafetyHandle.Release(handle);
            Assert.Throws<ObjectDisposedException>(() => _ = array[0]);
        }

        [Serializable] class Scan { public string name = "none"; public int[] sizes = { 1 }; public Part part; public float scale = 1; public bool isWhole; int own = 4; internal int Own => own; }
        [Serializable] class Part { public string text = "part"; }

        [Test]
        void Json_has_the_fields_that_are_serialised()
        {
            var scan = JsonUtility.FromJson<Scan>("{\"name\": \"a \\\"b\\\" \\u00e9\", \"sizes\": [3, -4], \"other\": {\"x\": [null]}, \"scale\": 1.5e-2, \"isWhole\": true, \"own\": 7, \"part\": null}");
            Assert.That((scan.name, scan.sizes.Length, scan.sizes[1], scan.scale, scan.isWhole, scan.Own, scan.part.text), Is.EqualTo(("a \"b\" \u00e9", 2, -4, .015f, true, 4, "part")));
            Assert.That(JsonUtility.ToJson(scan), Is.EqualTo("{\"name\":\"a \\\"b\\\" \u00e9\",\"sizes\":[3,-4],\"part\":{\"text\":\"part\"},\"scale\":0.015,\"isWhole\":true}"));
            Assert.Throws<ArgumentException>(() => JsonUtility.FromJson<Scan>("{\"name\": }"));
        }

        [Test]
        void Halves_round_to_the_nearest()
        {
            for (int bits = 0; bits < 0x7c00; bits++) Assert.That(Half.FromSingle(Half.ToSingle((ushort)bits)), Is.EqualTo(bits));
            Assert.That(Half.ToSingle(Half.FromSingle(1 + 1 / 2048f)), Is.EqualTo(1), "to even");
            Assert.That(Half.ToSingle(Half.FromSingle(70000)), Is.EqualTo(float.PositiveInfinity));
        }
    }
}
