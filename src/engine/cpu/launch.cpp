// SPDX-License-Identifier: Apache-2.0
// Launches on the CPU: worker threads take tiles of launch indices and run the entry program for each
// index. Exceptions of device programs leave through longjmp.
#include "engine/launch.h"

#include "base/error.h"
#include "base/faults.h"
#include "base/readable.h"
#include "base/threads.h"
#include "check/memory_check.h"
#include "compiler/debug/place.h"
#include "devlib/flags.h"
#include "devlib/launch_notes.h"
#include "devlib/records.h"
#include "devlib/trace.h"
#include "engine/cpu/backend.h"
#include "engine/exceptions.h"

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <unwind.h>
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

// The program of a record, checked against the pipeline and the expected kind.
devlib::ProgramFn programAt(const Pipeline& pipeline, const Wording& wording, uint64_t record,
                            devlib::GroupKind kind, const char* what) {
    devlib::SbtHeader header;
    if (!isReadable(reinterpret_cast<const void*>(record), sizeof(header)))
        fail(Code::kLaunchFailure, what, " record at ", reinterpret_cast<const void*>(record),
             " is not in readable memory");
    std::memcpy(&header, reinterpret_cast<const void*>(record), sizeof(header));
    if (header.magic != devlib::kSbtMagic)
        fail(Code::kLaunchFailure, what, " record at ", reinterpret_cast<const void*>(record),
             " has no header packed by ", wording.packedBy);
    const uint32_t number = header.group - pipeline.firstGroup;
    if (number >= pipeline.groups.size() || pipeline.groups[number].kind == 0)
        fail(Code::kLaunchFailure, what, " record at ", reinterpret_cast<const void*>(record),
             " names program group ", header.group, ", which is not part of the pipeline");
    if (pipeline.groups[number].kind != kind)
        fail(Code::kLaunchFailure, what, " record at ", reinterpret_cast<const void*>(record),
             " holds a program group of another kind");
    return pipeline.groups[number].program(devlib::kRoleMain);
}

// Leaves the current launch index: the launch loop's frame takes over. The transform list at the
// fault moves to where the exception program, which runs with the launch index's own state, looks
// for it.
[[noreturn]] void leave(RayState* state, int32_t code, const void* returnAddress) {
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
    auto* const frame = static_cast<FaultFrame*>(thread->exceptionFrame);
    frame->instruction = static_cast<const char*>(returnAddress) - 1; // in the call
    longjmp(frame->jump, 1);
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
    leave(state, code, __builtin_return_address(0));
}

// Where the innermost compiled program called the run-time.
const void* callOfProgram() {
    const void* found = nullptr;
    _Unwind_Backtrace(
        [](_Unwind_Context* context, void* data) {
            const auto address = reinterpret_cast<const void*>(_Unwind_GetIP(context));
            if (!compiler::isLoadedCode(address))
                return _URC_NO_REASON;
            *static_cast<const void**>(data) = address;
            return _URC_END_OF_STACK;
        },
        &found);
    return found;
}

