// SPDX-License-Identifier: Apache-2.0
// First step of a build: the box of each primitive, and bounds and number of the active ones. What
// makes a primitive active, and what its vertices are, is as on the CPU (bvh/build_input.h).
#pragma once

#include "bvh/build.h"
#include "bvh/gpu/device.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kReferenceThreads = 256;
constexpr float kLargestCoordinate = 0x1p100f;

SUNSTONE_BUILDER bool isUsable(float a) {
    return a >= -kLargestCoordinate && a <= kLargestCoordinate;
}

// The build input of a primitive, counted over all inputs.
SUNSTONE_BUILDER uint32_t inputOfPrimitive(const BuildJob& job, uint32_t primitive) {
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

SUNSTONE_BUILDER float halfToFloat(uint32_t h) {
    const uint32_t exponent = h >> 10 & 31u, mantissa = h & 0x3FFu;
    const float value = exponent == 31  ? floatOf(0x7F800000u | mantissa << 13)
                        : exponent == 0 ? mul(float(mantissa), 0x1p-24f)
                                        : floatOf((exponent + 112) << 23 | mantissa << 13);
    return h & 0x8000u ? -value : value;
}
SUNSTONE_BUILDER float snormToFloat(uint32_t bits) {
    return larger(divide(float(int16_t(bits)), 32767.0f), -1.0f);
}

SUNSTONE_BUILDER void readVertex(const DeviceInput& input, uint32_t index, float out[3]) {
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
SUNSTONE_BUILDER bool readVertices(const DeviceInput& input, uint32_t triangle, float v[9]) {
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

// Differences of floats are not exact in double, but the same as on the CPU.
SUNSTONE_BUILDER bool hasArea(const float v[9]) {
    double a[3], b[3];
    for (int i = 0; i < 3; ++i) {
        a[i] = sub(double(v[3 + i]), double(v[i]));
        b[i] = sub(double(v[6 + i]), double(v[i]));
    }
    return mul(a[1], b[2]) != mul(a[2], b[1]) || mul(a[2], b[0]) != mul(a[0], b[2]) ||
           mul(a[0], b[1]) != mul(a[1], b[0]);
}

SUNSTONE_BUILDER bool readTriangle(const DeviceInput& input, uint32_t triangle, float v[9]) {
    if (!readVertices(input, triangle, v))
        return false;
    bool good = true;
    for (int i = 0; i < 9; ++i)
        good = good && isUsable(v[i]);
    return good && hasArea(v);
}

SUNSTONE_BUILDER bool readCustom(const DeviceInput& input, uint32_t primitive, Bounds& box) {
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

SUNSTONE_BUILDER Bounds boundsOfTriangle(const float v[9]) {
    Bounds box;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = smaller(smaller(v[a], v[3 + a]), v[6 + a]);
        box.upper[a] = larger(larger(v[a], v[3 + a]), v[6 + a]);
    }
    return box;
}

SUNSTONE_BUILDER bool readBox(const BuildJob& job, uint32_t primitive, Bounds& box) {
    const uint32_t i = inputOfPrimitive(job, primitive);
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[i];
    const uint32_t local = primitive - at<const InputRecord>(job.inputRecords)[i].firstPrimitive;
    if (job.type == BlockType::kCustom)
        return readCustom(input, local, box);
    float v[9];
    if (!readTriangle(input, local, v))
        return false;
    box = boundsOfTriangle(v);
    return true;
}

// What nodes must hold of an active primitive with this box.
SUNSTONE_BUILDER Bounds padBounds(const Bounds& box) {
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

// Stores the padded box of a primitive, or one that says it is inactive.
SUNSTONE_BUILDER void storeBox(const BuildJob& job, uint32_t primitive, bool active,
                               const Bounds& box) {
    float* const to = at<float>(job.boxes + uint64_t(primitive) * sizeof(PrimitiveBox));
    const Bounds padded = active ? padBounds(box) : emptyBounds();
    for (int a = 0; a < 3; ++a) {
        to[a] = padded.lower[a];
        to[3 + a] = padded.upper[a];
    }
}

// Adds what the threads of a block found to the counters.
SUNSTONE_BUILDER void addToCounters(const BuildJob& job, const Bounds& found, uint32_t active) {
    __shared__ uint32_t most[7];
    if (threadIdx.x < 7)
        most[threadIdx.x] = 0;
    __syncthreads();
    if (active) {
        for (int a = 0; a < 3; ++a) {
            atomicMax(&most[a], ~orderedBits(found.lower[a]));
            atomicMax(&most[3 + a], orderedBits(found.upper[a]));
        }
        atomicAdd(&most[6], active);
    }
    __syncthreads();
    Counters& counters = countersOf(job);
    if (threadIdx.x < 3)
        atomicMax(&counters.lower[threadIdx.x], most[threadIdx.x]);
    else if (threadIdx.x < 6)
        atomicMax(&counters.upper[threadIdx.x - 3], most[threadIdx.x]);
    else if (threadIdx.x == 6 && most[6]) {
        atomicAdd(&counters.numActive, most[6]);
        if (!job.keepInactive)
            atomicAdd(&counters.numTreeReferences, most[6]);
    }
}

// ---- instances --------------------------------------------------------------------------------

SUNSTONE_BUILDER bool invertTransform(const float m[12], float inverse[12]) {
    const double a = m[0], b = m[1], c = m[2], d = m[4], e = m[5], f = m[6];
    const double g = m[8], h = m[9], i = m[10];
    const double c0 = sub(mul(e, i), mul(f, h)), c1 = sub(mul(f, g), mul(d, i)),
                 c2 = sub(mul(d, h), mul(e, g));
    const double det = __dadd_rn(__dadd_rn(mul(a, c0), mul(b, c1)), mul(c, c2));
    const double s = 1.0 / det;
    const double r[9] = {
        mul(c0, s), mul(sub(mul(c, h), mul(b, i)), s), mul(sub(mul(b, f), mul(c, e)), s),
        mul(c1, s), mul(sub(mul(a, i), mul(c, g)), s), mul(sub(mul(c, d), mul(a, f)), s),
        mul(c2, s), mul(sub(mul(b, g), mul(a, h)), s), mul(sub(mul(a, e), mul(b, d)), s)};
    bool finite = det != 0;
    for (int row = 0; row < 3; ++row) {
        const double* const q = r + 3 * row;
        const double t = -__dadd_rn(__dadd_rn(mul(q[0], double(m[3])), mul(q[1], double(m[7]))),
                                    mul(q[2], double(m[11])));
        for (int j = 0; j < 4; ++j) {
            const float value = float(j < 3 ? q[j] : t);
            inverse[4 * row + j] = value;
            finite = finite && (bitsOf(value) & 0x7F800000u) != 0x7F800000u;
        }
    }
    if (!finite)
        for (int k = 0; k < 12; ++k)
            inverse[k] = 0;
    return finite;
}

// Bounds seen through a transform, with the CPU's margin for the rounding of transformed rays.
SUNSTONE_BUILDER Bounds transformBounds(const float m[12], const Bounds& b) {
    Bounds r;
    for (int i = 0; i < 3; ++i) {
        double low = m[4 * i + 3], high = low, size = low < 0 ? -low : low;
        for (int j = 0; j < 3; ++j) {
            const double p = double(m[4 * i + j]) * b.lower[j],
                         q = double(m[4 * i + j]) * b.upper[j];
            low += p < q ? p : q;
            high += p < q ? q : p;
            const double x = p < 0 ? -p : p, y = q < 0 ? -q : q;
            size += x < y ? y : x;
        }
        const double margin = size * 0x1p-20;
        r.lower[i] = float(low - margin);
        r.upper[i] = float(high + margin);
    }
    return r;
}

// As many as traversal walks (devlib/gpu/launch_block.h).
constexpr uint32_t kMaxStaticChain = 15;

// Bounds of what an instance's child leads to; false if there is nothing. Transforms between: only
// static ones (others are met as if they held nothing).
SUNSTONE_BUILDER bool childBounds(uint64_t handle, Bounds& box, uint64_t chain[kMaxStaticChain],
                                  uint32_t& length) {
    length = 0;
    while ((handle & kTraversableTagMask) == kStaticTransformTag && length < kMaxStaticChain) {
        chain[length++] = handle & ~uint64_t(kTraversableTagMask);
        handle = at<const StaticTransform>(handle & ~uint64_t(kTraversableTagMask))->child;
    }
    const uint64_t tag = handle & kTraversableTagMask;
    if ((tag != kGasTag && tag != kIasTag) || handle <= kTraversableTagMask)
        return false;
    const BlockHeader& header = *at<const BlockHeader>(handle & ~uint64_t(kTraversableTagMask));
    if (header.magic != kGpuBlockMagic || header.root == kNoNode)
        return false;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = header.lower[a];
        box.upper[a] = header.upper[a];
    }
    return true;
}

// Writes the record of an instance; false if it is inactive, else its box.
SUNSTONE_BUILDER bool describeInstance(const BuildJob& job, uint32_t index, Bounds& box) {
    const DeviceInput& input = *at<const DeviceInput>(job.inputs);
    uint64_t address = input.data + uint64_t(index) * input.stride;
    if (input.areAddresses)
        address = *at<const uint64_t>(input.data + 8 * uint64_t(index));
    InstanceData& to = at<InstanceData>(job.instances)[index];
    to.index = index;
    to.pad = 0;
    if (address == 0 || address % 16 != 0) {
        to.child = 0;
        to.visibilityMask = 0;
        return false;
    }
    const InstanceDesc& from = *at<const InstanceDesc>(address);
    const bool identity = from.flags & input.identityFlag;
    float m[12], inverse[12];
    for (int i = 0; i < 12; ++i)
        m[i] = identity ? (i % 5 == 0 ? 1.0f : 0.0f) : from.transform[i];
    const bool invertible = invertTransform(m, inverse);
    for (int i = 0; i < 12; ++i) {
        to.objectToWorld[i] = m[i];
        to.worldToObject[i] = inverse[i];
    }
    to.child = from.traversableHandle;
    to.instanceId = from.instanceId;
    to.sbtOffset = from.sbtOffset;
    to.visibilityMask = from.visibilityMask;
    to.flags = from.flags & input.knownFlags & ~input.identityFlag;
    uint64_t chain[kMaxStaticChain];
    uint32_t length;
    if (!invertible || (to.visibilityMask & 0xFF) == 0 ||
        !childBounds(to.child, box, chain, length))
        return false;
    while (length-- > 0)
        box = transformBounds(at<const StaticTransform>(chain[length])->transform, box);
    box = transformBounds(m, box);
    bool good = true;
    for (int a = 0; a < 3; ++a)
        good = good && isUsable(box.lower[a]) && isUsable(box.upper[a]) &&
               box.lower[a] <= box.upper[a];
    return good;
}

// ---- kernels ----------------------------------------------------------------------------------

SUNSTONE_KERNEL sunstone_references(BuildJob job) {
    Bounds found = emptyBounds();
    uint32_t numActive = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        Bounds box = emptyBounds();
        const bool active = job.type == BlockType::kInstances ? describeInstance(job, i, box)
                                                              : readBox(job, i, box);
        storeBox(job, i, active, box);
        if (active) {
            found = unite(found, box);
            ++numActive;
        }
    }
    addToCounters(job, found, numActive);
    // If nothing is split, references are primitives.
    if (globalThread() == 0) {
        countersOf(job).numReferences = job.numPrimitives;
        if (job.keepInactive)
            countersOf(job).numTreeReferences = job.numPrimitives;
    }
}

} // namespace sunstone::bvh::gpu
