// What cameras see, gathered once a frame into arrays that are kept: volumes, lights and the light around them.
using System;
using System.Collections.Generic;
using Lumivox.Native;
using UnityEngine;

namespace Lumivox
{
    /// <summary>What tells one world from another: cameras that share it share its copy on the GPU.</summary>
    internal struct WorldKey : IEquatable<WorldKey>
    {
        /// <summary>The volumes' layers that are seen.</summary>
        public uint Layers;
        /// <summary>Whether a studio lights it instead of its environment.</summary>
        public bool IsStudio;
        /// <summary>Of an editor: which scenes are seen, and whether what is hidden in its scene view is not.</summary>
        public ulong Scenes;
        public bool IsSceneView;

        public bool Equals(WorldKey other) =>
            Layers == other.Layers && IsStudio == other.IsStudio && Scenes == other.Scenes && IsSceneView == other.IsSceneView;
    }

    internal sealed unsafe class WorldGatherer : IDisposable
    {
        /// <summary>A world of the library's.</summary>
        internal sealed class World
        {
            public WorldKey Key;
            public ulong Number;
            public long Frame = -1;
            public int Volumes;
            public bool IsRecorded;
            public WorldSky Sky;
        }

        readonly List<World> worlds = new List<World>();
        readonly EnvironmentReader environment = new EnvironmentReader();
        readonly Skies skies = new Skies();
        Instance[] instances = new Instance[16];
        LumivoxVolume[] owners = new LumivoxVolume[16];
        Instance[] seen = new Instance[16];
        LightSource[] lights = new LightSource[16];
        Light[] lightOwners = new Light[16];
        LightSource[] shining = new LightSource[16];
        int instanceCount, lightCount;
        uint layers;
        long gathered = -1;
        ulong lastNumber;

        public Skies Skies => skies;

        /// <summary>The layers of all volumes.</summary>
        public uint Layers => layers;

        /// <summary>The world that a camera sees in a frame; null where it sees no volumes.</summary>
        public World Gather(IntPtr stage, Camera camera, bool isStudio, long frame)
        {
            if (gathered != frame)
            {
                gathered = frame;
                GatherVolumes();
                GatherLights();
            }
            var key = new WorldKey
            {
                Layers = layers & unchecked((uint)camera.cullingMask),
                IsStudio = isStudio,
                Scenes = SceneVisibility.ScenesOf(camera),
                IsSceneView = camera.cameraType == CameraType.SceneView,
            };
            if (key.Layers == 0) return null;
            var world = Find(key);
            if (world.Frame != frame)
            {
                world.Frame = frame;
                world.IsRecorded = false;
                Tell(stage, world);
            }
            return world.Volumes > 0 ? world : null;
        }

        /// <summary>Forgets worlds that no frame since `oldest` has shown, and writes the numbers of the rest.</summary>
        public uint Keep(long oldest, ref ulong[] numbers)
        {
            for (var i = worlds.Count - 1; i >= 0; i--)
            {
                if (worlds[i].Frame >= oldest) continue;
                worlds[i].Sky.Dispose();
                worlds.RemoveAt(i);
            }
            if (numbers.Length < worlds.Count) numbers = new ulong[worlds.Count * 2];
            for (var i = 0; i < worlds.Count; i++) numbers[i] = worlds[i].Number;
            return (uint)worlds.Count;
        }

        /// <summary>Whether a world is not lit by its sky as that is now.</summary>
        public bool AwaitsSky(ulong number)
        {
            foreach (var world in worlds)
                if (world.Number == number) return world.Sky.IsAwaited;
            return false;
        }

        /// <summary>Whether any world of the last frames is not.</summary>
        public bool AwaitsSkies
        {
            get
            {
                foreach (var world in worlds)
                    if (gathered - world.Frame <= 1 && world.Sky.IsAwaited) return true;
                return false;
            }
        }

        public void Tick() => skies.Tick();

        public void Dispose() => skies.Dispose();

        World Find(in WorldKey key)
        {
            foreach (var world in worlds)
                if (world.Key.Equals(key)) return world;
            var made = new World { Key = key, Number = ++lastNumber, Sky = new WorldSky(skies) };
            worlds.Add(made);
            return made;
        }

        void GatherVolumes()
        {
            var all = LumivoxVolume.All;
            if (instances.Length < all.Count)
            {
                Array.Resize(ref instances, all.Count * 2);
                Array.Resize(ref seen, all.Count * 2);
                Array.Resize(ref owners, all.Count * 2);
            }
            instanceCount = 0;
            layers = 0;
            foreach (var volume in all)
            {
                if (!volume.TryGetInstance(ref instances[instanceCount])) continue;
                layers |= instances[instanceCount].layers;
                owners[instanceCount++] = volume;
            }
        }

        void GatherLights()
        {
            LightFinder.Tick();
            var all = LightFinder.Known;
            if (lights.Length < all.Count)
            {
                Array.Resize(ref lights, all.Count * 2);
                Array.Resize(ref lightOwners, all.Count * 2);
                Array.Resize(ref shining, all.Count * 2);
            }
            lightCount = 0;
            foreach (var light in all)
            {
                if (!LightReader.TryRead(light, ref lights[lightCount])) continue;
                lightOwners[lightCount++] = light;
            }
        }

        void Tell(IntPtr stage, World world)
        {
            var count = 0;
            for (var i = 0; i < instanceCount; i++)
            {
                if ((instances[i].layers & world.Key.Layers) == 0) continue;
                if (!SceneVisibility.IsSeen(owners[i].gameObject, world.Key)) continue;
                seen[count++] = instances[i];
            }
            var lit = 0;
            for (var i = 0; i < lightCount; i++)
                if (SceneVisibility.IsIn(lightOwners[i].gameObject, world.Key)) shining[lit++] = lights[i];
            var surroundings = EnvironmentReader.Studio;
            if (!world.Key.IsStudio) environment.Read(world.Sky, lit > 0, ref surroundings);
            world.Volumes = count;
            fixed (Instance* volume = seen)
            fixed (LightSource* light = shining)
                Border.Checked(Library.lumivox_stage_set_world(stage, world.Number, volume, (uint)count, light, (uint)lit, &surroundings));
        }
    }
}
