// SPDX-License-Identifier: Apache-2.0
// What a launch did that is worth a line in the log. Whoever wants to know runs a NotedLaunch.
#pragma once

#include "devlib/abi.h"

namespace sunstone::devlib {

// Set by any thread, read when the launch is over.
struct LaunchNotes {
    uint32_t deepGraph = 0; // a path of traversables was longer than declared
    uint32_t wideSbt = 0;   // kFlagDebug: an SBT offset or stride of a trace call was above 15
};

// In LaunchState::exceptionFlags: the state is part of a NotedLaunch.
constexpr uint32_t kHasNotes = 1u << 31;

struct NotedLaunch : LaunchState {
    mutable LaunchNotes notes;
};

// Null where nobody wants to know.
inline LaunchNotes* notesOf(const LaunchState& launch) {
    return launch.exceptionFlags & kHasNotes ? &static_cast<const NotedLaunch&>(launch).notes
                                             : nullptr;
}
inline void note(uint32_t& what) {
    __atomic_store_n(&what, 1, __ATOMIC_RELAXED);
}

} // namespace sunstone::devlib
