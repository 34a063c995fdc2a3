// SPDX-License-Identifier: Apache-2.0
// The payload of both modules of mixed_shapes.
#pragma once

#include "mixed_shapes.h"
#include "tools.h"

DEVICE MixedHit* mixedHit() {
    return reinterpret_cast<MixedHit*>(static_cast<unsigned long long>(optixGetPayload_1()) << 32 |
                                       optixGetPayload_0());
}
DEVICE const MixedRecord* mixedRecord() {
    return reinterpret_cast<const MixedRecord*>(optixGetSbtDataPointer());
}
// `normal` in the space of the object.
DEVICE void setMixedHit(float3 normal, float3 color) {
    MixedHit* const hit = mixedHit();
    hit->distance = optixGetRayTmax();
    hit->point = rayPoint();
    hit->normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(normal)));
    hit->color = color;
}
