// SPDX-License-Identifier: Apache-2.0
// First step of a build: the box of each primitive, and the bounds and number of active primitives.
// Vertices and the rules for active primitives are those of the CPU (bvh/input/build_input.h).
// Instances have their own kernels (instances.h), and so have primitives with motion keys
// (motion_references.h).
#pragma once

#include "bvh/build/build.h"
#include "bvh/gpu/device.h"

namespace sunstone::bvh::gpu {

constexpr float kLargestCoordinate = 0x1p100f;

SUNSTONE_INLINE bool isUsable(float a) {
    return a >= -kLargestCoordinate && a <= kLargestCoordinate;
}

// The build input of a primitive that is numbered over all inputs.
SUNSTONE_INLINE uint32_t inputOfPrimitive(const BuildJob& job, uint32_t primitive) {
    const InputRecord* const records = at<const InputRecord>(job.inputRecords);
    uint32_t low = 0, high = job.numInputs;
    while (high - low > 1) {
        const uint32_t middle = (low + high) / 2;
        if (records[middle].firstPrimitive <= primitive)
            low = middle;
        else
            high = middle;
    }
    return low;
}

// A primitive: its build input, and its number there.
struct InputPlace {
    uint32_t input, primitive;
};
SUNSTONE_INLINE InputPlace placeOfPrimitive(const BuildJob& job, uint32_t primitive) {
    const uint32_t input = inputOfPrimitive(job, primitive);
    return {input, primitive - at<const InputRecord>(job.inputRecords)[input].firstPrimitive};
}

// The SBT index and geometry flags of a primitive in a word.
SUNSTONE_INLINE uint32_t sbtWord(const DeviceInput& input, const InputRecord& record,
                                 uint32_t primitive) {
    uint32_t local = 0;
    const uint64_t address = input.sbtOffsets + uint64_t(primitive) * input.sbtOffsetStride;
    if (input.sbtOffsets && input.sbtOffsetSize)
        local = input.sbtOffsetSize == 1   ? *at<const uint8_t>(address)
                : input.sbtOffsetSize == 2 ? *at<const uint16_t>(address)
                                           : *at<const uint32_t>(address);
    local = local < record.numSbtRecords ? local : record.numSbtRecords - 1;
    return ((record.firstSbtIndex + local) & kSbtIndexMask) |
           uint32_t(at<const uint8_t>(input.flags)[local]) << kGeometryFlagShift;
}

// Write a record and return the place behind it.
SUNSTONE_INLINE U4* storeCustom(U4* to, const Bounds& b, uint32_t reported, uint32_t word) {
    to[0] = U4{bitsOf(b.lower[0]), bitsOf(b.lower[1]), bitsOf(b.lower[2]), reported};
    to[1] = U4{bitsOf(b.upper[0]), bitsOf(b.upper[1]), bitsOf(b.upper[2]), word};
    return to + sizeof(CustomLeaf) / 16;
}
SUNSTONE_INLINE U4* storeTriangle(U4* to, const float v[9], uint32_t reported, uint32_t word) {
    to[0] = U4{bitsOf(v[0]), bitsOf(v[1]), bitsOf(v[2]), reported};
    to[1] = U4{bitsOf(v[3]), bitsOf(v[4]), bitsOf(v[5]), word};
    to[2] = U4{bitsOf(v[6]), bitsOf(v[7]), bitsOf(v[8]), 0};
    return to + sizeof(TriangleRecord) / 16;
}

SUNSTONE_INLINE float halfToFloat(uint32_t h) {
    const uint32_t exponent = h >> 10 & 31u, mantissa = h & 0x3FFu;
    const float value = exponent == 31  ? floatOf(0x7F800000u | mantissa << 13)
                        : exponent == 0 ? mul(float(mantissa), 0x1p-24f)
                                        : floatOf((exponent + 112) << 23 | mantissa << 13);
    return h & 0x8000u ? -value : value;
}
SUNSTONE_INLINE float snormToFloat(uint32_t bits) {
    return larger(divide(float(int16_t(bits)), 32767.0f), -1.0f);
}

SUNSTONE_INLINE void readVertex(const DeviceInput& input, uint32_t index, float out[3]) {
    const uint64_t address = input.data + uint64_t(index) * input.stride;
    const auto format = VertexFormat(input.vertexFormat);
    out[2] = 0;
    if (format == VertexFormat::kFloat3 || format == VertexFormat::kFloat2) {
        const float* const v = at<const float>(address);
        out[0] = v[0];
        out[1] = v[1];
        if (format == VertexFormat::kFloat3)
            out[2] = v[2];
        return;
    }
    const uint16_t* const v = at<const uint16_t>(address);
    const bool half = format == VertexFormat::kHalf3 || format == VertexFormat::kHalf2;
    const uint32_t count =
        format == VertexFormat::kHalf3 || format == VertexFormat::kSnorm16x3 ? 3 : 2;
    for (uint32_t i = 0; i < count; ++i)
        out[i] = half ? halfToFloat(v[i]) : snormToFloat(v[i]);
}

// The vertices after the pre-transform; false if an index is out of range.
SUNSTONE_INLINE bool readVertices(const DeviceInput& input, uint32_t triangle, float v[9]) {
    uint32_t index[3] = {3 * triangle, 3 * triangle + 1, 3 * triangle + 2};
    const uint64_t address = input.indices + uint64_t(triangle) * input.indexStride;
    if (IndexFormat(input.indexFormat) == IndexFormat::kUint3)
        for (int i = 0; i < 3; ++i)
            index[i] = at<const uint32_t>(address)[i];
    else if (IndexFormat(input.indexFormat) == IndexFormat::kUshort3)
        for (int i = 0; i < 3; ++i)
            index[i] = at<const uint16_t>(address)[i];
    if (index[0] >= input.numVertices || index[1] >= input.numVertices ||
        index[2] >= input.numVertices)
        return false;
    for (int i = 0; i < 3; ++i)
        readVertex(input, index[i], v + 3 * i);
    if (input.preTransform) {
        const float* const m = at<const float>(input.preTransform);
        for (int i = 0; i < 3; ++i) {
            const float x = v[3 * i], y = v[3 * i + 1], z = v[3 * i + 2];
            for (int r = 0; r < 3; ++r)
                v[3 * i + r] =
                    add(add(add(mul(m[4 * r], x), mul(m[4 * r + 1], y)), mul(m[4 * r + 2], z)),
                        m[4 * r + 3]);
        }
    }
    return true;
}

// Differences of floats are not exact in double, but equal those of the CPU.
SUNSTONE_INLINE bool hasArea(const float v[9]) {
    double a[3], b[3];
    for (int i = 0; i < 3; ++i) {
        a[i] = sub(double(v[3 + i]), double(v[i]));
        b[i] = sub(double(v[6 + i]), double(v[i]));
    }
    return mul(a[1], b[2]) != mul(a[2], b[1]) || mul(a[2], b[0]) != mul(a[0], b[2]) ||
           mul(a[0], b[1]) != mul(a[1], b[0]);
}

SUNSTONE_INLINE bool readTriangle(const DeviceInput& input, uint32_t triangle, float v[9]) {
    if (!readVertices(input, triangle, v))
        return false;
    bool good = true;
    for (int i = 0; i < 9; ++i)
        good = good && isUsable(v[i]);
    return good && hasArea(v);
}

SUNSTONE_INLINE bool readCustom(const DeviceInput& input, uint32_t primitive, Bounds& box) {
    if (!input.data)
        return false;
    const float* const b = at<const float>(input.data + uint64_t(primitive) * input.stride);
    bool good = true;
    for (int i = 0; i < 3; ++i) {
        box.lower[i] = b[i];
        box.upper[i] = b[3 + i];
        good = good && b[i] <= b[3 + i] && isUsable(b[i]) && isUsable(b[3 + i]);
    }
    return good;
}

SUNSTONE_INLINE Bounds boundsOfTriangle(const float v[9]) {
    Bounds box;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = smaller(smaller(v[a], v[3 + a]), v[6 + a]);
        box.upper[a] = larger(larger(v[a], v[3 + a]), v[6 + a]);
    }
    return box;
}

