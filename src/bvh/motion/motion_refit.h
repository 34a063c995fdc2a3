// SPDX-License-Identifier: Apache-2.0
// Fills a structure with motion keys: the primitives in its leaves at all keys, then the boxes
// above them key by key. Builds run it after the tree is made, updates run it again.
#pragma once

#include "bvh/motion/motion_input.h"
#include "bvh/refit/refit.h"

namespace sunstone::bvh {

// For a structure of instances: the bounds of instance i at key k are at [i * keys + k], empty if
// it is inactive.
struct InstanceMotion {
    KeyBounds* bounds = nullptr;
    bool read = true; // fill records and bounds from the input; else they are already filled
};

// Sets planes, leaves, instance records, key bounds, and bounds, root and numActive of the header.
void refitMotion(uint8_t* block, const Sources& sources, const MotionReader& reader,
                 const InstanceMotion& instances);

// Fills the record of an instance and its bounds at the keys; false if it is inactive.
bool describeMovingInstance(const InstanceDesc& from, uint32_t index, OpenLevels levels,
                            const MotionOptions& motion, InstanceRecord& to, KeyBounds* keys);

} // namespace sunstone::bvh
