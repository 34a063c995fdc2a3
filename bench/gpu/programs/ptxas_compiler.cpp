// SPDX-License-Identifier: Apache-2.0
// A library with the name and functions of the PTX compiler that comes with a GPU's driver. It
// compiles each pipeline with ptxas for compute capability 9.0 and prints registers, frame, spills,
// size and time. It returns the text as machine code, which the CPU device runs. This shows the
// results of ptxas on a machine without a GPU. docs/notes/programs-gpu.md has the command and a
// table. With SUNSTONE_KEEP_PTX set, texts, code and logs stay in folders /tmp/sunstone_ptxas_*.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace {

struct Compilation {
    std::string text, log;
};

Compilation& of(void* handle) {
    return *static_cast<Compilation*>(handle);
}

double processorTimeOfChildren() {
    rusage used = {};
    getrusage(RUSAGE_CHILDREN, &used);
    return double(used.ru_utime.tv_sec) + double(used.ru_utime.tv_usec) * 1e-6;
}

// The number before `what` in the kernel's part of the log.
unsigned numberBefore(const std::string& log, const char* what, size_t from) {
    const size_t at = log.find(what, from);
    if (at == log.npos || at < 2)
        return 0;
    size_t begin = at - 1; // of the space
    while (begin > 0 && std::strchr("0123456789", log[begin - 1]))
        --begin;
    return unsigned(std::strtoul(log.c_str() + begin, nullptr, 10));
}

void report(const std::string& log, uintmax_t code, size_t text, double seconds,
            const std::string& registers) {
    const size_t kernel = log.find("Function properties for sunstone_launch");
    if (kernel == log.npos)
        return;
    std::fprintf(stderr,
                 "ptxas %s: registers %u, frame %u, spill stores %u, spill loads %u, code %ju, "
                 "text %zu, %.0f ms\n",
                 registers.c_str(), numberBefore(log, " registers", kernel),
                 numberBefore(log, " bytes stack frame", kernel),
                 numberBefore(log, " bytes spill stores", kernel),
                 numberBefore(log, " bytes spill loads", kernel), code, text, 1000 * seconds);
}

} // namespace

extern "C" {

int nvPTXCompilerCreate(void** handle, size_t, const char* text) {
    *handle = new Compilation{text, {}};
    return 0;
}

int nvPTXCompilerDestroy(void** handle) {
    delete &of(*handle);
    *handle = nullptr;
    return 0;
}

int nvPTXCompilerCompile(void* handle, int count, const char* const* options) {
    namespace fs = std::filesystem;
    Compilation& compilation = of(handle);
    std::string registers = "--maxrregcount=255", form = "";
    for (int i = 0; i < count; ++i)
        if (std::strncmp(options[i], "--maxrregcount", 14) == 0)
            registers = options[i];
        else if (std::strcmp(options[i], "--compile-only") == 0)
            form = "--compile-only ";
    if (form.empty() && compilation.text.find(".entry sunstone_launch") == std::string::npos)
        return 0; // a kernel of the library
    char name[] = "/tmp/sunstone_ptxas_XXXXXX";
    if (!mkdtemp(name))
        return 1;
    const fs::path folder = name;
    std::ofstream(folder / "text.ptx") << compilation.text;
    const std::string command = std::string(SUNSTONE_PTXAS " -v -arch=sm_90 ") + form + registers +
                                " -o " + name + "/code " + name + "/text.ptx >" + name +
                                "/log 2>&1";
    const double before = processorTimeOfChildren();
    const int status = std::system(command.c_str());
    const double seconds = processorTimeOfChildren() - before;
    std::ifstream log(folder / "log");
    compilation.log.assign(std::istreambuf_iterator<char>(log), {});
    if (status == 0)
        report(compilation.log, fs::file_size(folder / "code"), compilation.text.size(), seconds,
               form + registers.substr(2));
    if (!std::getenv("SUNSTONE_KEEP_PTX"))
        fs::remove_all(folder);
    return status == 0 ? 0 : 4;
}

int nvPTXCompilerGetCompiledProgramSize(void* handle, size_t* size) {
    *size = of(handle).text.size() + 1;
    return 0;
}
int nvPTXCompilerGetCompiledProgram(void* handle, void* code) {
    std::memcpy(code, of(handle).text.c_str(), of(handle).text.size() + 1);
    return 0;
}
int nvPTXCompilerGetInfoLogSize(void* handle, size_t* size) {
    *size = of(handle).log.size();
    return 0;
}
int nvPTXCompilerGetInfoLog(void* handle, char* log) {
    std::memcpy(log, of(handle).log.c_str(), of(handle).log.size() + 1);
    return 0;
}
int nvPTXCompilerGetErrorLogSize(void* handle, size_t* size) {
    return nvPTXCompilerGetInfoLogSize(handle, size);
}
int nvPTXCompilerGetErrorLog(void* handle, char* log) {
    return nvPTXCompilerGetInfoLog(handle, log);
}

} // extern "C"
