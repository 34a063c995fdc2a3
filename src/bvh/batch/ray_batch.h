// SPDX-License-Identifier: Apache-2.0
// Rays and hits as arrays in the caller's memory: their formats, and functions that read a ray and
// write a hit. The code compiles for CPUs and as CUDA. Read next: batch.h, bvh/gpu/batch/batches.h.
#pragma once

#include "base/inline.h"

#include <cstdint>

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh {

enum class RayFormat : uint32_t {
    kOriginDirection,         // 6 floats; the ray is tested from 0 to infinity
    kOriginTminDirectionTmax, // 8 floats
    kOriginMaskDirectionTmax, // the same with a mask in the place of tmin, which is 0
};

enum class HitFormat : uint32_t {
    kBit,                 // a bit for each ray: whether it meets a triangle
    kT,                   // float, negative without a hit
    kTTriangle,           // and the triangle, ~0 without a hit
    kTTriangleUv,         // and u at vertex 1, v at vertex 2
    kTTriangleInstance,   // t, triangle, instance
    kTTriangleInstanceUv, // t, triangle, instance, u, v
};

constexpr uint32_t rayBytes(RayFormat format) {
    return format == RayFormat::kOriginDirection ? 24 : 32;
}
// kBit: 0.
constexpr uint32_t hitBytes(HitFormat format) {
    return format == HitFormat::kBit                 ? 0
           : format == HitFormat::kT                 ? 4
           : format == HitFormat::kTTriangle         ? 8
           : format == HitFormat::kTTriangleUv       ? 16
           : format == HitFormat::kTTriangleInstance ? 12
                                                     : 20;
}

// Pointers are device addresses.
struct RayBatch {
    uint64_t rays = 0, hits = 0;
    uint64_t handle = 0; // of a structure of triangles, or of instances of such structures
    // Masks of triangles, one uint32_t each; for a structure of instances, the address of such
    // masks for each instance. 0: none. A ray with a mask meets only triangles whose mask has a
    // common bit.
    uint64_t masks = 0;
    uint64_t count = 0;
    RayFormat rayFormat = RayFormat::kOriginTminDirectionTmax;
    HitFormat hitFormat = HitFormat::kTTriangleUv;
    uint32_t firstBit = 0; // of kBit: place of the first ray's bit in the byte at `hits`
    uint32_t pad = 0;
};

// The first eight members are in the order of kOriginTminDirectionTmax.
struct BatchRay {
    float origin[3];
    float tmin;
    float direction[3];
    float tmax;
    uint32_t mask;
};

struct BatchHit {
    float t; // negative: no hit
    uint32_t triangle, instance;
    float u, v;
};

constexpr BatchHit kNoBatchHit = {-1.0f, ~0u, ~0u, 0.0f, 0.0f};

// A negative tmin counts as 0, because a negative t stands for a miss.
SUNSTONE_INLINE float startOf(float tmin) {
    return tmin < 0 ? 0.0f : tmin;
}

SUNSTONE_INLINE BatchRay readRay(const RayBatch& batch, uint64_t index) {
    BatchRay ray;
    ray.mask = ~0u;
    if (batch.rayFormat == RayFormat::kOriginDirection) {
        const float* const from = reinterpret_cast<const float*>(batch.rays) + 6 * index;
        for (int i = 0; i < 3; ++i) {
            ray.origin[i] = from[i];
            ray.direction[i] = from[3 + i];
        }
        ray.tmin = 0;
        ray.tmax = __builtin_inff();
        return ray;
    }
    const float* const from = reinterpret_cast<const float*>(batch.rays) + 8 * index;
    for (int i = 0; i < 3; ++i) {
        ray.origin[i] = from[i];
        ray.direction[i] = from[4 + i];
    }
    ray.tmax = from[7];
    if (batch.rayFormat == RayFormat::kOriginTminDirectionTmax) {
        ray.tmin = startOf(from[3]);
    } else {
        ray.tmin = 0;
        ray.mask = __builtin_bit_cast(uint32_t, from[3]);
    }
    return ray;
}

// Any format but kBit.
SUNSTONE_INLINE void writeHit(const RayBatch& batch, uint64_t index, const BatchHit& hit) {
    float* const to = reinterpret_cast<float*>(batch.hits) + hitBytes(batch.hitFormat) / 4 * index;
    const auto store = [to](uint32_t place, uint32_t word) {
        reinterpret_cast<uint32_t*>(to)[place] = word;
    };
    to[0] = hit.t;
    switch (batch.hitFormat) {
    case HitFormat::kTTriangleUv:
        store(1, hit.triangle);
        to[2] = hit.u;
        to[3] = hit.v;
        break;
    case HitFormat::kTTriangle:
        store(1, hit.triangle);
        break;
    case HitFormat::kTTriangleInstance:
        store(1, hit.triangle);
        store(2, hit.instance);
        break;
    case HitFormat::kTTriangleInstanceUv:
        store(1, hit.triangle);
        store(2, hit.instance);
        to[3] = hit.u;
        to[4] = hit.v;
        break;
    default:
        break;
    }
}

} // namespace sunstone::bvh

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