SUNSTONE_INLINE bool readBox(const BuildJob& job, uint32_t primitive, Bounds& box) {
    const InputPlace from = placeOfPrimitive(job, primitive);
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[from.input];
    if (job.type == BlockType::kCustom)
        return readCustom(input, from.primitive, box);
    float v[9];
    if (!readTriangle(input, from.primitive, v))
        return false;
    box = boundsOfTriangle(v);
    return true;
}

// The padded box for nodes of an active primitive with this box.
SUNSTONE_INLINE Bounds padBounds(const Bounds& box) {
    const float size =
        larger(larger(sub(box.upper[0], box.lower[0]), sub(box.upper[1], box.lower[1])),
               sub(box.upper[2], box.lower[2]));
    const float pad = mul(size, 0x1p-21f);
    Bounds padded;
    for (int a = 0; a < 3; ++a) {
        padded.lower[a] = sub(box.lower[a], pad);
        padded.upper[a] = add(box.upper[a], pad);
    }
    return padded;
}

// Stores the padded box of a primitive, or one that marks it as inactive.
SUNSTONE_INLINE void storeBox(const BuildJob& job, uint32_t primitive, bool active,
                              const Bounds& box) {
    float* const to = at<float>(job.boxes + uint64_t(primitive) * sizeof(PrimitiveBox));
    const Bounds padded = active ? padBounds(box) : emptyBounds();
    for (int a = 0; a < 3; ++a) {
        to[a] = padded.lower[a];
        to[3 + a] = padded.upper[a];
    }
}

