// SPDX-License-Identifier: Apache-2.0
#include "bvh/motion/motion_bounds.h"

namespace sunstone::bvh {

bool moves(uint64_t handle) {
    return moving::moves(handle);
}

Box boundsOfMotion(uint64_t transform, const Box& child) {
    if (child.empty())
        return {};
    const float lower[3] = {child.lower.x, child.lower.y, child.lower.z},
                upper[3] = {child.upper.x, child.upper.y, child.upper.z};
    const KeyBounds b = moving::atAllTimes(transform, lower, upper);
    Box all;
    all.extend(Box{{b.lower[0], b.lower[1], b.lower[2]}, {b.upper[0], b.upper[1], b.upper[2]}});
    return all;
}

void describeMotion(const InstanceRecord& record, const MotionOptions& motion, KeyBounds* keys) {
    moving::describe(record, {motion.keys, motion.begin, motion.end}, keys);
}

} // namespace sunstone::bvh
