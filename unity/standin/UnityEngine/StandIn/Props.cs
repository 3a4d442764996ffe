// What stands in a scene in place of meshes: planes, spheres and primitives, traced on the CPU into a camera's colour and depth.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace StandIn
{
    /// What was drawn before into a layer of a target that is drawn over, its rows as they lie.
    sealed class Under
    {
        internal Picture color, depth;

        /// That of all layers.
        internal static Under[] Of(RenderTexture color, RenderTexture depth, bool clearsDepth)
        {
            var layers = new Under[color.volumeDepth];
            for (int layer = 0; layer < layers.Length; layer++)
                layers[layer] = new Under { color = Pictures.Read(color, layer), depth = clearsDepth ? new Picture(color.width, color.height) : Pictures.ReadDepth(depth, layer) };
            return layers;
        }
    }

    public static class Props
    {
        struct Shape { internal bool isSphere; internal Vector3 at, normal; internal float radius; internal Color color; internal int layer; }
        static readonly List<Shape> all = new List<Shape>(), none = new List<Shape>();
        /// Whether what is drawn is a preview scene, in which none of them stands.
        static bool isApart;
        /// The sky's colour by direction, where a camera clears to it; black without.
        public static Func<Vector3, Color> sky;
        /// Those of materials that do not show it, whether scenes or cameras have them.
        public static readonly Dictionary<Material, Func<Vector3, Color>> skies = new Dictionary<Material, Func<Vector3, Color>>();

        public static void Plane(Vector3 point, Vector3 normal, Color color, int layer = 0) => all.Add(new Shape { at = point, normal = normal.normalized, color = color, layer = layer });
        public static void Sphere(Vector3 center, float radius, Color color, int layer = 0) => all.Add(new Shape { isSphere = true, at = center, radius = radius, color = color, layer = layer });
        /// Whether shapes are lit by the sun, for pictures that people look at; otherwise they have their plain colour.
        public static bool isShaded;
        public static void Clear() { all.Clear(); sky = null; skies.Clear(); isShaded = false; }

        /// A colour in the light of the first sun and of an even sky, by how the surface lies at a point of a ray.
        static Color Shaded(Color color, Vector3 from, Vector3 way, float t, int mask)
        {
            // Not far beyond it, or single precision would not tell neighbours apart.
            (way, t) = (way * (2 * t), .5f);
            var towards = Vector3.zero;
            foreach (var light in UnityEngine.Object.FindObjectsByType<Light>(FindObjectsSortMode.None))
                if (light.type == LightType.Directional) towards = -light.transform.forward;
            var side = Vector3.Cross(way, Math.Abs(way.y) < .9f * way.magnitude ? Vector3.up : Vector3.right).normalized * (way.magnitude * 1e-3f);
            var other = Vector3.Cross(side, way).normalized * (way.magnitude * 1e-3f);
            var at = from + way * t;
            if (!Hit(from, way + side, mask, out var a, out _) || !Hit(from, way + other, mask, out var b, out _)) return color * .5f;
            // Short vectors have no direction: Unity's `normalized` makes zero of them.
            var normal = Vector3.Cross((from + (way + side) * a - at) * 1e3f, (from + (way + other) * b - at) * 1e3f).normalized;
            if (Vector3.Dot(normal, way) > 0) normal = -normal;
            return color * (.25f + .1f * normal.y + .55f * Math.Max(0, Vector3.Dot(normal, towards)));
        }

        /// The nearest shape on a ray between two points: how far along it, of 1, and its colour.
        static bool Hit(Vector3 from, Vector3 way, int mask, out float nearest, out Color color)
        {
            nearest = float.MaxValue;
            color = default;
            foreach (var shape in isApart ? none : all)
            {
                if ((mask >> shape.layer & 1) == 0) continue;
                float t;
                if (shape.isSphere)
                {
                    Vector3 o = from - shape.at;
                    float a = Vector3.Dot(way, way), b = Vector3.Dot(o, way), c = Vector3.Dot(o, o) - shape.radius * shape.radius, d = b * b - a * c;
                    if (d < 0) continue;
                    t = (-b - Mathf.Sqrt(d)) / a;
                    if (t < 0) t = (-b + Mathf.Sqrt(d)) / a;
                }
                else
                {
                    float along = Vector3.Dot(way, shape.normal);
                    if (along == 0) continue;
                    t = Vector3.Dot(shape.at - from, shape.normal) / along;
                }
                if (t < 0 || t >= nearest) continue;
                nearest = t;
                color = shape.color;
            }
            Primitives.Hit(from, way, mask, ref nearest, ref color);
            return nearest <= 1;
        }

        static void Gather(Camera camera)
        {
            isApart = camera.scene.IsValid() && PreviewScenes.IsOpen(camera.scene);
            Primitives.Gather(PreviewScenes.SeenBy(camera));
        }

        /// What a pipeline clears with, in linear light; null: the camera's own.
        internal static Color? cleared;

        static Color Background(Camera camera, Vector3 way)
        {
            if (cleared is Color color) return color;
            if (camera.clearFlags != CameraClearFlags.Skybox) return camera.backgroundColor.linear;
            var material = camera.TryGetComponent<Skybox>(out var own) && own.material != null ? own.material : RenderSettings.skybox;
            var shown = material != null && skies.TryGetValue(material, out var special) ? special : sky;
            return shown != null ? shown(way) : Color.black;
        }

        /// Draws what a camera sees, background included, into a target; in stereo into both layers.
        internal static void Draw(Camera camera, Camera.StereoscopicEye? eye, RenderTexture colorTarget, RenderTexture depthTarget, bool isFlipped, Under[] under = null)
        {
            var any = colorTarget ?? depthTarget;
            for (int layer = 0; layer < any.volumeDepth; layer++)
            {
                Matrix4x4 view = camera.worldToCameraMatrix, projection = camera.projectionMatrix;
                if (any.volumeDepth > 1 || eye != null)
                {
                    var which = eye ?? (Camera.StereoscopicEye)layer;
                    view = camera.GetStereoViewMatrix(which);
                    projection = camera.GetStereoProjectionMatrix(which);
                }
                Draw(camera, view, projection, layer, colorTarget, depthTarget, isFlipped, under?[layer]);
            }
        }

        /// As above, for pipelines that know their matrices.
        public static void Draw(Camera camera, Matrix4x4 view, Matrix4x4 projection, int layer, RenderTexture colorTarget, RenderTexture depthTarget, bool isFlipped) =>
            Draw(camera, view, projection, layer, colorTarget, depthTarget, isFlipped, null);

        static unsafe void Draw(Camera camera, Matrix4x4 view, Matrix4x4 projection, int layer, RenderTexture colorTarget, RenderTexture depthTarget, bool isFlipped, Under under)
        {
            var any = colorTarget != null ? colorTarget : depthTarget;
            int width = any.width, height = any.height;
            var pixels = new float[width * height * 5];
            var inverse = (projection * view).inverse;
            var clip = GL.GetGPUProjectionMatrix(projection, isFlipped) * view;
            Gather(camera);
            for (int y = 0; y < height; y++)
                for (int x = 0; x < width; x++)
                {
                    // Row 0 is the highest of a picture, or the lowest where it is upside down.
                    float u = (x + .5f) / width * 2 - 1, v = 1 - (y + .5f) / height * 2;
                    if (isFlipped) v = -v;
                    Vector3 near = inverse.MultiplyPoint(new Vector3(u, v, -1)), far = inverse.MultiplyPoint(new Vector3(u, v, 1));
                    var way = far - near;
                    var color = under != null ? under.color.At(x, y) : Background(camera, way.normalized);
                    var depth = under != null ? under.depth.At(x, y).r : 0;
                    if (Hit(near, way, camera.cullingMask, out var t, out var hit))
                    {
                        Vector3 p = near + way * t;
                        var q = clip * new Vector4(p.x, p.y, p.z, 1);
                        if (q.z / q.w >= depth)
                        {
                            depth = q.z / q.w;
                            color = isShaded ? Shaded(hit, near, way, t, camera.cullingMask) : hit;
                        }
                    }
                    int at = (y * width + x) * 5;
                    pixels[at] = color.r; pixels[at + 1] = color.g; pixels[at + 2] = color.b; pixels[at + 3] = color.a; pixels[at + 4] = depth;
                }
            var target = new Native.Target { color = colorTarget == null || !colorTarget.hasColor ? 0 : colorTarget.handle, colorLayer = (uint)layer, depth = depthTarget == null ? 0 : depthTarget.depthHandle, depthLayer = (uint)layer };
            fixed (float* data = pixels) Native.sg_fill(target, (uint)width, data, (ulong)pixels.Length * 4);
            Gpu.Submit("the scene's shapes");
        }

        internal static void DrawCube(Camera camera, Cubemap cube, int faces)
        {
            Gather(camera);
            for (int face = 0; face < 6; face++)
            {
                if ((faces >> face & 1) == 0) continue;
                for (int y = 0; y < cube.height; y++)
                    for (int x = 0; x < cube.width; x++)
                        cube.SetPixel((CubemapFace)face, x, y, InCube(camera, face, x, y, cube.width));
            }
            cube.Apply();
        }

        /// A face as kernels sample it: cubes begin at the top, whichever way other textures lie.
        internal static unsafe void DrawFace(Camera camera, RenderTexture cube, int face)
        {
            int side = cube.width;
            var pixels = new float[side * side * 5];
            Gather(camera);
            for (int y = 0; y < side; y++)
                for (int x = 0; x < side; x++)
                {
                    var color = InCube(camera, face, x, y, side);
                    int at = (y * side + x) * 5;
                    pixels[at] = color.r; pixels[at + 1] = color.g; pixels[at + 2] = color.b; pixels[at + 3] = color.a;
                }
            fixed (float* data = pixels) Native.sg_fill(new Native.Target { color = cube.handle, colorLayer = (uint)face }, (uint)side, data, (ulong)pixels.Length * 4);
            Gpu.Submit("a face of a cube");
        }

        /// What is seen through a texel of a cube around a camera. Its faces are the world's, however the camera is turned.
        static Color InCube(Camera camera, int face, int x, int y, int side)
        {
            float u = (x + .5f) / side * 2 - 1, v = (y + .5f) / side * 2 - 1;
            var way = face switch { 0 => new Vector3(1, -v, -u), 1 => new Vector3(-1, -v, u), 2 => new Vector3(u, 1, v), 3 => new Vector3(u, -1, -v), 4 => new Vector3(u, -v, 1), _ => new Vector3(-u, -v, -1) };
            if (Hit(camera.transform.position, way.normalized * camera.farClipPlane, camera.cullingMask, out _, out var color)) return color;
            return Background(camera, way.normalized);
        }
    }
}
