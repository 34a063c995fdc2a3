// SPDX-License-Identifier: Apache-2.0
// Compiles a source file with NVRTC, which is loaded at run time: once with the headers on an
// include path and, if names of headers are given, once with the headers as strings under the names
// programs include them by. Usage:
// nvrtc_check LIBNVRTC INCLUDE_FOLDER GENERATED_FOLDER SOURCE OUTPUT.ptx [HEADER...]
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
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
    if (argc < 6)
        return 2;
    const Nvrtc nvrtc = open(argv[1]);
    const std::string include = argv[2], source = read(argv[4]);
    std::vector<std::string> own, ownTexts;
    for (const auto& entry : std::filesystem::directory_iterator(argv[3])) {
        own.push_back(entry.path().filename());
        ownTexts.push_back(read(entry.path()));
    }
    for (const char* standard : {"--std=c++11", "--std=c++17"}) {
        const std::vector<std::string> options = {standard, "--gpu-architecture=compute_75",
                                                  "-D__NV_NO_VECTOR_DEPRECATION_DIAG"};

        std::vector<std::string> withPath = options;
        withPath.push_back("-I" + include);
        const std::string byPath = compile(nvrtc, source, own, ownTexts, withPath);
        if (byPath.empty())
            return 1;

        std::vector<std::string> names = own, texts = ownTexts;
        for (int i = 6; i < argc; ++i) {
            names.push_back(argv[i]);
            texts.push_back(read(include + "/" + argv[i]));
        }
        if (argc > 6 && byPath != compile(nvrtc, source, names, texts, options)) {
            std::fprintf(stderr, "%s: with headers from memory it fails or differs\n", standard);
            return 1;
        }
        std::ofstream(argv[5]) << byPath;
    }
    return 0;
}
