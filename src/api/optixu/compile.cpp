// SPDX-License-Identifier: Apache-2.0
// CUDA sources to PTX: by clang with the project's CUDA headers, else by nvcc. A thread keeps the
// outcome of its latest compilation.
#include "api/optixu/guard.h"
#include "api/optixu/options.h"
#include "api/optixu/process.h"
#include "base/threads/thread_object.h"

#include <optixu/optixu.h>

#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace sunstone::optixu {
namespace {

struct Compilation {
    std::string ptx, messages;
};

// The folder of CUDA headers beside the library; empty if there is none.
std::string cudaHeaders() {
    // An exported function may have its address in the executable.
    static const char ours = 0;
    Dl_info library;
    if (!dladdr(&ours, &library) || !library.dli_fname)
        return "";
    std::string path = library.dli_fname;
    const size_t slash = path.rfind('/');
    path = (slash == std::string::npos ? "." : path.substr(0, slash)) + "/../include/sunstone/cuda";
    struct stat status;
    return stat((path + "/cuda_runtime.h").c_str(), &status) == 0 ? path : "";
}

std::vector<std::string> clangCommand(const std::string& headers,
                                      const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {"clang++-19",
#include "device_flags.inc"
                                        "-I" + headers, "-include", headers + "/cuda_runtime.h"};
    const std::vector<std::string> options = clangOptions(arguments);
    command.insert(command.end(), options.begin(), options.end());
    command.insert(command.end(), {"-S", "-o", "-", "-"});
    return command;
}

// nvcc removes its output file before it writes it, so it gets a file of its own.
class TemporaryFile {
public:
    TemporaryFile() : name_(std::filesystem::temp_directory_path() / "optixu_XXXXXX") {
        const int file = mkstemp(name_.data());
        if (file >= 0)
            close(file);
    }
    ~TemporaryFile() { unlink(name_.c_str()); }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const std::string& name() const { return name_; }

private:
    std::string name_;
};

bool readFile(const char* name, std::string& text) {
    std::ifstream file(name);
    char part[4096];
    while (file.read(part, sizeof(part)) || file.gcount() > 0)
        text.append(part, size_t(file.gcount()));
    return file.eof() && !file.bad(); // opening a folder succeeds, too
}

Outcome runNvcc(const std::string& source, const std::vector<std::string>& arguments) {
    const TemporaryFile ptx;
    // Variables without a use stay: the API finds them by name.
    std::vector<std::string> command = {"nvcc", "-x", "cu", "-ptx", "-rdc=true", "-O3"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    command.insert(command.end(), {"-o", ptx.name(), "-"});
    Outcome outcome = runProcess(command, source);
    outcome.output.clear();
    if (outcome.status == 0 && !readFile(ptx.name().c_str(), outcome.output))
        outcome.status = -1;
    return outcome;
}

Outcome compile(const std::string& source, const std::vector<std::string>& arguments) {
    const std::string headers = cudaHeaders();
    if (!headers.empty()) {
        Outcome outcome = runProcess(clangCommand(headers, arguments), source);
        if (outcome.started)
            return outcome;
    }
    return runNvcc(source, arguments);
}

RTresult compileSource(const char* function, const std::string& source,
                       const std::vector<std::string>& arguments, RTsize* resultSize,
                       RTsize* errorSize) {
    Compilation& latest = threadObject<Compilation>();
    latest = {};
    const Outcome outcome = compile(source, arguments);
    if (outcome.status == 0)
        latest.ptx = outcome.output;
    latest.messages = outcome.started ? outcome.errors : "neither clang++-19 nor nvcc is in PATH";
    if (resultSize)
        *resultSize = latest.ptx.empty() ? 0 : latest.ptx.size() + 1;
    if (errorSize)
        *errorSize = latest.messages.size() + 1;
    if (!outcome.started)
        return refuse(function, RT_ERROR_NOT_SUPPORTED, latest.messages);
    if (outcome.status != 0)
        return refuse(function, RT_ERROR_INVALID_SOURCE, latest.messages);
    return RT_SUCCESS;
}

// Checks and copies the list; returns the error, or an empty text.
std::string readArguments(const char** list, unsigned count, std::vector<std::string>& arguments) {
    if (!list && count)
        return "preprocessorArguments is null, numPreprocessorArguments is " +
               std::to_string(count);
    for (unsigned i = 0; i < count; ++i) {
        if (!list[i])
            return "preprocessorArguments[" + std::to_string(i) + "] is null";
        arguments.push_back(list[i]);
    }
    return "";
}

RTresult compileString(const char* function, const char* source, const char** list, unsigned count,
                       RTsize* resultSize, RTsize* errorSize) {
    std::vector<std::string> arguments;
    const std::string fault = source ? readArguments(list, count, arguments) : "source is null";
    if (!fault.empty())
        return refuse(function, RT_ERROR_INVALID_VALUE, fault);
    return compileSource(function, source, arguments, resultSize, errorSize);
}

RTresult compileFile(const char* function, const char* filename, const char** list, unsigned count,
                     RTsize* resultSize, RTsize* errorSize) {
    std::vector<std::string> arguments;
    const std::string fault = filename ? readArguments(list, count, arguments) : "filename is null";
    if (!fault.empty())
        return refuse(function, RT_ERROR_INVALID_VALUE, fault);
    const std::string path = filename;
    std::string source;
    if (!readFile(filename, source))
        return refuse(function, RT_ERROR_FILE_NOT_FOUND, "filename = " + path + " cannot be read");
    // Relative includes are searched in the file's folder.
    const size_t slash = path.rfind('/');
    arguments.push_back("-I" + (slash == std::string::npos ? "." : path.substr(0, slash + 1)));
    return compileSource(function, source, arguments, resultSize, errorSize);
}

RTresult getResult(char* result, char* error) {
    const Compilation& latest = threadObject<Compilation>();
    if (result && !latest.ptx.empty())
        std::memcpy(result, latest.ptx.c_str(), latest.ptx.size() + 1);
    if (error)
        std::memcpy(error, latest.messages.c_str(), latest.messages.size() + 1);
    return RT_SUCCESS;
}

} // namespace
} // namespace sunstone::optixu

using namespace sunstone::optixu;

SUNSTONE_API RTresult rtuCUDACompileString(const char* source, const char** preprocessorArguments,
                                           unsigned int numPreprocessorArguments,
                                           RTsize* resultSize, RTsize* errorSize) {
    const char* function = __func__;
    return guarded(function, [&] {
        return compileString(function, source, preprocessorArguments, numPreprocessorArguments,
                             resultSize, errorSize);
    });
}

SUNSTONE_API RTresult rtuCUDACompileFile(const char* filename, const char** preprocessorArguments,
                                         unsigned int numPreprocessorArguments, RTsize* resultSize,
                                         RTsize* errorSize) {
    const char* function = __func__;
    return guarded(function, [&] {
        return compileFile(function, filename, preprocessorArguments, numPreprocessorArguments,
                           resultSize, errorSize);
    });
}

SUNSTONE_API RTresult rtuCUDAGetCompileResult(char* result, char* error) {
    return guarded(__func__, [&] { return getResult(result, error); });
}
