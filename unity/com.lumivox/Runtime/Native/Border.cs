// What every call over the border needs: whether the library is there and the right one, its errors, text both ways.
using System;
using System.Runtime.InteropServices;
using System.Text;
using UnityEngine;

namespace Lumivox.Native
{
    internal static unsafe class Border
    {
        /// <summary>Raised with the library's own.</summary>
        public const uint AbiVersion = 3;

        static bool isChecked;
        static string fault;

        /// <summary>Why the library cannot be used, or null. It is asked once.</summary>
        public static string Fault
        {
            get
            {
                if (!isChecked)
                {
                    fault = Check();
                    isChecked = true;
                }
                return fault;
            }
        }

        /// <summary>Throws where the library cannot be used.</summary>
        public static void Need()
        {
            if (Fault != null) throw new LumivoxException(Fault);
        }

        /// <summary>What the library says of the call that failed.</summary>
        public static LumivoxException Error() => new LumivoxException(LastError());

        /// <summary>What the library says of this thread's last call; empty where it worked.</summary>
        public static string LastError() => Text(Library.lumivox_last_error());

        /// <summary>Whether this thread's last call left an error; without making text of it.</summary>
        public static bool HasError()
        {
            var text = (byte*)Library.lumivox_last_error();
            return text != null && *text != 0;
        }

        /// <summary>The pointer, or what the library says of why there is none.</summary>
        public static IntPtr Checked(IntPtr pointer)
        {
            if (pointer == IntPtr.Zero) throw Error();
            return pointer;
        }

        /// <summary>Throws what the library says where a call gave a negative number.</summary>
        public static void Checked(int result)
        {
            if (result < 0) throw Error();
        }

        /// <summary>The library's own text, which it keeps.</summary>
        public static string Text(IntPtr utf8) => utf8 == IntPtr.Zero ? "" : Marshal.PtrToStringUTF8(utf8);

        /// <summary>Text that is handed over, and freed here.</summary>
        public static string TakeText(IntPtr text)
        {
            if (text == IntPtr.Zero) return null;
            try
            {
                return Text(Library.lumivox_text(text));
            }
            finally
            {
                Library.lumivox_text_free(text);
            }
        }

        /// <summary>UTF-8, ended by 0, for `fixed`; null stays null.</summary>
        public static byte[] Utf8(string text)
        {
            if (text == null) return null;
            var bytes = new byte[Encoding.UTF8.GetByteCount(text) + 1];
            Encoding.UTF8.GetBytes(text, 0, text.Length, bytes, 0);
            return bytes;
        }

        static string Check()
        {
            uint version;
            try
            {
                version = Library.lumivox_abi_version();
            }
            catch (DllNotFoundException error)
            {
                return $"Lumivox' native library '{Library.Name}' is not there for {Application.platform}: add the one for it to the package's Runtime/Plugins folder, or build it (see the package's documentation). {error.Message}";
            }
            catch (EntryPointNotFoundException)
            {
                return Another("one that tells no version");
            }
            catch (BadImageFormatException)
            {
                return $"Lumivox' native library '{Library.Name}' is for another kind of processor than {Application.platform} runs on here.";
            }
            if (version != AbiVersion) return Another($"version {version}");
            var sizes = stackalloc uint[]
            {
                (uint)sizeof(VolumeInfo), (uint)sizeof(OpacityKnot), (uint)sizeof(ColorStop), (uint)sizeof(Medium),
                (uint)sizeof(Instance), (uint)sizeof(LightSource), (uint)sizeof(Surroundings), (uint)sizeof(DeviceLimits),
                (uint)sizeof(ViewFrame), (uint)sizeof(ViewStatus), (uint)sizeof(Slice), (uint)sizeof(Step),
                (uint)sizeof(Progress), (uint)sizeof(ImportOptions), (uint)sizeof(Picture),
            };
            return Library.lumivox_check_layout(sizes, 15) == 0 ? null : LastError();
        }

        static string Another(string which) =>
            $"Lumivox' native library does not belong to this package: its border is {which}, and the package's is version {AbiVersion}. Replace the library with the one of the package, and restart Unity, which keeps libraries loaded.";
    }
}
