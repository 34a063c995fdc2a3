// SPDX-License-Identifier: Apache-2.0
// Events of a launch that are logged. Callers that log them run a NotedLaunch.
#pragma once

#include "devlib/abi.h"

namespace sunstone::devlib {

// Set by any thread, read after the launch.
struct LaunchNotes {
    uint32_t deepGraph = 0; // a path of traversables was longer than declared
    uint32_t wideSbt = 0;   // kFlagDebug: an SBT offset or stride of a trace call was above 15
    // A ray met an object that the pipeline's options exclude, and ignored it.
    uint32_t outsideFlags = 0; // excluded by the graph flags
    uint32_t motion = 0;       // a moving object, and rays have no times
    uint64_t unknown = 0;      // a handle that leads to no traversable

    void add(const LaunchNotes& other) {
        deepGraph |= other.deepGraph;
        wideSbt |= other.wideSbt;
        outsideFlags |= other.outsideFlags;
        motion |= other.motion;
        unknown = unknown ? unknown : other.unknown;
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
inline void note(T& what, T value = 1) {
    __atomic_store_n(&what, value, __ATOMIC_RELAXED);
}

} // namespace sunstone::devlib
