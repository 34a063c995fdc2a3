// SPDX-License-Identifier: Apache-2.0
// Bounds over time of the objects behind traversable handles, for builds of instances.
#pragma once

#include "bvh/input/build_input.h"
#include "bvh/motion/motion_bounds_body.h"

namespace sunstone::bvh {

// Whether a transform between the handle and the first structure, or that structure, has motion.
bool moves(uint64_t handle);

// Bounds of a box through a motion transform, at all times.
Box boundsOfMotion(uint64_t transform, const Box& child);

// The bounds of an instance at each key of its structure, such that interpolation between them, and
// the outermost ones before and after, contain the instance at all times. `record` comes from
// describeInstance, which found the instance active.
void describeMotion(const InstanceRecord& record, const MotionOptions& motion, KeyBounds* keys);

} // namespace sunstone::bvh
