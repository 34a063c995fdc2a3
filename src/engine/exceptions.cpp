// SPDX-License-Identifier: Apache-2.0
#include "engine/exceptions.h"

#include "base/error.h"
#include "check/memory_check.h"
#include "compiler/debug/place.h"

#include <algorithm>
#include <pthread.h>

namespace sunstone::engine {
namespace {

using namespace devlib;

const char* nameOf(int32_t code) {
    switch (code) {
    case kExceptionTrap: return "trap or a failed assertion";
    case kExceptionAccess: return "invalid access of memory";
    case kExceptionStackOverflow: return "stack overflow";
    case kExceptionTraceDepth: return "trace depth exceeded";
    case kExceptionTraversalDepth: return "traversal depth exceeded";
    case kExceptionInvalidTraversable: return "invalid traversable";
    case kExceptionInvalidMissSbt: return "no miss program group of the pipeline at the SBT index";
    case kExceptionInvalidHitSbt: return "no hit group of the pipeline at the SBT index";
    case kExceptionUnsupportedPrimitive: return "primitive type that the pipeline excludes";
    case kExceptionInvalidRay: return "infinity or NaN in a ray";
    case kExceptionParameterMismatch: return "callable called with wrong parameters";
    case kExceptionBuiltinIsMismatch: return "built-in intersection does not fit the structure";
    case kExceptionCallableInvalidSbt: return "callable SBT index out of range";
    case kExceptionNoDirectCallable: return "SBT record without direct callable";
    case kExceptionNoContinuationCallable: return "SBT record without continuation callable";
    case kExceptionUnsupportedSingleGas:
        return "geometry acceleration structure traced directly, which the pipeline excludes";
    case kExceptionInvalidArgument0: return "first argument out of range, or ray flags that exclude each other";
    case kExceptionInvalidArgument0 - 1: return "second argument out of range";
    case kExceptionInvalidArgument0 - 2: return "third argument out of range";
    case kExceptionUnsupportedDataAccess:
        return "structure was built without the random access flag";
    case kExceptionPayloadType: return "program has another payload type than the trace call";
    default: return "exception";
    }
}

std::string details(int32_t code, const ExceptionInfo& info) {
    switch (code) {
    case kExceptionInvalidTraversable:
    case kExceptionUnsupportedSingleGas:
        return message(", handle ", reinterpret_cast<const void*>(info.traversable));
    case kExceptionInvalidMissSbt:
    case kExceptionInvalidHitSbt:
    case kExceptionCallableInvalidSbt:
    case kExceptionNoDirectCallable:
    case kExceptionNoContinuationCallable:
        return message(", index ", info.sbtOffset);
    case kExceptionInvalidRay: {
        const float* r = info.ray;
        return message(", origin (", r[0], ", ", r[1], ", ", r[2], "), direction (", r[3], ", ",
                       r[4], ", ", r[5], "), tmin ", r[6], ", tmax ", r[7], ", time ", r[8]);
    }
    case kExceptionParameterMismatch:
        return message(", ", info.callableName ? info.callableName : "callable", " takes ",
                       info.expectedWords, " words and got ", info.passedWords, ", index ",
                       info.callableIndex);
    default:
        return {};
    }
}

std::string describeFaultInCode(const FaultFrame& fault) {
    std::string text = describeFault(fault);
    if (const std::string freed = check::describeFreed(fault.address); !freed.empty())
        text += " (" + freed + ")";
    return text + compiler::placeText(fault.instruction);
}

} // namespace

std::string describeException(const ThreadState& thread, const Wording& wording,
                              const void* instruction) {
    const int32_t code = thread.exceptionCode;
    const char* name = wording.exceptionName(code);
    if (!name)
        name = nameOf(code);
    std::string text = code >= 0 ? message("user exception ", code)
                                 
                                 : name + (code <= kExceptionAccess
                                                       ? std::string()
                                                       : message(" (exception ", code, ")")) +
                                       details(code, thread.exception);
    if (thread.exception.line)
        return text + message(", at ", thread.exception.line);
    return text + compiler::placeText(instruction);
}

std::vector<LaunchRemark> remarksOf(const LaunchNotes& notes, const LaunchState& launch,
                                    const Wording& wording) {
    std::vector<LaunchRemark> remarks;
    const auto add = [&](bool applies, auto text, LogLevel level = LogLevel::kWarning) {
        if (applies)
            remarks.push_back({level, text()});
    };
    add(notes.deepGraph, [&] { return wording.deepGraph(launch.maxGraphDepth); });
    add(notes.wideSbt, [&] { return wording.wideRecordOffset; });
    add(notes.outsideFlags, [&] { return wording.excludedGraph; });
    add(notes.motion, [&] { return wording.excludedMotion; });
    add(notes.unknown, [&] {
        return message(
            "a ray met the handle ", reinterpret_cast<const void*>(notes.unknown),
            ", which is no traversable or whose memory is freed; there is nothing to hit");
    });
    add(notes.deepTrace, [&] { return wording.deepTrace(launch.maxTraceDepth); }, LogLevel::kError);
    add(
        notes.record, [&] { return wording.missingRecord(notes.record, launch.sbt); },
        LogLevel::kError);
    return remarks;
}

uint64_t stackLimitOfThread() {
    static constexpr uint64_t kReserve = 384 << 10;
    thread_local const uint64_t limit = [] {
        pthread_attr_t attributes;
        void* lowest = nullptr;
        size_t size = 0;
        if (pthread_getattr_np(pthread_self(), &attributes) != 0)
            return uint64_t(0);
        pthread_attr_getstack(&attributes, &lowest, &size);
        pthread_attr_destroy(&attributes);
        return reinterpret_cast<uint64_t>(lowest) + std::min<uint64_t>(kReserve, size / 2);
    }();
    return limit;
}

void ExceptionRecord::add(const ThreadState& thread, const LaunchState& launch,
                          const void* instruction) {
    addWith([&] { return describeException(thread, wording_, instruction); }, thread, launch);
}

void ExceptionRecord::add(const FaultFrame& fault, const ThreadState& thread,
                          const LaunchState& launch) {
    addWith([&] { return describeFaultInCode(fault); }, thread, launch);
}

template <class Describe>
void ExceptionRecord::addWith(Describe describe, const ThreadState& thread,
                              const LaunchState& launch) {
    const uint32_t* index = thread.index;
    const uint64_t place =
        (uint64_t(index[2]) * launch.dimensions[1] + index[1]) * launch.dimensions[0] + index[0];
    any_ = true;
    if (place >= lowest_)
        return;
    std::lock_guard lock(mutex_);
    if (place >= lowest_)
        return;
    lowest_ = place;
    text_ = message(describe(), ", at launch index (", index[0], ", ", index[1],
                    ", ", index[2], ")");
}

} // namespace sunstone::engine
