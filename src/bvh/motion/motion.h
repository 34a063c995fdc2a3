// SPDX-License-Identifier: Apache-2.0
// The place of a time among motion keys. Small and always inline: included by files compiled for
// different instruction sets.
//
// Keys divide the time range [begin, end] evenly. Before the range the first key applies, after it
// the last key. A NaN time, or a time in an empty range, counts as before the end.
#pragma once

#include "base/inline.h"
#include "bvh/layout.h"

namespace sunstone::bvh {

// Two neighbouring keys and the place between them: value = (1 - fraction) * at(key) +
// fraction * at(key + 1). With one key, fraction is 0 and the next key must not be read.
struct KeySegment {
    uint32_t key;   // 0 .. keys - 2
    float fraction; // 0 .. 1
};

SUNSTONE_INLINE KeySegment keySegment(uint32_t keys, float begin, float end, float time) {
    const float last = float(keys) - 1.0f;
    float t = (time - begin) * last / (end - begin);
    if (begin == end && time > end)
        t = last;
    t = t > 0.0f ? (t < last ? t : last) : 0.0f;
    if (!(last > 0.0f))
        return {0, 0.0f};
    const uint32_t key = uint32_t(t) < keys - 1 ? uint32_t(t) : keys - 2;
    return {key, t - float(key)};
}

SUNSTONE_INLINE KeySegment keySegment(const BlockHeader& header, float time) {
    return keySegment(header.motionKeys, header.motionBegin, header.motionEnd, time);
}

// Whether the vanish flags hide an object with this range at this time.
SUNSTONE_INLINE bool hasVanished(uint32_t flags, float begin, float end, float time) {
    return ((flags & kStartVanish) && time < begin) || ((flags & kEndVanish) && time > end);
}

// Interpolates a number between two keys, for transforms, boxes and the geometry of ray tests. Each
// operation is monotone, so geometry within bounds at both keys is within the interpolated bounds.
SUNSTONE_INLINE float between(float a, float b, float fraction) {
    return a * (1.0f - fraction) + b * fraction;
}

// Interpolate geometry that programs read, with the bits of the driver's library: vertices of
// triangles, and points and radii of curves and spheres. Ray tests do not use these functions,
// because processors may lack the fused operation.
SUNSTONE_INLINE float vertexBetween(float a, float b, float fraction) {
    return __builtin_fmaf(1.0f - fraction, a, fraction * b);
}
SUNSTONE_INLINE float pointBetween(float a, float b, float fraction) {
    return __builtin_fmaf(fraction, b - a, a);
}

} // namespace sunstone::bvh
