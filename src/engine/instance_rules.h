// SPDX-License-Identifier: Apache-2.0
// What the API demands of instances and builds do not look at, because the instances are in device
// memory and nothing bad comes of it: limits, reserved bits, flags that exclude each other.
// Validation mode has builds check it.
#pragma once

#include "bvh/build/build.h"

#include <cstdint>
#include <string>

namespace sunstone::engine {

struct Context;

struct InstanceRules {
    static constexpr uint64_t kAlignment = 16; // of each instance, OPTIX_INSTANCE_BYTE_ALIGNMENT
    uint32_t maxId = 0;
    uint32_t maxSbtOffset = 0;
    uint32_t visibilityMaskBits = 0;
    uint32_t knownFlags = 0;
};

// Logs which rule the first instance breaks that breaks one. Reads the instances.
void warnOfBrokenRule(const Context& context, const bvh::InstanceInput& input,
                      const InstanceRules& rules);

} // namespace sunstone::engine
