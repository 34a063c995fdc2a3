// SPDX-License-Identifier: Apache-2.0
// Primitives with motion keys: the test whether they are active, by the CPU's rules
// (bvh/motion/motion_input.h), their boxes for the tree, which are the means of the boxes at the
// keys, and their records.
#pragma once

#include "bvh/gpu/build/references.h"
#include "bvh/gpu/motion.h"

namespace sunstone::bvh::gpu {

// The union and the mean of a primitive's boxes at the keys.
struct KeySum {
    Bounds all;
    double lower[3], upper[3];
};
SUNSTONE_INLINE KeySum noKeys() {
    return {emptyBounds(), {0, 0, 0}, {0, 0, 0}};
}
SUNSTONE_INLINE void addKey(KeySum& sum, const Bounds& box) {
    sum.all = unite(sum.all, box);
    for (int a = 0; a < 3; ++a) {
        sum.lower[a] += box.lower[a];
        sum.upper[a] += box.upper[a];
    }
}
SUNSTONE_INLINE Bounds meanOf(const KeySum& sum, uint32_t keys) {
    Bounds mean;
    for (int a = 0; a < 3; ++a) {
        mean.lower[a] = float(sum.lower[a] / keys);
        mean.upper[a] = float(sum.upper[a] / keys);
    }
    return mean;
}

// The input as it is at a key.
SUNSTONE_INLINE DeviceInput atKey(const DeviceInput& input, uint32_t key) {
    DeviceInput here = input;
    if (input.keyData)
        here.data = at<const uint64_t>(input.keyData)[key];
    if (input.keyRadii)
        here.radii = at<const uint64_t>(input.keyRadii)[key];
    return here;
}

// As bvh::TriangleCheck: usable at all keys, with an area at one key or between two keys.
SUNSTONE_INLINE bool readMovingTriangle(const DeviceInput& input, uint32_t triangle, uint32_t keys,
                                        KeySum& sum) {
    float v[9], previous[9];
    bool area = false;
    for (uint32_t k = 0; k < keys; ++k) {
        if (!readVertices(atKey(input, k), triangle, v))
            return false;
        for (int i = 0; i < 9; ++i)
            if (!isUsable(v[i]))
                return false;
        area = area || hasArea(v);
        if (k > 0 && !area) {
            float middle[9];
            for (int i = 0; i < 9; ++i)
                middle[i] = mixVertex(previous[i], v[i], 0.5f);
            area = hasArea(middle);
        }
        addKey(sum, boundsOfTriangle(v));
        for (int i = 0; i < 9; ++i)
            previous[i] = v[i];
    }
    return area;
}

SUNSTONE_INLINE bool readMovingPrimitive(const BuildJob& job, InputPlace from, KeySum& sum) {
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[from.input];
    if (job.type == BlockType::kTriangles)
        return readMovingTriangle(input, from.primitive, job.motionKeys, sum);
    for (uint32_t k = 0; k < job.motionKeys; ++k) {
        Bounds box;
        if (!readCustom(atKey(input, k), from.primitive, box))
            return false;
        addKey(sum, box);
    }
    return true;
}

SUNSTONE_KERNEL sunstone_moving_references(BuildJob job) {
    Bounds found = emptyBounds();
    uint32_t numActive = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        KeySum sum = noKeys();
        const bool active = readMovingPrimitive(job, placeOfPrimitive(job, i), sum);
        storeBox(job, i, active, meanOf(sum, job.motionKeys));
        if (active) {
            found = unite(found, sum.all);
            ++numActive;
        }
    }
    countReferences(job, found, numActive);
}

// As writeRecord in finish.h; `exact` contains the primitive at all keys.
SUNSTONE_INLINE bool writeMovingRecord(const BuildJob& job, uint32_t place, InputPlace from,
                                       bool mayBeInactive, Bounds& exact) {
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[from.input];
    const InputRecord& record = at<const InputRecord>(job.inputRecords)[from.input];
    const uint32_t reported = from.primitive + record.primitiveIndexOffset;
    const uint32_t word = sbtWord(input, record, from.primitive);
    KeySum sum = noKeys();
    const bool active = !mayBeInactive || readMovingPrimitive(job, from, sum);
    exact = sum.all;
    U4* to = at<U4>(job.records + place * recordSize(job.type, job.shape, job.motionKeys));
    for (uint32_t key = 0; key < job.motionKeys; ++key) {
        const DeviceInput here = atKey(input, key);
        if (job.type == BlockType::kCustom) {
            Bounds b = emptyBounds();
            if (active)
                readCustom(here, from.primitive, b);
            to = storeCustom(to, b, reported, word);
            continue;
        }
        float v[9];
        if (active)
            readVertices(here, from.primitive, v);
        else
            for (float& x : v)
                x = __builtin_nanf("");
        to = storeTriangle(to, v, reported, word);
    }
    return active;
}

} // namespace sunstone::bvh::gpu
