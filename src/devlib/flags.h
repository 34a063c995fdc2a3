// SPDX-License-Identifier: Apache-2.0
// Flags of rays, instances and graphs as OptiX 7 numbers them (OptixRayFlags, OptixInstanceFlags,
// OptixTraversableGraphFlags). Geometry flags: bvh/layout.h.
#pragma once

#include <cstdint>

namespace sunstone::devlib {

enum RayFlag : uint32_t {
    kRayDisableAnyHit = 1,
    kRayEnforceAnyHit = 2,
    kRayTerminateOnFirstHit = 4,
    kRayDisableClosestHit = 8,
    kRayCullBack = 16,
    kRayCullFront = 32,
    kRayCullDisabledAnyHit = 64,
    kRayCullEnforcedAnyHit = 128,
    kRayForceMicromap2State = 1024,
};

enum InstanceFlag : uint32_t {
    kInstanceDisableFaceCulling = 1,
    kInstanceFlipFacing = 2,
    kInstanceDisableAnyHit = 4,
    kInstanceEnforceAnyHit = 8,
    kInstanceForceMicromap2State = 16,
    kInstanceDisableMicromaps = 32,
};

enum GraphFlag : uint32_t { kAllowSingleGas = 1, kAllowSingleLevelInstancing = 2 };

} // namespace sunstone::devlib
