// SPDX-License-Identifier: Apache-2.0
// See ptx_compiler.h. Source: PTX Compiler API reference, 12.0.
#include "device/cuda/ptx_compiler.h"

#include "base/error.h"
#include "base/log.h"

#include <dlfcn.h>

#include <vector>

namespace sunstone::device::cuda {

namespace {

using Compiler = void*;

// Functions return 0 for success.
struct Functions {
    int (*create)(Compiler*, size_t length, const char* text) = nullptr;
    int (*destroy)(Compiler*) = nullptr;
    int (*compile)(Compiler, int count, const char* const* options) = nullptr;
    int (*programSize)(Compiler, size_t*) = nullptr;
    int (*program)(Compiler, void*) = nullptr;
    int (*infoSize)(Compiler, size_t*) = nullptr;
    int (*info)(Compiler, char*) = nullptr;
    int (*errorSize)(Compiler, size_t*) = nullptr;
    int (*error)(Compiler, char*) = nullptr;

    template <class Function>
    static bool find(void* library, Function& function, const char* name) {
        return (function = reinterpret_cast<Function>(dlsym(library, name)));
    }

    bool load() {
        void* const library = dlopen(kPtxCompilerLibrary, RTLD_NOW | RTLD_LOCAL);
        if (!library)
            return false;
        return find(library, create, "nvPTXCompilerCreate") &&
               find(library, destroy, "nvPTXCompilerDestroy") &&
               find(library, compile, "nvPTXCompilerCompile") &&
               find(library, programSize, "nvPTXCompilerGetCompiledProgramSize") &&
               find(library, program, "nvPTXCompilerGetCompiledProgram") &&
               find(library, infoSize, "nvPTXCompilerGetInfoLogSize") &&
               find(library, info, "nvPTXCompilerGetInfoLog") &&
               find(library, errorSize, "nvPTXCompilerGetErrorLogSize") &&
               find(library, error, "nvPTXCompilerGetErrorLog");
    }
};

const Functions* functions() {
    static Functions all;
    static const bool isThere = all.load();
    return isThere ? &all : nullptr;
}

std::string text(Compiler compiler, int (*sizeOf)(Compiler, size_t*),
                 int (*read)(Compiler, char*)) {
    size_t size = 0;
    if (sizeOf(compiler, &size) != 0 || size == 0)
        return {};
    std::string out(size + 1, '\0');
    if (read(compiler, out.data()) != 0)
        return {};
    out.resize(out.find('\0'));
    return out;
}

// A text for sm_90a needs that name; texts for other targets compile for the device's own name.
std::string deviceName(const std::string& ptx, unsigned computeCapability) {
    const std::string own = message("sm_", computeCapability), exact = own + "a";
    constexpr std::string_view kDirective = "\n.target ";
    const size_t at = ptx.find(kDirective);
    return at != ptx.npos && ptx.compare(at + kDirective.size(), exact.size(), exact) == 0 ? exact
                                                                                           : own;
}

} // namespace

bool hasPtxCompiler() {
    return functions() != nullptr;
}

std::optional<MachineCode> compilePtx(const std::string& ptx, unsigned computeCapability,
                                      unsigned maxRegisters, PtxUse use) {
    const Functions* const call = functions();
    if (!call)
        return {};
    struct Owned {
        const Functions& call;
        Compiler compiler = nullptr;
        ~Owned() {
            if (compiler)
                call.destroy(&compiler);
        }
    } owned{*call};
    if (call->create(&owned.compiler, ptx.size() + 1, ptx.c_str()) != 0)
        return {};
    const std::string device = "--gpu-name=" + deviceName(ptx, computeCapability),
                      registers = message("--maxrregcount=", maxRegisters);
    std::vector<const char*> options = {device.c_str(), "--verbose"};
    if (maxRegisters != 0)
        options.insert(options.begin() + 1, registers.c_str());
    if (use == PtxUse::kPart)
        options.push_back("--compile-only");
    MachineCode code;
    size_t size = 0;
    if (call->compile(owned.compiler, int(options.size()), options.data()) != 0 ||
        call->programSize(owned.compiler, &size) != 0 || size == 0) {
        log(LogLevel::kDebug, "device",
            message(kPtxCompilerLibrary,
                    " refuses a text: ", text(owned.compiler, call->errorSize, call->error)));
        return {};
    }
    code.cubin.resize(size);
    if (call->program(owned.compiler, code.cubin.data()) != 0)
        return {};
    code.log = text(owned.compiler, call->infoSize, call->info);
    return code;
}

} // namespace sunstone::device::cuda
