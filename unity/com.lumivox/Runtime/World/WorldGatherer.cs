// What cameras see, gathered into arrays that are kept: volumes, lights and the light around them. Each camera of a frame
// looks anew, for scripts run between two of them; where nothing has changed, nothing is told again.
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
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
            /// Which gathering it was told, under which sky, for whom.
            public long Gathering;
            public ulong SkyNumber;
            public ulong CameraId;
        }

        readonly List<World> worlds = new List<World>();
        readonly EnvironmentReader environment = new EnvironmentReader();
        readonly Skies skies = new Skies();
        /// What was gathered, and what was before it.
        Instance[] instances = new Instance[16], lastInstances = new Instance[16];
        LumivoxVolume[] owners = new LumivoxVolume[16], lastOwners = new LumivoxVolume[16];
        LightSource[] lights = new LightSource[16], lastLights = new LightSource[16];
        Light[] lightOwners = new Light[16], lastLightOwners = new Light[16];
        Instance[] seen = new Instance[16];
        /// Those of each instance lie one behind the other.
        ClipShape[] clips = new ClipShape[16], lastClips = new ClipShape[16];
        LightSource[] shining = new LightSource[16];
        int instanceCount, lightCount, clipCount;
        uint layers;
        long gathered = -1, gathering;
        ulong gatheredFor;
        int handlesEnded;
        ulong lastNumber;

        public Skies Skies => skies;

        /// <summary>How many worlds are kept.</summary>
        public int Count => worlds.Count;

        /// <summary>The layers of all volumes.</summary>
        public uint Layers => layers;

        /// <summary>The world that a camera sees in a frame; null where it sees no volumes.</summary>
        public World Gather(IntPtr stage, Camera camera, bool isStudio, long frame)
        {
            var id = Identity.Of(camera);
            if (gathered != frame || gatheredFor != id)
            {
                if (Changed() || gathered != frame) gathering++;
                (gathered, gatheredFor) = (frame, id);
            }
            var key = new WorldKey
            {
                Layers = layers & unchecked((uint)camera.cullingMask),
                IsStudio = isStudio,
                Scenes = SceneVisibility.ScenesOf(camera),
                IsSceneView = camera.cameraType == CameraType.SceneView,
            };
            if (key.Layers == 0) return null;
            var world = Find(key, isStudio ? 0 : EnvironmentReader.NumberOfSky(key), id, frame);
            if (world.Frame != frame || world.Gathering != gathering)
            {
                world.Frame = frame;
                world.Gathering = gathering;
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

        /// <summary>Whoever gathers next looks anew, within a frame, too.</summary>
        public void Forget() => gathered = -1;

        public void Tick() => skies.Tick();

        public void Dispose() => skies.Dispose();

        /// <summary>
        /// The world of a key under a sky. Cameras under one sky share it; of a sky that changes, the camera that it was told
        /// for keeps it.
        /// </summary>
        World Find(in WorldKey key, ulong sky, ulong cameraId, long frame)
        {
            World found = null;
            foreach (var world in worlds)
            {
                if (!world.Key.Equals(key)) continue;
                if (world.SkyNumber == sky)
                {
                    found = world;
                    break;
                }
                if (world.CameraId == cameraId && world.Frame != frame) found = world;
            }
            if (found == null)
            {
                found = new World { Key = key, Number = ++lastNumber, Sky = new WorldSky(skies) };
                worlds.Add(found);
            }
            // Whoever comes first in a frame tells it.
            if (found.Frame != frame) (found.SkyNumber, found.CameraId) = (sky, cameraId);
            return found;
        }

        /// <summary>Gathers anew. Returns whether that is anything else than before.</summary>
        bool Changed()
        {
            var (volumesBefore, lightsBefore, clipsBefore) = (instanceCount, lightCount, clipCount);
            (instances, lastInstances) = (lastInstances, instances);
            (owners, lastOwners) = (lastOwners, owners);
            (clips, lastClips) = (lastClips, clips);
            (lights, lastLights) = (lastLights, lights);
            (lightOwners, lastLightOwners) = (lastLightOwners, lightOwners);
            var endedBefore = handlesEnded;
            handlesEnded = NativeHandle.Ended;
            GatherVolumes();
            GatherLights();
            if (handlesEnded != endedBefore || instanceCount != volumesBefore || lightCount != lightsBefore || clipCount != clipsBefore) return true;
            for (var i = 0; i < instanceCount; i++)
                if (!ReferenceEquals(owners[i], lastOwners[i])) return true;
            for (var i = 0; i < lightCount; i++)
                if (!ReferenceEquals(lightOwners[i], lastLightOwners[i])) return true;
            return !Bytes(instances, instanceCount).SequenceEqual(Bytes(lastInstances, instanceCount)) || !Bytes(clips, clipCount).SequenceEqual(Bytes(lastClips, clipCount)) || !Bytes(lights, lightCount).SequenceEqual(Bytes(lastLights, lightCount));
        }

        static ReadOnlySpan<byte> Bytes<T>(T[] of, int count) where T : unmanaged => MemoryMarshal.AsBytes(new ReadOnlySpan<T>(of, 0, count));

        void GatherVolumes()
        {
            var all = LumivoxVolume.All;
            if (instances.Length < all.Count)
            {
                Array.Resize(ref instances, all.Count * 2);
                Array.Resize(ref owners, all.Count * 2);
            }
            if (seen.Length < instances.Length) Array.Resize(ref seen, instances.Length);
            instanceCount = clipCount = 0;
            layers = 0;
            foreach (var volume in all)
            {
                if (!volume.TryGetInstance(ref instances[instanceCount])) continue;
                instances[instanceCount].firstClip = (uint)clipCount;
                LumivoxClip.Put(volume.Clips, ref clips, ref clipCount);
                instances[instanceCount].clipCount = (uint)clipCount - instances[instanceCount].firstClip;
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
            }
            if (shining.Length < lights.Length) Array.Resize(ref shining, lights.Length);
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
            if (!world.Key.IsStudio) environment.Read(world.Key, world.Sky, lit > 0, ref surroundings);
            world.Volumes = count;
            fixed (Instance* volume = seen)
            fixed (ClipShape* clip = clips)
            fixed (LightSource* light = shining)
                Border.Checked(Library.lumivox_stage_set_world(stage, world.Number, volume, (uint)count, clip, (uint)clipCount, light, (uint)lit, &surroundings));
        }
    }
}