// Adds the results of a block's threads to the counters. All threads of the block must call.
SUNSTONE_INLINE void addToCounters(const BuildJob& job, const Bounds& found, uint32_t active) {
    __shared__ uint32_t most[7];
    if (threadIdx.x < 7)
        most[threadIdx.x] = 0;
    __syncthreads();
    Bounds box = active ? found : emptyBounds();
    for (uint32_t step = 1; step < 32; step *= 2) {
        Bounds other;
        for (int a = 0; a < 3; ++a) {
            other.lower[a] = __shfl_xor_sync(kWholeWarp, box.lower[a], int(step));
            other.upper[a] = __shfl_xor_sync(kWholeWarp, box.upper[a], int(step));
        }
        box = unite(box, other);
        active += __shfl_xor_sync(kWholeWarp, active, int(step));
    }
    if (active && laneOf() == 0) {
        for (int a = 0; a < 3; ++a) {
            atomicMax(&most[a], ~orderedBits(box.lower[a]));
            atomicMax(&most[3 + a], orderedBits(box.upper[a]));
        }
        atomicAdd(&most[6], active);
    }
    __syncthreads();
    if (most[6] == 0)
        return;
    Counters& counters = countersOf(job);
    if (threadIdx.x < 3)
        atomicMax(&counters.lower[threadIdx.x], most[threadIdx.x]);
    else if (threadIdx.x < 6)
        atomicMax(&counters.upper[threadIdx.x - 3], most[threadIdx.x]);
    else if (threadIdx.x == 6) {
        atomicAdd(&counters.numActive, most[6]);
        if (!job.keepInactive)
            atomicAdd(&counters.numTreeReferences, most[6]);
    }
}

// As addToCounters(), at the end of a build's first step. Without splits, references are
// primitives.
SUNSTONE_INLINE void countReferences(const BuildJob& job, const Bounds& found, uint32_t active) {
    addToCounters(job, found, active);
    if (globalThread() == 0) {
        countersOf(job).numReferences = job.numPrimitives;
        if (job.keepInactive)
            countersOf(job).numTreeReferences = job.numPrimitives;
    }
}

SUNSTONE_KERNEL sunstone_references(BuildJob job) {
    Bounds found = emptyBounds();
    uint32_t numActive = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        Bounds box = emptyBounds();
        const bool active = readBox(job, i, box);
        storeBox(job, i, active, box);
        if (active) {
            found = unite(found, box);
            ++numActive;
        }
    }
    countReferences(job, found, numActive);
}

} // namespace sunstone::bvh::gpu
