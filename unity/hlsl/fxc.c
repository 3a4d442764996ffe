/* Microsoft's FXC as a program for Windows: `fxc.exe LIST`, with d3dcompiler_47.dll beside it.
 *
 * LIST has a line `NAME FILE ENTRY TARGET` for each program to compile. Says `ok NAME ENTRY MILLISECONDS BYTES` of each,
 * the time being that of a processor, or `failed NAME ENTRY` and why. As many threads as there are cores take them in turn.
 */

#include <windows.h>
#include <d3dcompiler.h>
#include <stdio.h>
#include <stdlib.h>

/* As Unity calls it: D3DCOMPILE_OPTIMIZATION_LEVEL3, and backwards compatibility. */
#define FLAGS 0x9000

#define MOST 4096

struct Job {
    char name[256], file[512], entry[128], target[32];
};

static struct Job jobs[MOST];
static LONG job_count, next_job, failures;
static pD3DCompile compile;
static CRITICAL_SECTION speaking;

static char *contents(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    if (!file) return NULL;
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    text = malloc(*size + 1);
    if (text && fread(text, 1, *size, file) != *size) {
        free(text);
        text = NULL;
    }
    fclose(file);
    return text;
}

static ULONGLONG processor_milliseconds(void) {
    FILETIME made, ended, kernel, user;
    GetThreadTimes(GetCurrentThread(), &made, &ended, &kernel, &user);
    return ((((ULONGLONG)kernel.dwHighDateTime + user.dwHighDateTime) << 32) + kernel.dwLowDateTime + user.dwLowDateTime) / 10000;
}

static void run(const struct Job *job) {
    size_t size = 0;
    char *text = contents(job->file, &size);
    ID3DBlob *binary = NULL, *errors = NULL;
    ULONGLONG start = processor_milliseconds();
    HRESULT status = text ? compile(text, size, job->name, NULL, NULL, job->entry, job->target, FLAGS, 0, &binary, &errors) : E_FAIL;
    unsigned milliseconds = (unsigned)(processor_milliseconds() - start);
    EnterCriticalSection(&speaking);
    if (status == S_OK) {
        printf("ok %s %s %u %u\n", job->name, job->entry, milliseconds, (unsigned)binary->lpVtbl->GetBufferSize(binary));
    } else {
        printf("failed %s %s\n", job->name, job->entry);
        if (!text) printf("%s cannot be read\n", job->file);
        else if (errors) printf("%s\n", (const char *)errors->lpVtbl->GetBufferPointer(errors));
        failures++;
    }
    fflush(stdout);
    LeaveCriticalSection(&speaking);
    if (binary) binary->lpVtbl->Release(binary);
    if (errors) errors->lpVtbl->Release(errors);
    free(text);
}

static DWORD WINAPI work(LPVOID unused) {
    LONG i;
    (void)unused;
    while ((i = InterlockedIncrement(&next_job) - 1) < job_count) run(&jobs[i]);
    return 0;
}

int main(int count, char **arguments) {
    HMODULE library = LoadLibraryA("d3dcompiler_47.dll");
    FILE *list = count == 2 ? fopen(arguments[1], "r") : NULL;
    HANDLE threads[MAXIMUM_WAIT_OBJECTS];
    SYSTEM_INFO system;
    DWORD i, thread_count;
    if (!library || !list) {
        fprintf(stderr, library ? "usage: fxc.exe LIST\n" : "d3dcompiler_47.dll cannot be loaded\n");
        return 2;
    }
    compile = (pD3DCompile)(void *)GetProcAddress(library, "D3DCompile");
    while (job_count < MOST
        && fscanf(list, "%255s %511s %127s %31s", jobs[job_count].name, jobs[job_count].file, jobs[job_count].entry, jobs[job_count].target) == 4) {
        job_count++;
    }
    fclose(list);
    InitializeCriticalSection(&speaking);
    GetSystemInfo(&system);
    thread_count = system.dwNumberOfProcessors < MAXIMUM_WAIT_OBJECTS ? system.dwNumberOfProcessors : MAXIMUM_WAIT_OBJECTS;
    for (i = 0; i < thread_count; i++) threads[i] = CreateThread(NULL, 0, work, NULL, 0, NULL);
    WaitForMultipleObjects(thread_count, threads, TRUE, INFINITE);
    return failures != 0;
}
