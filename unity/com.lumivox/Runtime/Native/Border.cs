// What every call over the border needs: whether the library is there and the right one, its errors, text both ways.
using System;
using System.Runtime.InteropServices;
using System.Text;
using UnityEngine;

namespace Lumivox.Native
{
    internal static unsafe class Border
    {
        static bool isChecked;
        static string fault;

        /// <summary>Why the library cannot be used, or null. It is asked once, and said once: whoever meets it again need not.</summary>
        public static string Fault
        {
            get
            {
                if (!isChecked)
                {
                    fault = Check();
                    isChecked = true;
                    if (fault != null) Debug.LogError(fault);
                    else NameCodecs();
                }
                return fault;
            }
        }

        /// <summary>The program that decodes what may crash decoders, where the editor has one; null: it is done here.</summary>
        internal static string CodecProgram
        {
            get => codecProgram;
            set
            {
                codecProgram = value;
                if (isChecked && fault == null) NameCodecs();
            }
        }

        static string codecProgram;

        static void NameCodecs()
        {
            fixed (byte* utf8 = Utf8(codecProgram)) Library.lumivox_set_codec_program(utf8);
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
                return $"Lumivox' native library, {FileName}, is not there, or another that it needs. The package's tarball and its branch for git have it for some systems. Take it from the tarball's Runtime/Plugins folder, or build it in a checkout with `cargo build --release -p lumivox-unity`; put it into the project's Assets/Plugins folder, and restart Unity. ({FirstLine(error.Message)})";
            }
            catch (EntryPointNotFoundException)
            {
                return Another("one that tells no version");
            }
            catch (BadImageFormatException)
            {
                return $"Lumivox' native library, {FileName}, is for another system or kind of processor than {Application.platform} runs on here. Replace it by the one for this machine, and restart Unity.";
            }
            if (version != Abi.Version) return Another($"version {version}");
            var sizes = Abi.Sizes;
            fixed (uint* first = sizes) return Library.lumivox_check_layout(first, (uint)sizes.Length) == 0 ? null : LastError();
        }

        static string Another(string which) =>
            $"Lumivox' native library, {FileName}, does not belong to this package: its border is {which}, and the package's is version {Abi.Version}. Replace the library with the one of the package, and restart Unity, which keeps libraries loaded.";

        /// <summary>What the library is called on this system.</summary>
        static string FileName
        {
            get
            {
                switch (Application.platform)
                {
                    case RuntimePlatform.WindowsEditor:
                    case RuntimePlatform.WindowsPlayer:
                        return $"{Library.Name}.dll";
                    case RuntimePlatform.OSXEditor:
                    case RuntimePlatform.OSXPlayer:
                        return $"lib{Library.Name}.dylib";
                    default:
                        return $"lib{Library.Name}.so";
                }
            }
        }

        /// <summary>Some runtimes list all places where they have looked.</summary>
        static string FirstLine(string text) => text.Split('\n')[0].Trim();
    }
}
