// SPDX-License-Identifier: Apache-2.0
// Rules of the API for instances that builds do not check, because the instances are in device
// memory and violations are harmless: limits, reserved bits, flags that exclude each other.
// Validation mode checks them in builds.
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

// Logs the first broken rule of the first instance that breaks one. Reads the instances.
void warnOfBrokenRule(const Context& context, const bvh::InstanceInput& input,
                      const InstanceRules& rules);

// Logs the first instance whose handle is none of a structure, or of transforms above one. Rays
// never hit it. `structure` is the built structure of these instances.
void warnOfUnknownChild(const Context& context, const bvh::InstanceInput& input,
                        const void* structure);

} // namespace sunstone::engine
