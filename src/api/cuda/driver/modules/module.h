// SPDX-License-Identifier: Apache-2.0
// Modules and functions of the driver API. A module is parsed when it is loaded. Its variables are
// created at the first access to the module. A kernel is compiled at its first launch or at the
// first query that needs its code, because programs look up many kernels that they do not launch.
// Compiled code is kept in the disk cache, which OptiX programs share.
#pragma once

#include "api/cuda/driver/shell.h"
#include "base/handles.h"
#include "compiler/kernels/kernel_module.h"
#include "ptx/ast.h"

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::api::cuda {

class Module;

// The options of cuModuleLoadDataEx and cuLinkCreate: the buffers for messages.
class JitOptions {
public:
    JitOptions() = default;
    // Throws Failure for null arrays and unknown options.
    JitOptions(unsigned count, const CUjit_option* options, void** values);
    // Writes to the caller's buffers, if given.
    void report(const std::string& information, const std::string& errors, float milliseconds);
    bool debug() const { return debug_; }

private:
    char* info_ = nullptr;
    char* error_ = nullptr;
    void** infoSize_ = nullptr; // option values: a size in, the length written out
    void** errorSize_ = nullptr;
    void** wallTime_ = nullptr;
    bool debug_ = false;
};

// Parses; throws Failure with CUDA_ERROR_INVALID_PTX and the messages.
std::shared_ptr<const ptx::Module> parsePtx(const std::string& text, std::string* warnings);

struct Function : Handled {
    std::weak_ptr<Module> module; // launches own it, so that the code outlives queued work
    const compiler::KernelInfo* info = nullptr; // complete after compilation, which writes it anew
    std::string name;                           // stays in place for callers of cuFuncGetName
    size_t index = 0;                           // in the module
    std::atomic<bool> compiled{false};
    std::atomic<unsigned> maxDynamicShared{0}; // 0: the rest of the block's share
    std::atomic<int> carveout{-1};
    std::atomic<uint32_t> blockCost{0}; // recent nanoseconds per block; 0: has not run
};

class Module : public Handled, public std::enable_shared_from_this<Module> {
public:
    Module(std::vector<std::shared_ptr<const ptx::Module>> trees, const void* owner,
           compiler::DebugLevel debugLevel);
    ~Module();

    const void* owner() const { return owner_; }
    // Null if the module has no such kernel. It may have no code yet.
    Function* function(const std::string& name);
    size_t functionCount();
    std::vector<Function*> functions();
    // Address and size of a variable; false if the module has no such variable.
    bool variable(const std::string& name, void** address, uint64_t* size);
    // The type of a texture or surface reference; Type::kNone for other variables.
    ptx::Type referenceType(const std::string& name) const;
    // Compiles the function if necessary. Throws the compiler's errors, each time.
    void compile(Function& function);
    // Invalidates all function handles of the module.
    void retire();
    int ptxVersion() const;

private:
    void open(); // opens once; throws the compiler's errors, each time

    const std::vector<std::shared_ptr<const ptx::Module>> trees_; // several for a linked image
    const void* const owner_;
    const compiler::DebugLevel debugLevel_;
    std::mutex mutex_;
    std::unique_ptr<compiler::KernelModule> code_;
    std::map<std::string, std::shared_ptr<Function>> functions_;
    std::vector<const void*> adopted_; // variables registered with Memory
};

// The parsed PTX texts of an image.
struct ParsedImage {
    std::vector<std::shared_ptr<const ptx::Module>> trees;
    compiler::DebugLevel debugLevel;
};
ParsedImage parseImage(const std::vector<std::string>& texts, JitOptions options);
// Makes a module in the current context.
CUmodule makeModule(const ParsedImage& image);
void unloadModule(CUmodule module); // ignores other handles

// The live module or function of a handle; throws CUDA_ERROR_INVALID_HANDLE. A kernel of a library
// gives its function in the current context. liveFunctionOf does not compile it.
std::shared_ptr<Module> moduleOf(CUmodule module);
std::shared_ptr<Module> findModule(CUmodule module); // null for other handles
std::shared_ptr<Function> functionOf(CUfunction function);
std::shared_ptr<Function> liveFunctionOf(CUfunction function);
void ensureCompiled(Function& function); // throws the compiler's errors

// function.cpp; both compile the function if the attribute needs its code, and throw
// CUDA_ERROR_INVALID_VALUE.
int attributeOf(Function& function, CUfunction_attribute attribute);
void setAttribute(Function& function, CUfunction_attribute attribute, int value);

} // namespace sunstone::api::cuda
