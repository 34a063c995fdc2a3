// SPDX-License-Identifier: Apache-2.0
// Events of a launch that are logged. Callers that log them run a NotedLaunch.
#pragma once

#include "devlib/abi.h"

#include <type_traits>

namespace sunstone::devlib {

// Set by any thread, read after the launch.
struct LaunchNotes {
    uint32_t deepGraph = 0; // a path of traversables was longer than declared
    uint32_t deepTrace = 0; // a ray was traced below maxTraceDepth
    uint32_t wideSbt = 0;   // kFlagDebug: an SBT offset or stride of a trace call was above 15
    // A ray met an object that the pipeline's options exclude, and ignored it.
    uint32_t outsideFlags = 0; // excluded by the graph flags
    uint32_t motion = 0;       // a moving object, and rays have no times
    uint64_t unknown = 0;      // a handle that leads to no traversable
    uint64_t record = 0;       // a recordNote of a record that is missing or wrong

    void add(const LaunchNotes& other) {
        deepGraph |= other.deepGraph;
        wideSbt |= other.wideSbt;
        outsideFlags |= other.outsideFlags;
        motion |= other.motion;
        deepTrace |= other.deepTrace;
        unknown = unknown ? unknown : other.unknown;
        record = record ? record : other.record;
    }
};

// In LaunchState::exceptionFlags: the state is part of a NotedLaunch.
constexpr uint32_t kHasNotes = 1u << 31;

struct NotedLaunch : LaunchState {
    mutable LaunchNotes notes;
};

// Null if no caller logs it.
inline LaunchNotes* notesOf(const LaunchState& launch) {
    return launch.exceptionFlags & kHasNotes ? &static_cast<const NotedLaunch&>(launch).notes
                                             : nullptr;
}
template <class T>
[[gnu::noinline, gnu::cold]] inline void note(const LaunchState& launch, T LaunchNotes::* what,
                                              std::type_identity_t<T> value = 1) {
    if (LaunchNotes* notes = notesOf(launch); notes && value != 0)
        __atomic_store_n(&(notes->*what), value, __ATOMIC_RELAXED);
}

} // namespace sunstone::devlib
