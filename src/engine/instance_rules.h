// SPDX-License-Identifier: Apache-2.0
// What the API demands of instances and builds do not look at, because the instances are in device
// memory and nothing bad comes of it: limits, reserved bits, flags that exclude each other.
// Validation mode has builds check it.
#pragma once

#include "bvh/build.h"

#include <cstdint>
#include <string>

namespace sunstone::engine {

struct InstanceRules {
    uint32_t maxId = 0;
    uint32_t maxSbtOffset = 0;
    uint32_t visibilityMaskBits = 0;
    uint32_t knownFlags = 0;
};

// Says which rule the first instance breaks that breaks one; empty: none does. Reads the instances.
std::string brokenRule(const bvh::InstanceInput& input, const InstanceRules& rules);

} // namespace sunstone::engine
