// SPDX-License-Identifier: Apache-2.0
// A CUDA module whose kernels are compiled when they are first asked for: programs load large
// modules and launch few of their kernels. Each kernel is a piece of its own with what it calls,
// kept in a store; the variables of the module are one more, made at once, as the host may ask for
// any. Where a module calls functions through pointers, which kernel reaches what is not known:
// then all its kernels are one piece. So are those of a program of several modules, as a device
// linker makes it of relocatable code: what is extern in one is defined in another.
#pragma once

#include "compiler/compiler.h"

#include <functional>

namespace sunstone::compiler {

struct KernelOptions {
    DebugLevel debugLevel = DebugLevel::kMinimal;
    std::shared_ptr<ObjectStore> store; // may be null
};

class KernelModule : public KernelCode {
public:
    // Compiles kernels()[index] and fills what its description lacked (address, shared and local
    // memory, what it uses, why it cannot run). Not for two threads at a time. Throws what the
    // compiler throws, each time.
    virtual void prepare(size_t index) = 0;
    virtual void forEachVariable(
        const std::function<void(void* address, uint64_t bytes, bool isManaged)>& visit) const = 0;
};

using KernelModules = std::vector<std::shared_ptr<const ptx::Module>>;

// Throws kLinkError where a symbol of several modules is missing or defined twice.
std::unique_ptr<KernelModule> openKernels(const KernelModules& modules,
                                          const KernelOptions& options = {});
inline std::unique_ptr<KernelModule> openKernels(std::shared_ptr<const ptx::Module> module,
                                                 const KernelOptions& options = {}) {
    return openKernels(KernelModules{std::move(module)}, options);
}

// Throws what openKernels would throw for symbols and instructions; makes no code.
void checkKernels(const KernelModules& modules);

// The level that the module itself asks for: full where it was compiled for debugging
// (`.target ..., debug`).
DebugLevel debugLevelOf(const ptx::Module& module);

} // namespace sunstone::compiler
