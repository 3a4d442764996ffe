// Random bytes as Windows 8 and later give them, for versions of Wine that lack this library: Rust's own asks it for the keys
// of its hash maps. What Wine has had for long gives the bytes.
#include <windows.h>
#include <ntsecapi.h>

__declspec(dllexport) BOOL WINAPI ProcessPrng(BYTE *bytes, SIZE_T count)
{
    const SIZE_T most = 1 << 30;
    for (SIZE_T begun = 0; begun < count; begun += most) {
        SIZE_T left = count - begun;
        if (!RtlGenRandom(bytes + begun, (ULONG)(left < most ? left : most)))
            return FALSE;
    }
    return TRUE;
}
