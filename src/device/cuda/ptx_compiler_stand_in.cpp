// SPDX-License-Identifier: Apache-2.0
// Tests only: a library with the name and functions of the PTX compiler that comes with a GPU's
// driver. Its machine code is the text after the options as comments; the CPU device's libcuda
// loads it like any PTX. It refuses texts that contain the word "refused".
#include <cstring>
#include <string>

namespace {

struct Compilation {
    std::string text, code, info, error;
};

Compilation& of(void* handle) {
    return *static_cast<Compilation*>(handle);
}

int sizeOf(const std::string& value, size_t* size) {
    *size = value.size();
    return 0;
}

int read(const std::string& value, char* to) { // logs end with 0
    std::memcpy(to, value.c_str(), value.size() + 1);
    return 0;
}

} // namespace

extern "C" {

int nvPTXCompilerCreate(void** handle, size_t length, const char* text) {
    if (length == 0 || text[length - 1] != '\0')
        return 1;
    *handle = new Compilation{text, {}, {}, {}};
    return 0;
}

int nvPTXCompilerDestroy(void** handle) {
    delete &of(*handle);
    *handle = nullptr;
    return 0;
}

int nvPTXCompilerCompile(void* handle, int count, const char* const* options) {
    Compilation& compilation = of(handle);
    if (compilation.text.find("refused") != std::string::npos) {
        compilation.error = "ptxas application ptx input, line 1; error   : refused";
        return 4;
    }
    for (int i = 0; i < count; ++i)
        compilation.code += std::string("// ") + options[i] + "\n";
    compilation.code += compilation.text;
    compilation.info = "ptxas info    : Function properties for sunstone_launch\n"
                       "    48 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads\n";
    return 0;
}

int nvPTXCompilerGetCompiledProgramSize(void* handle, size_t* size) {
    *size = of(handle).code.size() + 1;
    return 0;
}
int nvPTXCompilerGetCompiledProgram(void* handle, void* code) {
    return read(of(handle).code, static_cast<char*>(code));
}
int nvPTXCompilerGetInfoLogSize(void* handle, size_t* size) {
    return sizeOf(of(handle).info, size);
}
int nvPTXCompilerGetInfoLog(void* handle, char* log) {
    return read(of(handle).info, log);
}
int nvPTXCompilerGetErrorLogSize(void* handle, size_t* size) {
    return sizeOf(of(handle).error, size);
}
int nvPTXCompilerGetErrorLog(void* handle, char* log) {
    return read(of(handle).error, log);
}

} // extern "C"
