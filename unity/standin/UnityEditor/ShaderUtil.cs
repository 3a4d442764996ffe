// What compilers said of shaders.
using System.Linq;
using UnityEditor.Rendering;
using UnityEngine;

namespace UnityEditor.Rendering
{
    public enum ShaderCompilerMessageSeverity { Error, Warning }
}

namespace UnityEditor
{
    public struct ShaderMessage
    {
        public string message { get; }
        public string file { get; }
        public int line { get; }
        public ShaderCompilerMessageSeverity severity { get; }
        public ShaderMessage(string msg, ShaderCompilerMessageSeverity sev = ShaderCompilerMessageSeverity.Error) { message = msg; file = ""; line = 0; severity = sev; }
    }

    public sealed class ShaderUtil
    {
        /// The stand-in compiles at once; whoever asks for pictures of it should not rely on that.
        public static bool allowAsyncCompilation { get; set; } = true;
        public static ShaderMessage[] GetShaderMessages(Shader s) => s.error == null ? new ShaderMessage[0] : new[] { new ShaderMessage(s.error) };
        public static ShaderMessage[] GetComputeShaderMessages(ComputeShader s) =>
            s.kernels.Where(kernel => kernel.error != null).Select(kernel => new ShaderMessage(kernel.error)).ToArray();
    }
}
