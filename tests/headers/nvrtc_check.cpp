// SPDX-License-Identifier: Apache-2.0
// Compiles device_checks.cu with NVRTC, which is loaded at run time: once with the headers on an
// include path and once with the headers given as strings under the names programs include them by.
// Usage: nvrtc_check LIBNVRTC INCLUDE_FOLDER GENERATED_FOLDER SOURCE OUTPUT.ptx
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace {

// The part of the NVRTC interface in use.
struct Nvrtc {
    using Program = struct Opaque*;
    int (*createProgram)(Program*, const char*, const char*, int, const char* const*,
                         const char* const*);
    int (*compileProgram)(Program, int, const char* const*);
    int (*getPtxSize)(Program, size_t*);
    int (*getPtx)(Program, char*);
    int (*getLogSize)(Program, size_t*);
    int (*getLog)(Program, char*);
};

template <typename Function>
void load(void* library, const char* name, Function& function) {
    void* symbol = dlsym(library, name);
    if (!symbol) {
        std::fprintf(stderr, "NVRTC without %s\n", name);
        std::exit(1);
    }
    std::memcpy(&function, &symbol, sizeof(function));
}

Nvrtc open(const char* path) {
    void* library = dlopen(path, RTLD_NOW);
    if (!library) {
        std::fprintf(stderr, "%s\n", dlerror());
        std::exit(1);
    }
    Nvrtc nvrtc;
    load(library, "nvrtcCreateProgram", nvrtc.createProgram);
    load(library, "nvrtcCompileProgram", nvrtc.compileProgram);
    load(library, "nvrtcGetPTXSize", nvrtc.getPtxSize);
    load(library, "nvrtcGetPTX", nvrtc.getPtx);
    load(library, "nvrtcGetProgramLogSize", nvrtc.getLogSize);
    load(library, "nvrtcGetProgramLog", nvrtc.getLog);
    return nvrtc;
}

std::string read(const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    if (!file) {
        std::fprintf(stderr, "cannot read %s\n", path.c_str());
        std::exit(1);
    }
    return text.str();
}

// Returns the PTX; any message of the compiler, even a warning, is a failure.
std::string compile(const Nvrtc& nvrtc, const std::string& source,
                    const std::vector<std::string>& names, const std::vector<std::string>& texts,
                    const std::vector<std::string>& options) {
    std::vector<const char*> namePointers, textPointers, optionPointers;
    for (const auto& s : names)
        namePointers.push_back(s.c_str());
    for (const auto& s : texts)
        textPointers.push_back(s.c_str());
    for (const auto& s : options)
        optionPointers.push_back(s.c_str());
    Nvrtc::Program program = nullptr;
    if (nvrtc.createProgram(&program, source.c_str(), "device_checks.cu", int(names.size()),
                            textPointers.data(), namePointers.data()) != 0)
        return "";
    const int result = nvrtc.compileProgram(program, int(options.size()), optionPointers.data());
    size_t size = 0;
    nvrtc.getLogSize(program, &size);
    std::string log(size, '\0');
    nvrtc.getLog(program, log.data());
    if (result != 0 || size > 1) {
        std::fprintf(stderr, "NVRTC result %d:\n%s\n", result, log.c_str());
        return "";
    }
    nvrtc.getPtxSize(program, &size);
    std::string ptx(size, '\0');
    nvrtc.getPtx(program, ptx.data());
    ptx.resize(std::strlen(ptx.c_str()));
    return ptx;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 6)
        return 2;
    const Nvrtc nvrtc = open(argv[1]);
    const std::string include = argv[2], generated = argv[3], source = read(argv[4]);
    const std::vector<std::string> own = {"device_checks.inc", "device_calls.inc"};
    std::vector<std::string> ownTexts;
    for (const auto& name : own)
        ownTexts.push_back(read(generated + "/" + name));
    for (const char* standard : {"--std=c++11", "--std=c++17"}) {
        const std::vector<std::string> options = {standard, "--gpu-architecture=compute_75"};

        std::vector<std::string> withPath = options;
        withPath.push_back("-I" + include);
        const std::string byPath = compile(nvrtc, source, own, ownTexts, withPath);

        std::vector<std::string> names = own, texts = ownTexts;
        for (const char* header :
             {"optix.h", "optix_device.h", "optix_7_device.h", "optix_7_types.h",
              "internal/optix_7_device_impl.h", "internal/optix_7_device_impl_exception.h",
              "internal/optix_7_device_impl_transformations.h"}) {
            names.push_back(header);
            texts.push_back(read(include + "/" + header));
        }
        const std::string inMemory = compile(nvrtc, source, names, texts, options);
        if (byPath.empty() || byPath != inMemory) {
            std::fprintf(stderr, "%s: the two ways failed or differ\n", standard);
            return 1;
        }
        std::ofstream(argv[5]) << byPath;
    }
    return 0;
}