// An exception of the run-time.
void raise(RayState* state, int32_t code, const devlib::ExceptionInfo* info) {
    ThreadState* thread = state->thread;
    std::fill(std::begin(thread->exceptionDetails), std::end(thread->exceptionDetails), 0);
    thread->exception = info ? *info : devlib::ExceptionInfo{};
    const void* place = __builtin_return_address(0);
    const bool isFatal = !(state->launch->exceptionFlags & devlib::kFlagStackOverflow);
    if (code == devlib::kExceptionStackOverflow && isFatal)
        if (const void* call = callOfProgram())
            place = call;
    leave(state, code, place);
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
    Runner(const LaunchState& launch, devlib::ProgramFn entry, devlib::ProgramFn exception,
           uint64_t stackBudget, const Wording& wording)
        : launch_(launch), entry_(entry), exception_(exception), stackBudget_(stackBudget),
          fatal_(wording), raised_(wording), unseen_(wording) {}

    // Runs the indices of one tile. No object with a destructor lives here: exceptions of device
    // programs leave through longjmp.
    void run(const Tile& tile) {
        ThreadState thread{};
        FaultFrame frame;
        thread.exceptionFrame = &frame;
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
        const void* data = reinterpret_cast<const void*>(launch_.sbt.entryRecord +
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
            if (launch_.boxes)
                devlib::prepareBounds(state);
            entry_(&state);
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
            fatal_.add(*state.thread, launch_, frame.instruction);
            return;
        }
        if (code < 0)
            raised_.add(*state.thread, launch_, frame.instruction);
        if (!exception_) {
            unseen_.add(*state.thread, launch_, frame.instruction);
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
    devlib::ProgramFn entry_;
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

// What the log shall say of a launch that went well.
std::vector<std::string> remarks(const LaunchRequest& request, const Wording& wording,
                                 const devlib::LaunchNotes& notes) {
    std::vector<std::string> lines;
    if (notes.deepGraph)
        lines.push_back(wording.deepGraph(request.limits.maxGraphDepth));
    if (notes.wideSbt)
        lines.push_back(wording.wideRecordOffset);
    if (notes.outsideFlags)
        lines.push_back(wording.excludedGraph);
    if (notes.motion)
        lines.push_back(wording.excludedMotion);
    return lines;
}

void runLaunch(const LaunchRequest& request, const Wording& wording,
               std::vector<std::string>& warnings) {
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
    launch.firstGroup = pipeline.firstGroup;
    launch.groupCount = uint32_t(pipeline.groups.size());
    launch.boxes = request.boxes;
    launch.firstPrimitive = request.firstPrimitive;
    launch.motionStep = request.motionStep;
    launch.attributeBytes = pipeline.rules.optix6.attributeBytes;
    launch.entryKind = request.entryKind;
    launch.exceptionFlags = pipeline.rules.exceptionFlags | devlib::kHasNotes;
    launch.hasAnyHit = pipeline.hasAnyHit;
    launch.opacityMicromaps = request.limits.opacityMicromaps;
    launch.motion = pipeline.rules.motionBlur;
    launch.traversableGraphFlags = pipeline.rules.traversableGraphFlags;
    launch.primitiveTypeFlags = pipeline.rules.primitiveTypeFlags;
    launch.maxGraphDepth = request.limits.maxGraphDepth;
    launch.numAttributes = pipeline.rules.optix7.numAttributeValues;
    launch.paramsBytes = params.size();
    if (check::enabled())
        launch.checkMemory = checkMemory;
    launch.throwException = throwException;
    launch.raise = raise;
    devlib::TraceFeatures features;
    features.anyHit = pipeline.hasAnyHit;
    features.custom = pipeline.hasIntersection;
    features.instancing = pipeline.rules.traversableGraphFlags != devlib::kAllowSingleGas;
    features.checked = launch.exceptionFlags & devlib::kFlagDebug;
    features.classic = pipeline.rules.optix6.attributeBytes != 0;
    devlib::bindTrace(launch, features);

    const bool isBounds = request.entryKind == devlib::kGroupBounds;
    const devlib::ProgramFn entry =
        programAt(pipeline, wording, request.sbt.entryRecord, request.entryKind,
                  isBounds ? "bounds program" : "ray generation");
    devlib::ProgramFn exception = nullptr;
    if (request.sbt.exceptionRecord)
        exception = programAt(pipeline, wording, request.sbt.exceptionRecord,
                              devlib::kGroupException, "exception");

    Tiling tiling(request.width, request.height, request.depth);
    Runner runner(launch, entry, exception, stackBudget(request), wording);
    parallelFor(tiling.count(), 1, [&](size_t begin, size_t end) {
        prepareForFaults();
        for (size_t i = begin; i < end; ++i)
            runner.run(Tile(tiling, i));
    });
    const std::string unseen = runner.finish(request.validation);
    if (!unseen.empty())
        warnings.push_back("no exception program saw: " + unseen);
    for (std::string& line : remarks(request, wording, launch.notes))
        warnings.push_back(std::move(line));
}

} // namespace

void cpu::launch(const ContextPtr& context, const LaunchRequest& request) {
    check::start();
    context->device->enqueue(request.stream, [context, request] {
        beginReadableEpoch();
        try {
            std::vector<std::string> warnings;
            runLaunch(request, *context->wording, warnings);
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
