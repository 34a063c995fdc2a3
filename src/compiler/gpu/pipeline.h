// SPDX-License-Identifier: Apache-2.0
// Compiles a pipeline's programs for CUDA GPUs. One LLVM module contains all programs, the run-time
// of device programs (bitcode from the caller) and dispatchers from group number to program. It is
// optimised as a whole and written as PTX for the driver. LLVM does not appear in this interface.
#pragma once

#include "compiler/compiler.h"
#include "compiler/gpu/stack.h"

#include <array>
#include <string_view>

namespace sunstone::compiler {

struct GpuTarget {
    unsigned computeCapability = 70; // 10 * major + minor of the device
    unsigned ptxVersion = 70;        // 10 * major + minor: the newest that the driver reads
    unsigned driverVersion = 0;      // the driver's compiler makes the machine code
};

// A program group: indices in the request's programs.
struct GpuGroup {
    static constexpr size_t kNone = ~size_t(0);
    uint32_t number = 0; // as the run-time passes it to dispatchers
    devlib::GroupKind kind = devlib::kGroupRaygen;
    std::array<size_t, devlib::kRoleCount> programs = [] {
        std::array<size_t, devlib::kRoleCount> none;
        none.fill(kNone);
        return none;
    }(); // by devlib::Role
    // Facts about the direct and the continuation callable, for debug exceptions.
    struct Callable {
        std::string name;
        uint32_t parameterWords = 0;
    };
    Callable callables[2] = {};
    uint32_t builtin = 0; // of hit groups: GroupEntry::builtinPrimitive, for debug exceptions
};

// A pipeline compiles as a whole, which gives the fastest code, or in parts that a linker joins:
// a kernel without programs, which is the same for all pipelines with equal constants, and the
// dispatchers that it calls, with their programs. All dispatchers are one part (kPrograms), or
// three that compile at the same time: programs of launch indices, programs of rays, and what
// follows traces.
enum class GpuPart : uint8_t { kWhole, kKernel, kPrograms, kEntries, kRays, kResumes };

struct GpuPipelineRequest {
    PipelineRequest pipeline;
    std::vector<GpuGroup> groups;
    std::string_view runtime; // LLVM bitcode for nvptx64
    // Values of the run-time's `extern const uint32_t` variables; code that they exclude is
    // removed.
    std::vector<std::pair<std::string, uint32_t>> constants;
    GpuTarget target;
    unsigned maxTraceDepth = 0; // of the pipeline; 0: unknown, rays of programs recurse
    // If all programs with one role and kind of group have more instructions together, they are
    // called by address, because the time of the driver's compiler grows faster than the size of a
    // function. Such frames take up to 1.6 times as long (docs/notes/compile-time.md has figures).
    size_t mostInlined = 24000;
    // kKernel reads neither groups nor programs. It serves programs up to its maxTraceDepth that
    // keep kReadyFrameBytes across a trace.
    GpuPart part = GpuPart::kWhole;
};
constexpr uint64_t kReadyFrameBytes = 640;
// Kernels for larger depths keep the states of rays in lane memory from the depth kNearDepths on.
constexpr unsigned kReadyDepth = 6, kNearDepths = 3;

// Functions that the run-time calls with the state and a group number; the result for a group
// without such a program is ~0u: sunstone_gpu_raygen, _start, _startHit, _startMiss, _resume,
// _resumeAny, _miss, _exception, _closestHit, _anyHit, _intersection. With the group number alone,
// the result is the code address or null: sunstone_gpu_direct, sunstone_gpu_continuation.
struct GpuCode {
    std::string ptx;      // of kGpuKernel; parameters: a LaunchBlock's address, LaunchConstants
    std::string feedback; // lines: the kind of kernel, loads specialised to bound values
    GpuStack stack;
    std::string calls;            // GpuCalls::text()
    std::string machineCode;      // of the text; empty if the driver keeps it
    uint64_t laneMemoryBytes = 0; // claimed by a warp (devlib/gpu/lane_memory.h)
    bool walksInStep = false;     // the warps of a block (devlib/gpu/nested.h)
    bool takesTurns = false;      // persistent threads (devlib/gpu/loop.h, nested.h)
    bool recurses = false;        // closest-hit or miss programs trace
    uint64_t frameBytes = 0;      // code of parts: bytes live across a trace
    bool hasState = false; // programs have variables in global memory: each pipeline has its own
};
constexpr const char* kGpuKernel = "sunstone_launch";

// Throws like compilePipeline; kNotSupported for features that the run-time for GPUs lacks.
// Where programs must compile together with their kernel, the text of a part is empty, and
// `feedback` is the reason.
GpuCode compileGpuPipeline(const GpuPipelineRequest& request);

constexpr const char* kGraphConstant = "sunstone_gpu_graph"; // a devlib::GraphKind
constexpr const char* kMotionConstant = "sunstone_gpu_motion";
// A constant of the run-time in this request; 0 if the request does not set it.
uint32_t constantOf(const GpuPipelineRequest& request, std::string_view name);

// Whether warps of the pipeline's kernel traverse in step if it is that of devlib/gpu/nested.h and
// closest-hit or miss programs trace.
bool mayWalkInStep(const GpuPipelineRequest& request);

// The key of the code: a digest of all its inputs.
std::string keyOf(const GpuPipelineRequest& request);
// The same for a kernel of the library, which has a unique name.
std::string keyOf(const GpuTarget& target, std::string_view kernel);

// False if the store has no value or an unreadable one. Either the text or the machine code of the
// result is empty.
bool findGpuPipeline(const std::string& key, ObjectStore& store, GpuCode& code);
// Stores the text only if there is no machine code.
void keepGpuPipeline(const std::string& key, const GpuCode& code, ObjectStore& store);

// Takes the frame sizes from the log of the driver's compiler, if it has them.
void measureGpuStack(GpuCode& code, std::string_view log);

} // namespace sunstone::compiler
