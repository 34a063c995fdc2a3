// SPDX-License-Identifier: Apache-2.0
// How much stack the functions of a pipeline's kernel take on a GPU: the driver sizes the stack of
// kernels that recurse or call by address by a limit of the context, which somebody has to know.
// The driver's compiler tells of each function's frame in its log; until it has, and where the
// driver takes machine code from a cache of its own and logs nothing, frames are estimated.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace llvm {
class Module;
}

namespace sunstone::compiler {

// Bytes along the calls that take most. A ray traced at depth n (from 0) finds at most
// entry + n * waiting + other bytes taken when its walk and what the walk calls are at their
// deepest.
struct GpuStack {
    uint64_t entry = 0; // from the kernel, its own frame not counted, down to where a ray is traced
    uint64_t waiting = 0;    // from where one ray is traced down to where the next is
    uint64_t other = 0;      // from where a ray is traced to the end, without tracing another
    bool isMeasured = false; // with the frames of the driver's compiler
};

// The functions of a kernel's module and who calls whom.
class GpuCalls {
public:
    GpuCalls() = default;
    // `ptx` is what the code generator made of the module: it declares each function's frame, to
    // which room is added for what the driver's compiler saves.
    GpuCalls(const llvm::Module& module, std::string_view ptx);

    // Lines of text, for a cache; what is no such text gives no functions.
    std::string text() const;
    static GpuCalls fromText(std::string_view text);

    // Bytes of frames by function, as the driver's compiler has them; functions that it lacks are
    // parts of their callers. None: the estimates. A function that calls itself, other than by
    // tracing rays, counts once.
    using Frames = std::map<std::string, uint64_t, std::less<>>;
    GpuStack stack(const Frames& frames = {}) const;

private:
    struct Function {
        std::string name;
        uint64_t estimate = 0;
        bool traces = false;           // calls the tracing function itself
        std::vector<uint32_t> callees; // but for the tracing function
    };
    std::vector<Function> functions_;
};

// The frames that a log of the driver's compiler tells of (CU_JIT_LOG_VERBOSE); none unless the
// kernel's is among them.
GpuCalls::Frames gpuFramesIn(std::string_view log);

} // namespace sunstone::compiler
