// SPDX-License-Identifier: Apache-2.0
// Launches on the CPU: worker threads take tiles of launch indices and run the entry program for
// each index. Exceptions of device programs leave through longjmp.
#include "engine/launch.h"

#include "base/error.h"
#include "base/faults.h"
#include "base/readable.h"
#include "base/threads/threads.h"
#include "check/memory_check.h"
#include "compiler/debug/place.h"
#include "devlib/flags.h"
#include "devlib/launch_notes.h"
#include "devlib/records.h"
#include "devlib/trace.h"
#include "engine/cpu/backend.h"
#include "engine/cpu/in_flight.h"
#include "engine/cpu/runner.h"
#include "engine/exceptions.h"

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <ctime>
#include <unwind.h>
#include <vector>

namespace sunstone::engine {
namespace {

using cpu::Runner;
using cpu::Tile;
using cpu::Tiling;
using devlib::LaunchState;
using devlib::RayState;
using devlib::ThreadState;

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

// Leaves the current launch index by a jump to the launch loop's frame. The exception program runs
// with the launch index's own state, so the transform list at the fault is copied there.
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

// The address at which the innermost compiled program called the run-time.
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
    const auto rangeOf = [](const auto& array) {
        const auto begin = reinterpret_cast<uint64_t>(&array);
        return check::Range{begin, begin + sizeof array};
    };
    scene.launchIndex = rangeOf(thread.index);
    scene.launchDimensions = rangeOf(state->launch->dimensions);
    if (check::examine(*access, scene) != check::Fault::kNone)
        raise(state, devlib::kExceptionAccess, nullptr);
}

// Bytes of stack for a launch index. Only pipelines with stack overflow exceptions have a limit
// below the thread's stack.
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

// Sets the members that programs and the run-time read, except parameters and trace functions.
void describe(LaunchState& launch, const LaunchRequest& request) {
    const Pipeline& pipeline = *request.pipeline;
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
    if (check::enabled())
        launch.checkMemory = checkMemory;
    launch.throwException = throwException;
    launch.raise = raise;
}

devlib::TraceFeatures featuresOf(const Pipeline& pipeline) {
    devlib::TraceFeatures features;
    features.anyHit = pipeline.hasAnyHit;
    features.custom = pipeline.hasIntersection;
    features.instancing = pipeline.rules.traversableGraphFlags != devlib::kAllowSingleGas;
    features.checked = pipeline.rules.exceptionFlags & devlib::kFlagDebug;
    features.classic = pipeline.rules.optix6.attributeBytes != 0;
    return features;
}

// Whether launch indices may run side by side. With debug exceptions and in the classic API each
// walk may run programs or raise. An index that waits for another one, which is at its trace, would
// wait for ever if the same thread ran both.
bool mayKeepInFlight(const LaunchRequest& request, const devlib::TraceFeatures& features,
                     const Tiling& tiling, cpu::WishedWay wish) {
    // Smaller launches end before both ways have been measured.
    constexpr uint64_t kLeastTiles = 32;
    const bool fits = wish == cpu::WishedWay::kInFlight ||
                      (wish == cpu::WishedWay::kFaster && tiling.count() >= kLeastTiles);
    return fits && !features.checked && !features.classic && !check::enabled() &&
           !request.pipeline->mayWaitForOthers && request.entryKind == devlib::kGroupRaygen;
}

uint64_t nanoseconds() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return uint64_t(now.tv_sec) * 1'000'000'000 + uint64_t(now.tv_nsec);
}

// Runs the tiles from `begin` to before `end` in this way if possible; returns the way used.
cpu::Way runPiece(Runner& runner, const cpu::InFlightLaunch& inFlight, const Tiling& tiling,
                  cpu::Way way, uint64_t begin, uint64_t end) {
    if (way == cpu::Way::kInFlight && cpu::runInFlight(runner, inFlight, tiling, begin, end))
        return way;
    for (uint64_t i = begin; i < end; ++i)
        runner.run(Tile(tiling, i));
    return cpu::Way::kAlone;
}

// Runs the tiles from `begin` to before `end` in pieces, each in the way that measurements favour.
// `forced`: all pieces in flight.
void runTiles(Runner& runner, const cpu::InFlightLaunch& inFlight, cpu::Pace& pace,
              const Tiling& tiling, bool forced, uint64_t begin, uint64_t end) {
    constexpr uint64_t kPiece = 8;
    for (uint64_t first = begin; first < end; first += kPiece) {
        const uint64_t last = std::min(first + kPiece, end);
        const cpu::Pace::Plan plan =
            forced ? cpu::Pace::Plan{false, cpu::Way::kInFlight} : pace.next();
        if (!plan.isMeasured) {
            runPiece(runner, inFlight, tiling, plan.way, first, last);
            continue;
        }
        const auto measure = [&](cpu::Way way, uint64_t from, uint64_t to) {
            const uint64_t counted = from + (to - from) / 2;
            if (counted != from)
                runPiece(runner, inFlight, tiling, way, from, counted);
            const uint64_t start = nanoseconds();
            way = runPiece(runner, inFlight, tiling, way, counted, to);
            pace.add(way, (to - counted) * cpu::kTileRow, nanoseconds() - start);
        };
        const uint64_t middle = first + (last - first) / 2;
        const bool isAlone = plan.way == cpu::Way::kAlone;
        if (middle != first)
            measure(plan.way, first, middle);
        measure(isAlone ? cpu::Way::kInFlight : cpu::Way::kAlone, middle, last);
    }
}

// Returns lines for the log.
std::vector<LaunchRemark> runLaunch(const LaunchRequest& request, const Wording& wording) {
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
    launch.paramsBytes = params.size();
    describe(launch, request);
    const devlib::TraceFeatures features = featuresOf(pipeline);
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
    devlib::NotedLaunch waiting = launch;
    waiting.trace = cpu::traceInFlight;
    const cpu::InFlightLaunch inFlight = {waiting, devlib::selectTrace(features).traceBatch};
    const cpu::WishedWay wish = cpu::wishedWay();
    const bool mayWait = mayKeepInFlight(request, features, tiling, wish);
    const bool forced = wish == cpu::WishedWay::kInFlight;
    parallelFor(tiling.count(), 1, [&](size_t begin, size_t end) {
        prepareForFaults();
        if (mayWait)
            return runTiles(runner, inFlight, pipeline.pace, tiling, forced, begin, end);
        for (size_t i = begin; i < end; ++i)
            runner.run(Tile(tiling, i));
    });
    launch.notes.add(waiting.notes);
    const std::string unseen = runner.finish(request.validation);
    std::vector<LaunchRemark> remarks = remarksOf(launch.notes, launch, wording);
    if (!unseen.empty())
        remarks.push_back({LogLevel::kWarning, "no exception program saw: " + unseen});
    return remarks;
}

} // namespace

void cpu::launch(const ContextPtr& context, const LaunchRequest& request) {
    check::start();
    context->device->enqueue(request.stream, [context, request] {
        beginReadableEpoch();
        try {
            for (const auto& [level, text] : runLaunch(request, *context->wording))
                if (context->log)
                    context->log(level, "LAUNCH", text);
        } catch (const Error& error) {
            if (context->log)
                context->log(LogLevel::kError, "LAUNCH", error.what());
            throw;
        }
    });
}

} // namespace sunstone::engine
