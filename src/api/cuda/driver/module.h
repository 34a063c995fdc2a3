// SPDX-License-Identifier: Apache-2.0
// Modules and functions of the driver API. A module is parsed when it is loaded and compiled when a
// function or variable of it is first asked for: programs load large modules and use little of
// them.
#pragma once

#include "api/cuda/driver/shell.h"
#include "compiler/compiler.h"

#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace sunstone::api::cuda {

class Module;

struct Function {
    std::weak_ptr<Module> module; // launches hold it, so that the code lives while they are queued
    const compiler::KernelInfo* info = nullptr;
    std::atomic<unsigned> maxDynamicShared{0}; // 0: what is left of the block's share
    std::atomic<int> carveout{-1};
};

class Module : public std::enable_shared_from_this<Module> {
public:
    Module(std::shared_ptr<const ptx::Module> tree, const void* owner);
    ~Module();

    const void* owner() const { return owner_; }
    // Null if there is no such kernel.
    Function* function(const std::string& name);
    size_t functionCount();
    std::vector<Function*> functions();
    // Address and size of a variable; false if there is none.
    bool variable(const std::string& name, void** address, uint64_t* size);
    // Makes every function handle of the module invalid.
    void retire();
    int ptxVersion() const;

private:
    void compile(); // at most once; throws what the compiler throws, each time

    const std::shared_ptr<const ptx::Module> tree_;
    const void* const owner_;
    std::mutex mutex_;
    std::unique_ptr<compiler::KernelCode> code_;
    std::map<std::string, std::shared_ptr<Function>> functions_;
    std::vector<const void*> adopted_; // variables known to Memory
};

// The live module or function of a handle, or CUDA_ERROR_INVALID_HANDLE.
std::shared_ptr<Module> moduleOf(CUmodule module);
std::shared_ptr<Function> functionOf(CUfunction function);

} // namespace sunstone::api::cuda
