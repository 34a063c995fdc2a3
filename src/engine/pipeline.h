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
    int payloadType = -1; // of the module's types, that the program is made for; -1: untyped
    explicit operator bool() const { return module != nullptr; }
};

struct ProgramGroup {
    uint32_t number = 0; // unique in its context
    devlib::GroupKind kind = devlib::kGroupRaygen;
    std::array<ProgramRef, devlib::kRoleCount> programs; // by devlib::Role
    uint32_t builtinPrimitive = 0; // OptixPrimitiveType of a built-in intersection
};

// Chooses the payload type of a group's programs: `wanted`, or if that is null the one type that all
// of them support. Throws kPayloadTypeMismatch, kPayloadTypeResolution. Programs without payload
// (ray generation, callables, exception) and of modules without payload types are left alone.
void choosePayloadType(ProgramGroup& group, const compiler::PayloadType* wanted);

// Writes the 32-byte header of a shader-binding-table record.
void packSbtHeader(const ProgramGroup& group, void* header);

// Bytes of stack that a program takes with the functions it calls and the way into the run-time:
// measured from its machine code, which is compiled for that if need be. An
// estimate where the module refers to other modules, which only a pipeline knows, and for GPUs.
unsigned stackSizeOf(const ProgramRef& program);

// Frames of the run-time between a program that traces, or calls a callable, and the next program.
constexpr unsigned kRuntimeFrames = 128;

struct PipelineLimits {
    unsigned maxTraceDepth = 1;
    unsigned maxGraphDepth = devlib::kMaxGraphDepth; // until it is set, no path is too long
    // With stack-overflow exceptions, what a launch index may use in all. Sizes below those that
    // are right for traces of full depth and callables two deep count as these.
    unsigned directStackFromTraversal = 0;
    unsigned directStackFromState = 0;
    unsigned continuationStack = 0;
    bool opacityMicromaps = false; // rays look at them
};

// Limits that one thread sets while others launch.
class SharedLimits {
public:
    PipelineLimits get() const {
        std::lock_guard lock(mutex_);
        return limits_;
    }
    // `change` gets the limits, which nothing else reads or writes meanwhile.
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
    std::string feedback;                    // what the compiler has to say
    // By group number, from the pipeline's first, as contexts number groups and pipelines use few.
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
    mutable cpu::Pace pace; // of launches on the CPU
};

// Compiles the programs of all groups; what tasks of their modules or the context's cache have
// is taken from there. `flavor`: of the programs; null: OptiX 7. Throws kLinkError, kInvalidValue,
// kInternal.
std::shared_ptr<Pipeline> createPipeline(Context& context,
                                         const std::vector<std::shared_ptr<ProgramGroup>>& groups,
                                         const compiler::PipelineRules& rules,
                                         const PipelineLimits& limits,
                                         const compiler::Flavor* flavor = nullptr);

} // namespace sunstone::engine
