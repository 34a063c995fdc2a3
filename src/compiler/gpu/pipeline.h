// SPDX-License-Identifier: Apache-2.0
// A pipeline's programs for CUDA GPUs: all of them, the run-time of device programs (bitcode, given
// by the caller) and dispatchers from group number to program become one LLVM module, optimised as
// a whole and written as PTX for the driver. LLVM does not appear in this interface.
#pragma once

#include "compiler/compiler.h"
#include "compiler/gpu/stack.h"

#include <array>
#include <string_view>

namespace sunstone::compiler {

struct GpuTarget {
    unsigned computeCapability = 70; // 10 * major + minor of the device
    unsigned ptxVersion = 70;        // 10 * major + minor: the newest that the driver reads
    unsigned driverVersion = 0;      // of whose compiler machine code is
};

// A program group: indices in the request's programs.
struct GpuGroup {
    static constexpr size_t kNone = ~size_t(0);
    uint32_t number = 0; // what the run-time passes to dispatchers
    devlib::GroupKind kind = devlib::kGroupRaygen;
    std::array<size_t, devlib::kRoleCount> programs = [] {
        std::array<size_t, devlib::kRoleCount> none;
        none.fill(kNone);
        return none;
    }(); // by devlib::Role
    // What debug exceptions tell of the direct and of the continuation callable.
    struct Callable {
        std::string name;
        uint32_t parameterWords = 0;
    };
    Callable callables[2] = {};
    uint32_t builtin = 0; // of hit groups: GroupEntry::builtinPrimitive, for debug exceptions
};

struct GpuPipelineRequest {
    PipelineRequest pipeline;
    std::vector<GpuGroup> groups;
    std::string_view runtime; // LLVM bitcode for nvptx64
    // Values of `extern const uint32_t` variables of the run-time, which folds what they rule out.
    std::vector<std::pair<std::string, uint32_t>> constants;
    GpuTarget target;
    unsigned maxTraceDepth = 0; // of the pipeline, or 0: not known, and rays of programs recurse
};

// The run-time calls these, each with the state and a group number; a group without such a program
// answers ~0u: sunstone_gpu_raygen, _start, _startHit, _startMiss, _resume, _resumeAny, _miss,
// _exception, _closestHit, _anyHit, _intersection; and with the group number alone, for the code
// address or null: sunstone_gpu_direct, sunstone_gpu_continuation.
struct GpuCode {
    std::string ptx;      // of kGpuKernel; parameters: a LaunchBlock's address, LaunchConstants
    std::string feedback; // the kind of kernel, what was specialised to bound values, in lines
    GpuStack stack;
    std::string calls;       // GpuCalls::text()
    std::string machineCode; // of the text; empty where it is the driver that keeps it
    bool hasState = false;   // programs have variables in global memory: each pipeline has its own
};
constexpr const char* kGpuKernel = "sunstone_launch";

// Throws as compilePipeline does; kNotSupported for what the run-time for GPUs lacks.
GpuCode compileGpuPipeline(const GpuPipelineRequest& request);

// A digest of everything that the code depends on.
std::string keyOf(const GpuPipelineRequest& request);
// The same of a kernel that is a part of the library, by a name that no other one has.
std::string keyOf(const GpuTarget& target, std::string_view kernel);

// False where the store has none, or a value that cannot be read. Either the text or the machine code
// of what is found is empty.
bool findGpuPipeline(const std::string& key, ObjectStore& store, GpuCode& code);
// Of code with machine code the text is not kept.
void keepGpuPipeline(const std::string& key, const GpuCode& code, ObjectStore& store);

// Takes the sizes of frames that the driver's compiler has logged of the text, if it has.
void measureGpuStack(GpuCode& code, std::string_view log);

} // namespace sunstone::compiler
