// SPDX-License-Identifier: Apache-2.0
// Stack needs of the functions of a pipeline's kernel on a GPU. For kernels that recurse or call by
// address, the engine must set the context's limit of the stack size. The log of the driver's
// compiler has each function's frame. Before compilation, and if the driver takes machine code from
// its own cache and logs nothing, frames are estimated.
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

// Bytes along the most expensive calls. A ray traced at depth n (from 0) finds at most entry + n *
// waiting + other bytes in use at the deepest point of its traversal and the functions it calls.
struct GpuStack {
    uint64_t entry = 0; // from the kernel, its own frame not counted, to the call that traces a ray
    uint64_t waiting = 0;    // from one trace to the next
    uint64_t other = 0;      // from a trace to the end, without further traces
    bool isMeasured = false; // with the frames of the driver's compiler
};

// The functions of a kernel's module and their calls.
class GpuCalls {
public:
    GpuCalls() = default;
    // `ptx` is the code generator's text of the module, which declares each function's frame.
    // Estimates include a reserve for registers that the driver's compiler saves.
    GpuCalls(const llvm::Module& module, std::string_view ptx);

    // Converts to lines of text for a cache, and back. Malformed text gives no functions.
    std::string text() const;
    static GpuCalls fromText(std::string_view text);

    // Bytes of frames by function, from the driver's compiler. Functions missing in it are inlined
    // in their callers. Empty: frames are estimated. A function that calls itself, other than by
    // tracing rays, counts once.
    using Frames = std::map<std::string, uint64_t, std::less<>>;
    GpuStack stack(const Frames& frames = {}) const;

private:
    struct Function {
        std::string name;
        uint64_t estimate = 0;
        bool traces = false;           // calls the tracing function itself
        std::vector<uint32_t> callees; // without the tracing function
    };
    std::vector<Function> functions_;
};

// The frames in a log of the driver's compiler (CU_JIT_LOG_VERBOSE); none unless the kernel's is
// among them.
GpuCalls::Frames gpuFramesIn(std::string_view log);
// Bytes of the kernel's spill stores, from the same log; 0 if the log has none.
uint64_t gpuSpillsIn(std::string_view log);

} // namespace sunstone::compiler
