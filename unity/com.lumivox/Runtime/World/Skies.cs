// Which sky lights which world: worlds share a sky's baker, and it goes with the last of them.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace Lumivox
{
    internal sealed class Skies : IDisposable
    {
        readonly List<SkyBaker> bakers = new List<SkyBaker>();

        public int Count => bakers.Count;

        /// <summary>Whether a camera is one that skies are drawn with.</summary>
        public bool Owns(Camera camera)
        {
            foreach (var baker in bakers)
                if (baker.Owns(camera)) return true;
            return false;
        }

        /// <summary>Between frames, as <see cref="SkyBaker.Tick"/> says; nor does an object end while a camera is drawn.</summary>
        public void Tick()
        {
            for (var i = bakers.Count - 1; i >= 0; i--)
            {
                if (bakers[i].Users == 0)
                {
                    bakers[i].Dispose();
                    bakers.RemoveAt(i);
                }
                else bakers[i].Tick();
            }
        }

        public void Dispose()
        {
            foreach (var baker in bakers) baker.Dispose();
            bakers.Clear();
        }

        public SkyBaker Take(Material of)
        {
            foreach (var baker in bakers)
                if (baker.Shows(of)) return Taken(baker);
            return Made(new SkyBaker(of));
        }

        public SkyBaker Take(Cubemap of)
        {
            foreach (var baker in bakers)
                if (baker.Shows(of)) return Taken(baker);
            return Made(new SkyBaker(of));
        }

        public void Return(SkyBaker baker)
        {
            if (baker != null) baker.Users--;
        }

        SkyBaker Made(SkyBaker baker)
        {
            bakers.Add(baker);
            return Taken(baker);
        }

        static SkyBaker Taken(SkyBaker baker)
        {
            baker.Users++;
            return baker;
        }
    }

    /// <summary>A world's sky. The one before stays until the wanted one is baked, so that no world goes dark.</summary>
    internal sealed class WorldSky : IDisposable
    {
        readonly Skies skies;
        SkyBaker wanted, before;
        int used;

        public WorldSky(Skies skies) => this.skies = skies;

        /// <summary>Whether the map that was used last is not that of the sky as it is now.</summary>
        public bool IsAwaited => wanted != null && (wanted.IsBusy || wanted.Version != used);

        /// <summary>The sky of this frame is a skybox.</summary>
        public void Look(Material material)
        {
            if (wanted == null || !wanted.Shows(material)) Want(skies.Take(material));
            wanted.Look();
        }

        /// <summary>It is a cube of the host's own.</summary>
        public void Look(Cubemap cubemap)
        {
            if (wanted == null || !wanted.Shows(cubemap)) Want(skies.Take(cubemap));
        }

        /// <summary>There is no sky to bake.</summary>
        public void LookAway()
        {
            skies.Return(wanted);
            skies.Return(before);
            wanted = before = null;
        }

        /// <summary>The map for a frame; zero where there is none yet.</summary>
        public IntPtr Use()
        {
            if (wanted == null) return IntPtr.Zero;
            used = wanted.Version;
            if (used == 0) return before != null ? before.Map : IntPtr.Zero;
            skies.Return(before);
            before = null;
            return wanted.Map;
        }

        public void Dispose() => LookAway();

        void Want(SkyBaker next)
        {
            // Of skies that follow each other quickly, one that has a map stays.
            if (wanted == null || wanted.Version == 0) skies.Return(wanted);
            else
            {
                skies.Return(before);
                before = wanted;
            }
            wanted = next;
        }
    }
}
