// SPDX-License-Identifier: Apache-2.0
// Refits a structure: reads its primitives again and computes the boxes above them from the leaves
// up. A leaf names its primitives: the SBT index gives the build input, the primitive index the
// primitive in it.
#pragma once

#include "bvh/input/build_input.h"

namespace sunstone::bvh {

// Readers for all inputs of a build; one of the three kinds is used.
struct Sources {
    std::vector<TriangleReader> triangles;
    std::vector<CustomReader> customs;
    const InstanceInput* instances;
    std::vector<SbtReader> sbt;

    explicit Sources(const BuildInputs& inputs);
};

// The block must have been built with kOptionUpdate from inputs of the same shape. Sets boxes,
// leaves, instance records, and bounds, root and numActive of the header.
void refit(uint8_t* block, const Sources& sources);

} // namespace sunstone::bvh
