#if (UNITY_ANDROID || UNITY_WEBGL) && !UNITY_EDITOR
using Lumivox.Native;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine.Networking;

namespace Lumivox
{
    public sealed unsafe partial class LumivoxVolumeAsset
    {
        /// <summary>Reads a file of the application's package, which is no file of the system's.</summary>
        void OpenPacked(string address)
        {
            currentState = LumivoxVolumeState.Loading;
            currentError = "";
            changed?.Invoke();
            var request = UnityWebRequest.Get(address);
            request.SendWebRequest().completed += _ =>
            {
                using (request)
                {
                    if (currentState != LumivoxVolumeState.Loading) return;
                    if (request.result != UnityWebRequest.Result.Success)
                    {
                        Fail($"The scan's file is not there: {address} ({request.error}). Build the player again.");
                        return;
                    }
                    // The library copies them before it returns.
                    var bytes = request.downloadHandler.nativeData;
                    Follow(Library.lumivox_volume_open_bytes(NativeArrayUnsafeUtility.GetUnsafeReadOnlyPtr(bytes), (ulong)bytes.Length));
                }
            };
        }
    }
}
#endif
