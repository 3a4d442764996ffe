// Primitives, drawn in their material's plain colour: no meshes, no shading, no colliders.
using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public class Renderer : Component
    {
        static readonly List<Renderer> all = new List<Renderer>();
        /// Those that there are, drawn or not.
        internal static IReadOnlyList<Renderer> All => all;
        Material shared;
        bool isOwn;

        public Renderer() => all.Add(this);
        public bool enabled { get; set; } = true;
        public Material sharedMaterial
        {
            get { StandIn.Threads.Main("GetMaterial"); Alive(); return shared; }
            set { StandIn.Threads.Main("SetMaterial"); Alive(); (shared, isOwn) = (value, false); }
        }
        /// The renderer's own copy, which is made by asking for it, and is nobody's to destroy but the asker's.
        public Material material
        {
            get
            {
                StandIn.Threads.Main("GetMaterial");
                Alive();
                if (!Application.isPlaying) Debug.LogError("Instantiating material due to calling renderer.material during edit mode. This will leak materials into the scene. You most likely want to use renderer.sharedMaterial instead.");
                if (!isOwn && shared != null) (shared, isOwn) = (new Material(shared) { name = shared.name + " (Instance)" }, true);
                return shared;
            }
            set { sharedMaterial = value; isOwn = true; }
        }
        internal override void OnDestroyed() { all.Remove(this); base.OnDestroyed(); }

        /// What the pipeline gives to things that are made in its scenes.
        internal static Material Default
        {
            get
            {
                if (lit != null) return lit;
                var shader = new Shader { name = "Stand-in/Lit", isAsset = true };
                shader.properties["_Color"] = Vector4.one;
                return lit = new Material(shader) { name = "Default-Material", isAsset = true };
            }
        }
        static Material lit;
    }

    public class MeshRenderer : Renderer { }

    public sealed class MeshFilter : Component { public Mesh sharedMesh { get; set; } }

    public sealed class Mesh : Object
    {
        /// Those that the engine has.
        internal static readonly Dictionary<string, Mesh> own = new Dictionary<string, Mesh>
        {
            ["New-Sphere.fbx"] = new Mesh(PrimitiveType.Sphere),
            ["Cube.fbx"] = new Mesh(PrimitiveType.Cube),
        };
        internal readonly PrimitiveType shape;
        public Mesh() => throw new NotImplementedException("the stand-in has no meshes but the engine's own");
        Mesh(PrimitiveType shape) { this.shape = shape; name = shape.ToString(); isAsset = true; }
    }
}

namespace StandIn
{
    /// Rays and primitives: a sphere or a cube of a metre, wherever its transform puts it.
    static class Primitives
    {
        struct Shape { internal UnityEngine.Matrix4x4 inverse; internal bool isSphere; internal UnityEngine.Color color; internal int layer; }

        static readonly List<Shape> seen = new List<Shape>();

        /// Looks where they are, once for each picture.
        internal static void Gather(ulong scenes)
        {
            seen.Clear();
            foreach (var renderer in UnityEngine.Renderer.All)
            {
                if (!renderer.enabled || !renderer.owner.activeInHierarchy || (renderer.owner.sceneCullingMask & scenes) == 0 || !renderer.TryGetComponent<UnityEngine.MeshFilter>(out var filter) || filter.sharedMesh == null || renderer.sharedMaterial == null) continue;
                seen.Add(new Shape
                {
                    inverse = renderer.transform.localToWorldMatrix.inverse,
                    isSphere = filter.sharedMesh.shape == UnityEngine.PrimitiveType.Sphere,
                    color = ColorOf(renderer.sharedMaterial).linear,
                    layer = renderer.owner.layer,
                });
            }
        }

        /// What a surface shines with by itself, or its plain colour.
        static UnityEngine.Color ColorOf(UnityEngine.Material material)
        {
            if (material.IsKeywordEnabled("_EMISSION")) return material.GetColor("_EmissionColor");
            foreach (var name in new[] { "_BaseColor", "_UnlitColor" })
                if (material.HasProperty(name)) return material.GetColor(name);
            return material.color;
        }

        /// Puts the nearest that a ray meets before what was met.
        internal static void Hit(UnityEngine.Vector3 from, UnityEngine.Vector3 way, int mask, ref float nearest, ref UnityEngine.Color color)
        {
            foreach (var shape in seen)
            {
                if ((mask >> shape.layer & 1) == 0) continue;
                UnityEngine.Vector3 o = shape.inverse.MultiplyPoint3x4(from), d = shape.inverse.MultiplyVector(way);
                if (!(shape.isSphere ? Sphere(o, d, out var t) : Cube(o, d, out t)) || t >= nearest) continue;
                nearest = t;
                color = shape.color;
            }
        }

        static bool Sphere(UnityEngine.Vector3 o, UnityEngine.Vector3 d, out float t)
        {
            float a = UnityEngine.Vector3.Dot(d, d), b = UnityEngine.Vector3.Dot(o, d), c = UnityEngine.Vector3.Dot(o, o) - .25f, e = b * b - a * c;
            t = 0;
            if (e < 0) return false;
            // Seen from outside only, as meshes are.
            t = (-b - (float)Math.Sqrt(e)) / a;
            return t >= 0;
        }

        static bool Cube(UnityEngine.Vector3 o, UnityEngine.Vector3 d, out float t)
        {
            float near = float.MinValue, far = float.MaxValue;
            for (int axis = 0; axis < 3; axis++)
            {
                float a = (-.5f - o[axis]) / d[axis], b = (.5f - o[axis]) / d[axis];
                near = Math.Max(near, Math.Min(a, b));
                far = Math.Min(far, Math.Max(a, b));
            }
            t = near;
            return near <= far && near >= 0;
        }
    }
}
