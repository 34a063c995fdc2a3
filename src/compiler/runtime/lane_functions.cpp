// SPDX-License-Identifier: Apache-2.0
// See lane_functions.h.
#include "compiler/runtime/lane_functions.h"

#include "base/error.h"
#include "devlib/lockstep.h"

namespace sunstone::compiler {

namespace {

using F = LaneFunction;
using L = ptx::Lockstep;

// clang-format off
constexpr LaneFunction kLaneFunctions[] = {
    // name                    opcode's column   effect      launcher      kind                  mode
    {"sunstone_barrier",       L::kBarrier,      F::kMeets,  F::kThreads,  devlib::kMeetBarrier, 0},
    {"sunstone_vote",          L::kVote,         F::kMeets,  F::kWarp,     devlib::kMeetVote,    0},
    {"sunstone_shuffle",       L::kShuffle,      F::kMeets,  F::kWarp,     devlib::kMeetShuffle, 0},
    {"sunstone_match",         L::kMatch,        F::kMeets,  F::kWarp,     devlib::kMeetMatch,   0},
    {"sunstone_redux",         L::kReduce,       F::kMeets,  F::kWarp,     devlib::kMeetReduce,  0},
    {"sunstone_matrix",        L::kMatrix,       F::kMeets,  F::kWarp,     devlib::kMeetMatrix,  0},
    {"sunstone_spin",          L::kSpin,         F::kMeets,  F::kNothing,  devlib::kMeetPause,   1},
    {"sunstone.pause",         L::kPause,        F::kMeets,  F::kNothing,  devlib::kMeetPause,   0},
    {"sunstone_activemask",    L::kActiveLanes,  F::kAsks,   F::kWarp,     0,                    0},
    {"sunstone_mbarrier_wait", L::kWait,         F::kWaits,  F::kThreads,  0,                    0},
    {"sunstone_is_local_of_kernel", L::kFrames,  F::kFrames, F::kNothing,  0,                    0},
    {"sunstone_exit",          L::kExit,         F::kEnds,   F::kThreads,  0,                    0},
    {"sunstone_trap",          L::kTrap,         F::kEnds,   F::kThreads,  0,                    0},
    {"sunstone_assertion",     L::kAssertion,    F::kEnds,   F::kNothing,  0,                    0},
};
// clang-format on

} // namespace

const LaneFunction& laneFunction(ptx::Lockstep lockstep) {
    for (const LaneFunction& each : kLaneFunctions)
        if (each.lockstep == lockstep)
            return each;
    fail(Code::kInternal, "no function of the run-time for lockstep behaviour ",
         unsigned(lockstep));
}

const LaneFunction* findLaneFunction(llvm::StringRef name) {
    if (!name.starts_with("sunstone"))
        return nullptr;
    for (const LaneFunction& each : kLaneFunctions)
        if (name == each.name)
            return &each;
    return nullptr;
}

} // namespace sunstone::compiler
