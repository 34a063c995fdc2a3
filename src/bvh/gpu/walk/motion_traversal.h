// SPDX-License-Identifier: Apache-2.0
// Nodes and triangles of structures with motion keys at the time of a ray, between two keys (curves
// and spheres: walk/ray_shapes.h).
//
// Planes of a node, each on its key's grid, are interpolated with the weights of the vertices below
// them. Between the keys, boxes contain their children except for rounding: interpolated vertices
// have an error of up to 2^-22 of the largest coordinate in the structure, and weights whose sum is
// not 1 move the origin by 2^-25 of it; `slack` is twice the sum. ray_node.h describes the test of
// a node. Here a plane takes two multiply-adds, each with a 1 to subtract, whose errors together
// are below 2^-6 of a grid step.
#pragma once

#include "bvh/gpu/motion.h"
#include "bvh/gpu/walk/ray_node.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

// The place of a ray's time among a structure's keys. keys: 1 without motion.
struct MotionPlace {
    uint32_t keys = 1;
    uint32_t key;
    float first, second; // weights of that key and of the next one
    float slack;
};

SUNSTONE_INLINE bool isGone(const BlockHeader& header, float time) {
    return hasVanished(header.motionFlags, header.motionBegin, header.motionEnd, time);
}

SUNSTONE_INLINE MotionPlace placeIn(const BlockHeader& header, float time, const float origin[3]) {
    MotionPlace place;
    if (!isMoving(header.type))
        return {1, 0, 1, 0, 0};
    const KeySegment at = keySegment(header, time);
    place.keys = header.motionKeys;
    place.key = at.key;
    place.first = sub(1.0f, at.fraction);
    place.second = at.fraction;
    float largest = 0, away = 0;
    for (int i = 0; i < 3; ++i) {
        largest = larger(largest, larger(magnitude(header.lower[i]), magnitude(header.upper[i])));
        away = larger(away, magnitude(origin[i]));
    }
    place.slack = fused(largest, 0x1p-21f, mul(away, 0x1p-23f));
    return place;
}

// The grid of a node at one key, and its planes as ray parameters: value * scale + constant.
struct KeyGrid {
    float scale[3], from[3];
    U4 planes0, planes1, planes2;
};

// Adds a key's grid to the constants and to the distance of the node's farthest corner.
SUNSTONE_INLINE void addGrid(const U4* node, U4 head, const float origin[3], const BoxRay& ray,
                             float weight, KeyGrid& grid, float constant[3], float margin[3],
                             float& reach) {
    grid.planes0 = loadConstant(node + 2);
    grid.planes1 = loadConstant(node + 3);
    grid.planes2 = loadConstant(node + 4);
    const float step[3] = {floatOf((head.w & 0xFFu) << 23), floatOf((head.w & 0xFF00u) << 15),
                           floatOf((head.w & 0xFF0000u) << 7)};
    const float from[3] = {sub(floatOf(head.x), origin[0]), sub(floatOf(head.y), origin[1]),
                           sub(floatOf(head.z), origin[2])};
    for (int i = 0; i < 3; ++i) {
        reach = larger(reach, fused(255.0f, step[i], magnitude(from[i])));
        const float speed = mul(ray.inverse[i], weight);
        const float s = mul(step[i], speed);
        grid.scale[i] = mul(s, 0x1p15f);
        margin[i] = fused(magnitude(s), 0x1p-6f, margin[i]);
        constant[i] = add(constant[i], fused(from[i], speed, -grid.scale[i]));
    }
}

