// SPDX-License-Identifier: Apache-2.0
// A CUDA module whose kernels are compiled at first use, because programs load large modules and
// launch few of their kernels. Each kernel with the functions it calls is a piece, kept in a store.
// The module's variables are another piece, made at once, because the host may ask for any of them.
// In a module with calls through pointers, all kernels are one piece, because the callees are
// unknown. The kernels of several modules linked from relocatable code are also one piece.
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
    // Compiles kernels()[index] and completes its description (address, shared and local memory,
    // used features, why it cannot run). Not thread-safe. Throws the compiler's errors at each
    // call.
    virtual void prepare(size_t index) = 0;
    virtual void forEachVariable(
        const std::function<void(void* address, uint64_t bytes, bool isManaged)>& visit) const = 0;
};

using KernelModules = std::vector<std::shared_ptr<const ptx::Module>>;

// Throws kLinkError if a symbol of several modules is missing or defined twice.
std::unique_ptr<KernelModule> openKernels(const KernelModules& modules,
                                          const KernelOptions& options = {});
inline std::unique_ptr<KernelModule> openKernels(std::shared_ptr<const ptx::Module> module,
                                                 const KernelOptions& options = {}) {
    return openKernels(KernelModules{std::move(module)}, options);
}

// Throws the errors of openKernels for symbols and instructions; generates no code.
void checkKernels(const KernelModules& modules);

// The level that the module requests: full if it was compiled for debugging (`.target ..., debug`).
DebugLevel debugLevelOf(const ptx::Module& module);

} // namespace sunstone::compiler
