// SPDX-License-Identifier: Apache-2.0
// How much stack the functions of a pipeline's kernel take on a GPU: the driver sizes the stack of
// kernels that recurse or call by address by a limit of the context, which somebody has to know.
#pragma once

#include <cstdint>
#include <string_view>

namespace llvm {
class Module;
}

namespace sunstone::compiler {

// Bytes along the calls that take most, with room for what the driver's compiler saves. A ray traced
// at depth n (from 0) finds at most entry + n * waiting + other bytes taken when its walk and what
// the walk calls are at their deepest.
struct GpuStack {
    uint64_t entry = 0;   // from the kernel, its own frame not counted, down to where a ray is traced
    uint64_t waiting = 0; // from where one ray is traced down to where the next is
    uint64_t other = 0;   // from where a ray is traced to the end, without tracing another
};

// `ptx` is what the code generator made of the module: it declares each function's frame. A function
// that calls itself, other than by tracing rays, counts once.
GpuStack gpuStackOf(const llvm::Module& module, std::string_view ptx);

} // namespace sunstone::compiler
