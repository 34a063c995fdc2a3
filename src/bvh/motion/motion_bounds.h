// SPDX-License-Identifier: Apache-2.0
// Bounds of what handles lead to while it moves: what structures of instances are built from.
#pragma once

#include "bvh/input/build_input.h"
#include "bvh/motion/motion_bounds_body.h"

namespace sunstone::bvh {

// Bounds of what the handle leads to, in its space, that hold at all times of [begin, end].
LinearBounds linearBounds(uint64_t handle, double begin, double end);

// Whether something on the way from the handle to the first structure, or that itself, moves.
bool moves(uint64_t handle);

// Bounds of what a motion transform makes of a box, at all times.
Box boundsOfMotion(uint64_t transform, const Box& child);

// The bounds of an instance at each key of its structure, such that what lies between them, and
// stands before and after them, holds the instance at all times. `record` comes from
// describeInstance, which found the instance active.
void describeMotion(const InstanceData& record, const MotionOptions& motion, KeyBounds* keys);

} // namespace sunstone::bvh
