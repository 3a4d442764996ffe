// Loads the libraries for Godot and Unity as their engines would in Windows: libraries.exe GODOT.dll UNITY.dll. Godot's entry is
// called by a Godot that is too old: the library is to say so, and to return. Prints what the libraries say; returns 0 where all
// of it is as it should be.
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <wchar.h>
#include <windows.h>

// Of Godot's gdextension_interface.h: what an extension asks for first.
struct version { uint32_t major, minor, patch; const char *string; };
struct version2 { uint32_t major, minor, patch, hex; const char *status, *build, *hash; uint64_t timestamp; const char *string; };

static void get_godot_version(struct version *version)
{
    *version = (struct version){ 4, 4, 0, "Godot 4.4, which is too old" };
}

static void get_godot_version2(struct version2 *version)
{
    *version = (struct version2){ 4, 4, 0, 0x40400, "stable", "test", "", 0, "Godot 4.4, which is too old" };
}

static int asked;

static void *get_proc_address(const char *name)
{
    asked++;
    if (!strcmp(name, "get_godot_version")) return (void *)get_godot_version;
    if (!strcmp(name, "get_godot_version2")) return (void *)get_godot_version2;
    return NULL;
}

// The function `name` of the library `path`, or NULL, which has been told.
static FARPROC function(const wchar_t *path, const char *name)
{
    HMODULE library = LoadLibraryW(path);
    FARPROC found = library ? GetProcAddress(library, name) : NULL;
    if (!library) fwprintf(stderr, L"error: %ls cannot be loaded: %lu\n", path, GetLastError());
    else if (!found) fwprintf(stderr, L"error: %ls has no %hs\n", path, name);
    return found;
}

int wmain(int count, wchar_t **words)
{
    if (count != 3) return fwprintf(stderr, L"usage: libraries GODOT.dll UNITY.dll\n"), 2;
    uint8_t (*entry)(void *(*)(const char *), void *, void *) = (void *)function(words[1], "gdext_rust_init");
    const char *(*version)(void) = (void *)function(words[2], "lumivox_version");
    uint32_t (*abi)(void) = (void *)function(words[2], "lumivox_abi_version");
    if (!entry || !version || !abi) return 1;
    printf("unity %s, border %u\n", version(), abi());
    fflush(stdout);
    uint64_t initialization[4] = { 0 };
    if (entry(get_proc_address, NULL, initialization)) return fwprintf(stderr, L"error: Godot 4.4 is taken for new enough\n"), 1;
    if (!asked) return fwprintf(stderr, L"error: Godot is not asked for its version\n"), 1;
    printf("godot refuses 4.4\n");
    return 0;
}
