// SPDX-License-Identifier: Apache-2.0
#include "engine/launch.h"

#include "base/error.h"
#include "base/faults.h"
#include "base/readable.h"
#include "base/threads.h"
#include "check/memory_check.h"
#include "devlib/launch_notes.h"
#include "devlib/trace.h"
#include "engine/cpu_backend.h"
#include "engine/exceptions.h"

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace sunstone::engine {
namespace {

using devlib::LaunchState;
using devlib::RayState;
using devlib::ThreadState;

// Shapes of a tile: square ones keep neighbouring rays together; one-dimensional launches take
// the same number of indices in a row.
constexpr uint32_t kTileSide = 16;
constexpr uint32_t kTileRow = kTileSide * kTileSide;

struct Tiling {
    uint32_t width, height, depth;
    uint32_t tileWidth, tileHeight;
    uint64_t columns, rows;

    Tiling(uint32_t w, uint32_t h, uint32_t d) : width(w), height(h), depth(d) {
        tileWidth = h == 1 ? kTileRow : kTileSide;
        tileHeight = h == 1 ? 1 : kTileSide;
        columns = (uint64_t(w) + tileWidth - 1) / tileWidth;
        rows = (uint64_t(h) + tileHeight - 1) / tileHeight;
    }
    uint64_t count() const { return columns * rows * depth; }
};

struct Tile {
    uint32_t x, y, z, width, height;
    uint32_t count() const { return width * height; }

    Tile(const Tiling& tiling, uint64_t number) {
        x = uint32_t(number % tiling.columns) * tiling.tileWidth;
        number /= tiling.columns;
        y = uint32_t(number % tiling.rows) * tiling.tileHeight;
        z = uint32_t(number / tiling.rows);
        width = std::min(tiling.tileWidth, tiling.width - x);
        height = std::min(tiling.tileHeight, tiling.height - y);
    }
};

// The group a record belongs to, checked against the pipeline and the expected kind.
const devlib::GroupEntry& entryOf(const Pipeline& pipeline, uint64_t record,
                                  devlib::GroupKind kind, const char* what) {
    devlib::SbtHeader header;
    if (!isReadable(reinterpret_cast<const void*>(record), sizeof(header)))
        fail(Code::kLaunchFailure, what, " record at ", reinterpret_cast<const void*>(record),
             " is not in readable memory");
    std::memcpy(&header, reinterpret_cast<const void*>(record), sizeof(header));
    if (header.magic != devlib::kSbtMagic)
        fail(Code::kLaunchFailure, what, " record at ", reinterpret_cast<const void*>(record),
             " has no header packed by optixSbtRecordPackHeader");
    if (header.group >= pipeline.groups.size() || !pipeline.groupPresent[header.group])
        fail(Code::kLaunchFailure, what, " record at ", reinterpret_cast<const void*>(record),
             " names program group ", header.group, ", which is not part of the pipeline");
    if (pipeline.groupKinds[header.group] != kind)
        fail(Code::kLaunchFailure, what, " record at ", reinterpret_cast<const void*>(record),
             " holds a program group of another kind");
    return pipeline.groups[header.group];
}

// Leaves the current launch index: the launch loop's frame takes over. The transform list at the
// fault moves to where the exception program, which runs with the launch index's own state, looks
// for it.
[[noreturn]] void leave(RayState* state, int32_t code) {
    ThreadState* thread = state->thread;
    thread->exceptionCode = code;
    RayState* root = thread->root;
    if (root != state) {
        const devlib::Hit& hit = state->hit;
        const uint32_t count = std::min(hit.transformCount, devlib::kMaxGraphDepth);
        root->hit.transformCount = count;
        std::copy_n(hit.transforms, count, root->hit.transforms);
        root->hit.sbtGasIndex = hit.sbtGasIndex;
    }
    longjmp(*static_cast<jmp_buf*>(thread->exceptionFrame), 1);
}

// A `trap` or optixThrowException.
void throwException(RayState* state, int32_t code, uint32_t count, const uint32_t* details) {
    ThreadState* thread = state->thread;
    for (uint32_t i = 0; i < 8; ++i)
        thread->exceptionDetails[i] = i < count ? details[i] : 0;
    thread->exception = {};
    thread->exception.line = thread->line;
    constexpr int32_t kUserCodes = 1 << 30;
    if (code != devlib::kExceptionTrap && uint32_t(code) >= uint32_t(kUserCodes)) {
        if (state->launch->exceptionFlags & devlib::kFlagDebug)
            code = devlib::kExceptionInvalidArgument0;
        else
            code &= kUserCodes - 1; // never taken for a code of the run-time
    }
    leave(state, code);
}

// An exception of the run-time.
void raise(RayState* state, int32_t code, const devlib::ExceptionInfo* info) {
    ThreadState* thread = state->thread;
    std::fill(std::begin(thread->exceptionDetails), std::end(thread->exceptionDetails), 0);
    thread->exception = info ? *info : devlib::ExceptionInfo{};
    leave(state, code);
}

// Before an access of a program compiled for the memory checker.
void checkMemory(RayState* state, const devlib::CheckedAccess* access) {
    check::Scene scene;
    const ThreadState& thread = *state->thread;
    std::copy_n(thread.index, 3, scene.thread);
    const auto params = reinterpret_cast<uint64_t>(state->launch->params);
    scene.params = {params, params + state->launch->paramsBytes};
    scene.stack = check::stackOfThread();
    if (check::examine(*access, scene) != check::Fault::kNone)
        raise(state, devlib::kExceptionAccess, nullptr);
}

class Runner {
public:
    Runner(const LaunchState& launch, devlib::ProgramFn raygen, devlib::ProgramFn exception,
           uint64_t stackBudget)
        : launch_(launch), raygen_(raygen), exception_(exception), stackBudget_(stackBudget) {}

    // Runs the indices of one tile. No object with a destructor lives here: exceptions of device
    // programs leave through longjmp.
    void run(const Tile& tile) {
        ThreadState thread{};
        FaultFrame frame;
        thread.exceptionFrame = &frame.jump;
        RayState state;
        std::memset(static_cast<void*>(&state), 0, offsetof(RayState, hit));
        state.hit.transformCount = 0;
        state.hit.sbtGasIndex = 0;
        state.launch = &launch_;
        state.thread = &thread;
        thread.root = &state;
        thread.stackLimit = stackLimitOfThread();
        // Not the address of a variable: sanitizers keep those elsewhere.
        const auto here = reinterpret_cast<uint64_t>(__builtin_frame_address(0));
        if (here > stackBudget_)
            thread.stackLimit = std::max(thread.stackLimit, here - stackBudget_);
        const void* data = reinterpret_cast<const void*>(launch_.sbt.raygenRecord +
                                                         sizeof(devlib::SbtHeader));
        volatile uint32_t next = 0;
        volatile bool ending = false; // an exception program may raise exceptions itself
        const int reason = setjmp(frame.jump);
        if (reason != 0) {
            leaveDeviceCode();
            if (reason == kJumpFault) {
                fatal_.add(frame, thread, launch_);
            } else if (!ending) {
                ending = true;
                endIndex(state, frame);
            }
            ending = false;
            next = next + 1;
        }
        enterDeviceCode(frame);
        for (uint32_t i = next; i < tile.count(); ++i) {
            next = i;
            thread.index[0] = tile.x + i % tile.width;
            thread.index[1] = tile.y + i / tile.width;
            thread.index[2] = tile.z;
            state.sbtData = data;
            state.depth = 0;
            raygen_(&state);
        }
        leaveDeviceCode();
    }

    // Throws what a device program ended the launch with, if one did. `validation`: exceptions of
    // the run-time count as well. Otherwise returns what no exception program has seen.
    std::string finish(bool validation) const {
        if (fatal_.any())
            fail(Code::kLaunchFailure, fatal_.text());
        if (validation && raised_.any())
            fail(Code::kLaunchFailure, raised_.text());
        return unseen_.any() ? unseen_.text() : std::string();
    }

private:
    // What follows an exception: the exception program, or where there can be none the end of the
    // launch.
    void endIndex(RayState& state, FaultFrame& frame) {
        const int32_t code = state.thread->exceptionCode;
        const bool overflow = code == devlib::kExceptionStackOverflow &&
                              !(launch_.exceptionFlags & devlib::kFlagStackOverflow);
        if (code == devlib::kExceptionTrap || code == devlib::kExceptionAccess || overflow) {
            fatal_.add(*state.thread, launch_);
            return;
        }
        if (code < 0)
            raised_.add(*state.thread, launch_);
        if (!exception_) {
            unseen_.add(*state.thread, launch_);
            return;
        }
        state.sbtData = reinterpret_cast<const void*>(launch_.sbt.exceptionRecord +
                                                      sizeof(devlib::SbtHeader));
        state.depth = 0;
        enterDeviceCode(frame);
        exception_(&state);
        leaveDeviceCode();
    }

    const LaunchState& launch_;
    devlib::ProgramFn raygen_;
    devlib::ProgramFn exception_;
    uint64_t stackBudget_; // bytes that a launch index may use
    ExceptionRecord fatal_;  // ends the launch
    ExceptionRecord raised_; // by the run-time
    ExceptionRecord unseen_; // without an exception program
};

// Bytes of stack for a launch index: the thread's stack alone limits it, unless overflows are to be
// exceptions.
uint64_t stackBudget(const LaunchRequest& request) {
    if (!(request.pipeline->rules.exceptionFlags & devlib::kFlagStackOverflow))
        return ~uint64_t(0);
    constexpr uint64_t kTraversal = 128 << 10; // below any-hit and intersection programs
    const PipelineLimits &set = request.limits, &least = request.pipeline->defaultLimits;
    const auto larger = [](unsigned a, unsigned b) { return uint64_t(std::max(a, b)); };
    return kTraversal + larger(set.directStackFromTraversal, least.directStackFromTraversal) +
           larger(set.directStackFromState, least.directStackFromState) +
           larger(set.continuationStack, least.continuationStack);
}

} // namespace

void checkBoundValues(const Pipeline& pipeline, const uint8_t* params) {
    for (const compiler::BoundValue& value : pipeline.boundValues) {
        const uint64_t end = value.offset + value.bytes.size();
        if (end > pipeline.launchParamsSize)
            continue;
        for (size_t i = 0; i < value.bytes.size(); ++i)
            if (params[value.offset + i] != value.bytes[i])
                fail(Code::kLaunchFailure, "byte ", value.offset + i,
                     " of the launch parameters is ", unsigned(params[value.offset + i]),
                     ", but bound value \"", value.annotation, "\" says ",
                     unsigned(value.bytes[i]));
    }
}

namespace {

// What the log shall say of a launch that went well.
std::vector<std::string> remarks(const LaunchRequest& request, const devlib::LaunchNotes& notes) {
    std::vector<std::string> lines;
    if (notes.deepGraph)
        lines.push_back(deepGraphRemark(request.limits.maxGraphDepth));
    if (notes.wideSbt)
        lines.push_back(wideSbtRemark());
    return lines;
}

void runLaunch(const LaunchRequest& request, std::vector<std::string>& warnings) {
    const Pipeline& pipeline = *request.pipeline;
    devlib::NotedLaunch launch{};
    // Reads beyond the caller's block see zeros; 64 bytes allow vector loads at the end.
    std::vector<uint8_t> params((pipeline.launchParamsSize + 127) / 64 * 64);
    if (pipeline.launchParamsSize != 0 && request.params)
        std::memcpy(params.data(), request.params,
                    std::min(request.paramsSize, pipeline.launchParamsSize));
    if (request.validation)
        checkBoundValues(pipeline, params.data());
    launch.params = params.data();
    launch.dimensions[0] = request.width;
    launch.dimensions[1] = request.height;
    launch.dimensions[2] = request.depth;
    launch.maxTraceDepth = request.limits.maxTraceDepth;
    launch.sbt = request.sbt;
    launch.groups = pipeline.groups.data();
    launch.groupCount = uint32_t(pipeline.groups.size());
    launch.exceptionFlags = pipeline.rules.exceptionFlags | devlib::kHasNotes;
    launch.hasAnyHit = pipeline.hasAnyHit;
    launch.opacityMicromaps = request.limits.opacityMicromaps;
    launch.traversableGraphFlags = pipeline.rules.traversableGraphFlags;
    launch.primitiveTypeFlags = pipeline.rules.primitiveTypeFlags;
    launch.maxGraphDepth = request.limits.maxGraphDepth;
    launch.numAttributes = pipeline.rules.numAttributeValues;
    launch.paramsBytes = params.size();
    if (check::enabled())
        launch.checkMemory = checkMemory;
    launch.throwException = throwException;
    launch.raise = raise;
    devlib::TraceFeatures features;
    features.anyHit = pipeline.hasAnyHit;
    features.custom = pipeline.hasIntersection;
    features.instancing = pipeline.rules.traversableGraphFlags != 1; // SINGLE_GAS alone
    features.checked = launch.exceptionFlags & devlib::kFlagDebug;
    devlib::bindTrace(launch, features);

    const devlib::GroupEntry& raygen =
        entryOf(pipeline, request.sbt.raygenRecord, devlib::kGroupRaygen, "ray generation");
    devlib::ProgramFn exception = nullptr;
    if (request.sbt.exceptionRecord)
        exception = entryOf(pipeline, request.sbt.exceptionRecord, devlib::kGroupException,
                            "exception").main;

    Tiling tiling(request.width, request.height, request.depth);
    Runner runner(launch, raygen.main, exception, stackBudget(request));
    parallelFor(tiling.count(), 1, [&](size_t begin, size_t end) {
        prepareForFaults();
        for (size_t i = begin; i < end; ++i)
            runner.run(Tile(tiling, i));
    });
    const std::string unseen = runner.finish(request.validation);
    if (!unseen.empty())
        warnings.push_back("no exception program saw: " + unseen);
    for (std::string& line : remarks(request, launch.notes))
        warnings.push_back(std::move(line));
}

} // namespace

void launch(const std::shared_ptr<Context>& context, const LaunchRequest& request) {
    context->backend->launch(context, request);
}

void cpu::launch(const ContextPtr& context, const LaunchRequest& request) {
    check::start();
    context->device->enqueue(request.stream, [context, request] {
        beginReadableEpoch();
        try {
            std::vector<std::string> warnings;
            runLaunch(request, warnings);
            for (const std::string& line : warnings)
                if (context->log)
                    context->log(LogLevel::kWarning, "LAUNCH", line);
        } catch (const Error& error) {
            if (context->log)
                context->log(LogLevel::kError, "LAUNCH", error.what());
            throw;
        }
    });
}

} // namespace sunstone::engine
