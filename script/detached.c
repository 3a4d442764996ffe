// Runs what its command line names as a game or a service would: without a console, and without standard streams. Returns what
// that returns.
#include <windows.h>

int main(void)
{
    WCHAR *line = GetCommandLineW();
    // Its own name comes first, which may be quoted.
    WCHAR end = *line == L'"' ? *line++ : L' ';
    while (*line && *line != end) line++;
    if (*line) line++;
    while (*line == L' ') line++;
    STARTUPINFOW start = { .cb = sizeof start, .dwFlags = STARTF_USESTDHANDLES };
    PROCESS_INFORMATION made;
    if (!CreateProcessW(NULL, line, NULL, NULL, FALSE, DETACHED_PROCESS, NULL, NULL, &start, &made)) return 120;
    DWORD code = 121;
    WaitForSingleObject(made.hProcess, INFINITE);
    GetExitCodeProcess(made.hProcess, &code);
    return (int)code;
}
