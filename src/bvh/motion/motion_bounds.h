// SPDX-License-Identifier: Apache-2.0
// Bounds over time of the objects behind traversable handles, for builds of instances.
#pragma once

#include "bvh/input/build_input.h"
#include "bvh/motion/motion_bounds_body.h"

namespace sunstone::bvh {

// Whether a transform between the handle and the first structure, or that structure, has motion.
bool moves(uint64_t handle);

// Bounds, at all times, of a box under a motion transform.
Box boundsOfMotion(uint64_t transform, const Box& child);

// Computes bounds of an instance at each key of its structure. Interpolated between keys, and
// constant before the first and after the last key, they contain the instance at all times.
// `record` comes from describeInstance; the instance is active.
void describeMotion(const InstanceRecord& record, const MotionOptions& motion, KeyBounds* keys);

} // namespace sunstone::bvh
