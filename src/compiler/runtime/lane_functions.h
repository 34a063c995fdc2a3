// SPDX-License-Identifier: Apache-2.0
// The functions of the run-time at which a lane depends on the other lanes of its warp, one row for
// each ptx::Lockstep. The translator calls them for the opcodes that say so in their row
// (ptx/opcodes/opcode_table.h); the lockstep code of a kernel recognises them by name.
// compiler/runtime/kernel.cpp defines the functions.
#pragma once

#include "ptx/opcodes/opcode.h"

#include <llvm/ADT/StringRef.h>

namespace sunstone::compiler {

struct LaneFunction {
    enum Effect : uint8_t {
        kMeets,  // a meeting point: the lanes of lockstep code leave it and enter again
        kEnds,   // the thread does not continue
        kAsks,   // the result is the same for all lanes that call it together
        kFrames, // asks for the thread's own frames, which lockstep code does not have
        kWaits,  // returns without a result if no thread can be switched to
    };
    // What the kernel's launcher must be able to do.
    enum Needs : uint8_t {
        kNothing,
        kWarp,    // run the lanes of a warp together
        kThreads, // switch between threads, and end one
    };
    const char* name;
    ptx::Lockstep lockstep;
    Effect effect;
    Needs needs;
    uint32_t kind; // of the meeting point, devlib::LockstepKind
    uint32_t mode; // of a pause; other points have theirs in an argument
};

// The row of a column's value; throws kInternal for ptx::Lockstep::kAlone.
const LaneFunction& laneFunction(ptx::Lockstep lockstep);
// Null for other names.
const LaneFunction* findLaneFunction(llvm::StringRef name);

inline bool isMeeting(llvm::StringRef name) {
    const LaneFunction* function = findLaneFunction(name);
    return function && function->effect == LaneFunction::kMeets;
}
inline bool endsThread(llvm::StringRef name) {
    const LaneFunction* function = findLaneFunction(name);
    return function && function->effect == LaneFunction::kEnds;
}

} // namespace sunstone::compiler
