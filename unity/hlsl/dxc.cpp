// Microsoft's DXC as a program: `dxc IN OUT ENTRY TARGET [OPTION..]`. Looks for libdxcompiler.so beside itself.
//
// Of its interface, which is that of COM, only what is called here is declared.

#include <clocale>
#include <cstdint>
#include <cstdio>
#include <dlfcn.h>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace {

struct Guid {
    std::uint32_t a;
    std::uint16_t b, c;
    std::uint8_t d[8];
};

constexpr Guid COMPILER_CLASS{0x73e22d93, 0xe6ce, 0x47f3, {0xb5, 0xbf, 0xf0, 0x66, 0x4f, 0x39, 0xc1, 0xb0}};
constexpr Guid COMPILER{0x228b4687, 0x5a6a, 0x4730, {0x90, 0x0c, 0x97, 0x02, 0xb2, 0x20, 0x3f, 0x54}};
constexpr Guid RESULT{0x58346cda, 0xdde7, 0x4497, {0x94, 0x61, 0x6f, 0x87, 0xaf, 0x5e, 0x06, 0x59}};

struct Unknown {
    virtual std::int32_t query_interface(const Guid&, void**) = 0;
    virtual std::uint32_t add_reference() = 0;
    virtual std::uint32_t release() = 0;
};

// IDxcBlob
struct Blob : Unknown {
    virtual void* data() = 0;
    virtual std::size_t size() = 0;
};

// IDxcOperationResult, the beginning of IDxcResult
struct Result : Unknown {
    virtual std::int32_t status(std::int32_t*) = 0;
    virtual std::int32_t result(Blob**) = 0;
    virtual std::int32_t errors(Blob**) = 0;
};

// DxcBuffer
struct Source {
    const void* data;
    std::size_t size;
    std::uint32_t encoding;
};

// IDxcCompiler3
struct Compiler : Unknown {
    virtual std::int32_t compile(const Source*, const wchar_t**, std::uint32_t, void* includes, const Guid&, void**) = 0;
};

constexpr std::uint32_t UTF8 = 65001;

std::wstring wide(const char* text) {
    return std::wstring(text, text + std::char_traits<char>::length(text));
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 5) {
        std::fputs("usage: dxc IN OUT ENTRY TARGET [OPTION..]\n", stderr);
        return 2;
    }
    std::setlocale(LC_ALL, "C.UTF-8");
    void* library = dlopen("libdxcompiler.so", RTLD_NOW);
    if (!library) {
        std::fprintf(stderr, "%s\n", dlerror());
        return 2;
    }
    using Create = std::int32_t (*)(const Guid&, const Guid&, void**);
    const auto create = reinterpret_cast<Create>(dlsym(library, "DxcCreateInstance"));
    Compiler* compiler = nullptr;
    if (!create || create(COMPILER_CLASS, COMPILER, reinterpret_cast<void**>(&compiler)) != 0) {
        std::fputs("libdxcompiler.so makes no compiler\n", stderr);
        return 2;
    }

    std::ifstream file(arguments[1], std::ios::binary);
    if (!file) {
        std::fprintf(stderr, "%s cannot be read\n", arguments[1]);
        return 2;
    }
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    std::vector<std::wstring> options{wide(arguments[1]), L"-E", wide(arguments[3]), L"-T", wide(arguments[4])};
    for (int i = 5; i < count; i++) {
        options.push_back(wide(arguments[i]));
    }
    std::vector<const wchar_t*> pointers;
    for (const auto& option : options) {
        pointers.push_back(option.c_str());
    }

    const Source source{text.data(), text.size(), UTF8};
    Result* result = nullptr;
    std::int32_t status = compiler->compile(
        &source, pointers.data(), static_cast<std::uint32_t>(pointers.size()), nullptr, RESULT, reinterpret_cast<void**>(&result));
    if (status == 0) {
        result->status(&status);
    }
    Blob* errors = nullptr;
    if (result && result->errors(&errors) == 0 && errors && errors->size() > 0) {
        std::fwrite(errors->data(), 1, errors->size(), stderr);
    }
    if (status != 0) {
        std::fprintf(stderr, "%s: DXC refuses it\n", arguments[1]);
        return 1;
    }
    Blob* binary = nullptr;
    result->result(&binary);
    std::ofstream out(arguments[2], std::ios::binary);
    out.write(static_cast<const char*>(binary->data()), static_cast<std::streamsize>(binary->size()));
    out.close();
    if (!out) {
        std::fprintf(stderr, "%s cannot be written\n", arguments[2]);
        return 2;
    }
    // Nothing is released: taking the compiler down costs as much time as a small kernel.
    std::fflush(nullptr);
    _Exit(0);
}
