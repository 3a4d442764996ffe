// What the native library lends, freed exactly once whatever happens.
using System;
using System.Runtime.InteropServices;
using System.Threading;

namespace Lumivox.Native
{
    /// <summary>A pointer of the library's.</summary>
    internal abstract class NativeHandle : SafeHandle
    {
        static int ended;

        protected NativeHandle(IntPtr pointer) : base(IntPtr.Zero, true) => SetHandle(pointer);

        /// <summary>Counts those that ended: what a frame was given of one may be another's now.</summary>
        public static int Ended => Volatile.Read(ref ended);

        public override bool IsInvalid => handle == IntPtr.Zero;

        /// <summary>For calls while this is alive; null once it was disposed of.</summary>
        public IntPtr Pointer => IsClosed ? IntPtr.Zero : handle;

        protected override void Dispose(bool disposing)
        {
            Interlocked.Increment(ref ended);
            base.Dispose(disposing);
        }
    }

    /// <summary>A scan. The library counts who shows it: to free this handle takes it from nobody.</summary>
    internal sealed unsafe class VolumeHandle : NativeHandle
    {
        /// <summary>What it is.</summary>
        public readonly VolumeInfo Info;

        public VolumeHandle(IntPtr pointer) : base(pointer)
        {
            VolumeInfo info;
            Border.Checked(Library.lumivox_volume_info(pointer, &info));
            Info = info;
        }

        protected override bool ReleaseHandle()
        {
            Library.lumivox_volume_free(handle);
            return true;
        }
    }

    /// <summary>Opacity and colour of values.</summary>
    internal sealed class TransferFunctionHandle : NativeHandle
    {
        public TransferFunctionHandle(IntPtr pointer) : base(pointer) { }

        protected override bool ReleaseHandle()
        {
            Library.lumivox_transfer_function_free(handle);
            return true;
        }
    }

    /// <summary>A label map with the looks of its labels.</summary>
    internal sealed class LabellingHandle : NativeHandle
    {
        public LabellingHandle(IntPtr pointer) : base(pointer) { }

        protected override bool ReleaseHandle()
        {
            Library.lumivox_labelling_free(handle);
            return true;
        }
    }

    /// <summary>An environment's map.</summary>
    internal sealed class MapHandle : NativeHandle
    {
        public MapHandle(IntPtr pointer) : base(pointer) { }

        protected override bool ReleaseHandle()
        {
            Library.lumivox_map_free(handle);
            return true;
        }
    }

    /// <summary>A study whose headers were read.</summary>
    internal sealed class StudyHandle : NativeHandle
    {
        public StudyHandle(IntPtr pointer) : base(pointer) { }

        protected override bool ReleaseHandle()
        {
            Library.lumivox_study_free(handle);
            return true;
        }
    }

    /// <summary>A scene document that was opened.</summary>
    internal sealed class SceneHandle : NativeHandle
    {
        public SceneHandle(IntPtr pointer) : base(pointer) { }

        protected override bool ReleaseHandle()
        {
            Library.lumivox_scene_free(handle);
            return true;
        }
    }

    /// <summary>Work on another thread.</summary>
    internal sealed class JobHandle : NativeHandle
    {
        public JobHandle(IntPtr pointer) : base(pointer) { }

        protected override bool ReleaseHandle()
        {
            Library.lumivox_job_free(handle);
            return true;
        }
    }
}
