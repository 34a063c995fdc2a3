// SPDX-License-Identifier: Apache-2.0
// Program groups and pipelines. A pipeline owns its machine code and a table from group number to
// program addresses; groups and modules may be destroyed after it was made.
#pragma once

#include "engine/cpu/pace.h"
#include "engine/module.h"

#include <array>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::engine {

struct ProgramRef {
    std::shared_ptr<const Module> module; // null: no such program
    std::string function;
    compiler::ProgramKind kind = compiler::ProgramKind::kNone;
    int payloadType = -1; // index into the module's types; -1: untyped
    explicit operator bool() const { return module != nullptr; }
};

struct ProgramGroup {
    uint32_t number = 0; // unique in its context
    devlib::GroupKind kind = devlib::kGroupRaygen;
    std::array<ProgramRef, devlib::kRoleCount> programs; // by devlib::Role
    uint32_t builtinPrimitive = 0; // OptixPrimitiveType of a built-in intersection
};

// Sets the payload type of a group's programs: `wanted`, or if that is null the one type that all
// of them support. Throws kPayloadTypeMismatch, kPayloadTypeResolution. Programs without payload
// (ray generation, callables, exception) and of modules without payload types are left unchanged.
void choosePayloadType(ProgramGroup& group, const compiler::PayloadType* wanted);

// Writes the 32-byte header of a shader-binding-table record.
void packSbtHeader(const ProgramGroup& group, void* header);

// Bytes of stack for a program, the functions that it calls and the way into the run-time, measured
// from its machine code, which is compiled for this if necessary. An estimate for GPUs, and where
// the module refers to other modules, which only a pipeline knows.
unsigned stackSizeOf(const ProgramRef& program);

// Frames of the run-time between a program that traces, or calls a callable, and the next program.
constexpr unsigned kRuntimeFrames = 128;

struct PipelineLimits {
    unsigned maxTraceDepth = 1;
    unsigned maxGraphDepth = devlib::kMaxGraphDepth; // until it is set, no path is too long
    // With stack overflow exceptions: bytes that a launch index may use in total. The minimum is
    // the need of traces of full depth and callables two deep.
    unsigned directStackFromTraversal = 0;
    unsigned directStackFromState = 0;
    unsigned continuationStack = 0;
    bool opacityMicromaps = false; // rays test them
};

// Limits that one thread sets while others launch.
class SharedLimits {
public:
    PipelineLimits get() const {
        std::lock_guard lock(mutex_);
        return limits_;
    }
    // Calls `change` with the limits while no other thread reads or writes them.
    template <class Change>
    void update(const Change& change) {
        std::lock_guard lock(mutex_);
        change(limits_);
    }

private:
    mutable std::mutex mutex_;
    PipelineLimits limits_;
};

struct Pipeline {
    std::unique_ptr<compiler::Code> code;    // for the CPU; null where there is no program
    std::shared_ptr<DeviceCode> deviceCode;  // for a GPU
    std::string feedback;                    // messages of the compiler
    // By group number from the pipeline's first, because a pipeline uses few groups of its context.
    std::vector<devlib::GroupEntry> groups;
    uint32_t firstGroup = 0;
    compiler::PipelineRules rules;
    SharedLimits limits;          // as set
    PipelineLimits defaultLimits; // stack sizes that the programs need
    uint64_t launchParamsSize = 0;          // 0: no program uses the variable
    std::vector<compiler::BoundValue> boundValues; // of all modules
    std::vector<std::string> callableNames;        // GroupEntry points to them
    bool hasAnyHit = false;
    bool hasIntersection = false;
    bool mayWaitForOthers = false; // see compiler::ModuleSummary
    mutable cpu::Pace pace; // of launches on the CPU
};

// Compiles the programs of all groups, except code that tasks of their modules or the context's
// cache have. `flavor`: of the programs; null: OptiX 7. Throws kLinkError, kInvalidValue,
// kInternal.
std::shared_ptr<Pipeline> createPipeline(Context& context,
                                         const std::vector<std::shared_ptr<ProgramGroup>>& groups,
                                         const compiler::PipelineRules& rules,
                                         const PipelineLimits& limits,
                                         const compiler::Flavor* flavor = nullptr);

} // namespace sunstone::engine