// testNode (ray_node.h) for a node with a WideNode for each key; `node` is the WideNode of
// place.key. A node without motion is allowed, too.
template <bool kDistances>
SUNSTONE_INLINE void testMovingNode(const U4* node, const MotionPlace& place, const float origin[3],
                                    const BoxRay& ray, float tmin, float tmax, Group& inner,
                                    Group& leaf, Distances<kDistances>& distances) {
    const U4* const next = node + (place.keys > 1 ? sizeof(WideNode) / 16 : 0);
    const U4 head = loadConstant(node), children = loadConstant(node + 1);
    float constant[3] = {0, 0, 0}, margin[3] = {0, 0, 0}, reach = 0;
    KeyGrid a, b;
    addGrid(node, head, origin, ray, place.first, a, constant, margin, reach);
    addGrid(next, loadConstant(next), origin, ray, place.second, b, constant, margin, reach);
    const float slack = fused(reach, ray.slack, place.slack);
    float nearC[3], farC[3];
    for (int i = 0; i < 3; ++i) {
        const float m = fused(magnitude(ray.inverse[i]), slack, margin[i]);
        nearC[i] = sub(constant[i], m);
        farC[i] = add(constant[i], m);
    }
    const uint32_t one = bitsOf(ray.one);
    const bool down[3] = {ray.inverse[0] < 0, ray.inverse[1] < 0, ray.inverse[2] < 0};
    uint32_t hits = 0;
#pragma unroll
    for (int half = 0; half < 2; ++half) {
        // Bytes of four children: near and far planes of x, y, z at each key.
        uint32_t near[2][3], far[2][3];
        for (int k = 0; k < 2; ++k) {
            const KeyGrid& g = k ? b : a;
            const uint32_t low[3] = {half ? g.planes0.y : g.planes0.x,
                                     half ? g.planes0.w : g.planes0.z,
                                     half ? g.planes1.y : g.planes1.x};
            const uint32_t high[3] = {half ? g.planes1.w : g.planes1.z,
                                      half ? g.planes2.y : g.planes2.x,
                                      half ? g.planes2.w : g.planes2.z};
            for (int i = 0; i < 3; ++i) {
                near[k][i] = down[i] ? high[i] : low[i];
                far[k][i] = down[i] ? low[i] : high[i];
            }
        }
        const Slots slots(half ? children.w : children.z, ray.octant);
#pragma unroll
        for (uint32_t k = 0; k < 4; ++k) {
            const uint32_t selector = 0x7604u | k << 4;
            const auto plane = [&](uint32_t first, uint32_t second, int i, float c) {
                return orderedInt(
                    fused(floatOf(permute(first, one, selector)), a.scale[i],
                          fused(floatOf(permute(second, one, selector)), b.scale[i], c)));
            };
            // As integers, see testNode.
            int32_t begin = orderedInt(tmin), end = orderedInt(tmax);
            for (int i = 0; i < 3; ++i) {
                const int32_t in = plane(near[0][i], near[1][i], i, nearC[i]),
                              out = plane(far[0][i], far[1][i], i, farC[i]);
                begin = begin > in ? begin : in;
                end = end < out ? end : out;
            }
            if (begin <= end)
                hits |= slots.hit(k);
            distances.set(4 * uint32_t(half) + k, begin <= end, begin);
        }
    }
    distances.metas[0] = children.z;
    distances.metas[1] = children.w;
    setGroups(head, children, hits, inner, leaf);
}

// Interpolates a number between the keys, as bvh::between.
SUNSTONE_INLINE float weighted(float a, float b, const MotionPlace& place) {
    return add(mul(a, place.first), mul(b, place.second));
}

// Loads a triangle between two keys; `record` is the record of place.key.
SUNSTONE_INLINE void loadMovingTriangle(const U4* record, const MotionPlace& place, U4& a, U4& b,
                                        U4& c) {
    constexpr uint32_t kNext = sizeof(TriangleRecord) / 16;
    const auto between = [&](uint32_t vertex) {
        const U4 from = loadConstant(record + vertex), to = loadConstant(record + kNext + vertex);
        const auto one = [&](uint32_t x, uint32_t y) {
            return bitsOf(weighted(floatOf(x), floatOf(y), place));
        };
        return U4{one(from.x, to.x), one(from.y, to.y), one(from.z, to.z), from.w};
    };
    a = between(0);
    b = between(1);
    c = between(2);
}

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
