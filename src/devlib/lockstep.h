// SPDX-License-Identifier: Apache-2.0
// Kernels whose threads run a warp at a time: data shared by compiled code and its launcher.
//
// Beside the KernelFn of a single thread, a kernel can have a LockstepFn
// (compiler/lockstep/lockstep.h). In that form each value of the program is a vector with one
// element for each of the 32 lanes of a warp. One call runs the lanes of a mask from their point to
// the next one: a barrier, a warp function that needs other lanes, or the end. At a point the lanes
// store their operands in the warp and the values that they need later in its frame; the launcher
// decides which lanes continue, and with which result.
#pragma once

#include "devlib/abi.h"

namespace sunstone::devlib {

constexpr uint32_t kWarpLanes = 32;

// Kinds of points. LockstepWarp::point has the number of the point in the low half, the kind above
// it and the mode above that.
enum LockstepKind : uint32_t {
    kMeetBarrier = 1, // operands: id, threads; mode: BarrierReduction
    kMeetPlain,       // a barrier of the whole block without a value; mode: id
    kMeetVote,        // operands: mask; mode: 0 all, 1 any, 2 uniform, 3 ballot
    kMeetShuffle,     // operands: mask, distance, control; mode: 0 up, 1 down, 2 xor, 3 index
    kMeetMatch,       // operands: mask; mode: 1 all
    kMeetReduce,      // operands: mask; mode: the operation of sunstone_redux
    kMeetMatrix,      // operands: mask; value: address of the lane's compiler::MatrixBlock; mode: 0
    kMeetPause,       // no wait, other lanes may run first; mode: 1 if these have polled
                      // memory that others may write
};
constexpr uint32_t kPointBits = 16, kModeShift = 24;

struct alignas(64) LockstepWarp {
    uint32_t tid[3][kWarpLanes];
    uint32_t laneid[kWarpLanes];
    KernelThread* threads; // of the lanes; only the first is filled where info says so
    uint8_t* frame;        // values that live across points
    uint32_t live;         // lanes that have not ended
    uint32_t all;          // lanes of the block
    uint32_t namedEnded;   // lanes that warp functions named after their end
    // Of one call, set to 0 before it: the number of arrivals at points, the last point and its
    // lanes.
    uint32_t stops;
    uint32_t stopPoint;
    uint32_t stopLanes;
    // Of each waiting lane; pauses (mode 0) of all live lanes leave `point` unchanged.
    alignas(64) uint32_t point[kWarpLanes];
    uint32_t operand[3][kWarpLanes];
    uint64_t value[kWarpLanes];
    uint64_t result[kWarpLanes]; // its result at the point, as the functions of BlockFunctions'
                                 // users in compiler/runtime/kernel.cpp return it
};

// Runs those of `lanes`, all at `point` (0: the beginning), that can run together; returns the
// lanes that ran, at least one.
using LockstepFn = uint32_t (*)(LockstepWarp*, const void* params, uint32_t point, uint32_t lanes);

} // namespace sunstone::devlib
