// SPDX-License-Identifier: Apache-2.0
// Helpers of builder kernels: access to the buffers of a job, warps, ordered numbers.
#pragma once

#include "bvh/gpu/build/job.h"
#include "bvh/gpu/portable.h"

namespace sunstone::bvh::gpu {

#define SUNSTONE_KERNEL extern "C" __global__ void

constexpr uint32_t kWholeWarp = ~0u;

template <class T>
SUNSTONE_INLINE T* at(uint64_t address) {
    return reinterpret_cast<T*>(address);
}
SUNSTONE_INLINE Counters& countersOf(const BuildJob& job) {
    return *at<Counters>(job.counters);
}
// Reports a failure to the host; writes the entry's number last.
SUNSTONE_INLINE void reportFailure(uint64_t report, uint64_t block, uint32_t failure) {
    BuildReport& to = *at<BuildReport>(report);
    const uint32_t before = atomicAdd(&to.count, 1u);
    BuildReport::Entry& entry = to.entries[before % BuildReport::kEntries];
    entry.block = block;
    entry.failure = failure;
    __threadfence_system();
    const_cast<volatile uint32_t&>(entry.number) = before + 1;
}

SUNSTONE_INLINE uint32_t globalThread() {
    return blockIdx.x * blockDim.x + threadIdx.x;
}
SUNSTONE_INLINE uint32_t laneOf() {
    return threadIdx.x & 31u;
}
SUNSTONE_INLINE uint32_t lanesBelow(uint32_t lane) {
    return (1u << lane) - 1;
}

// The header of a structure that is updated or post-processed; it has the places of its parts,
// which compaction changes.
SUNSTONE_INLINE const BlockHeader& headerIn(const BuildJob& job) {
    return *at<const BlockHeader>(job.output);
}
SUNSTONE_INLINE BuildJob inStructure(BuildJob job) {
    const BlockHeader& header = headerIn(job);
    job.inputRecords = job.output + header.inputsOffset;
    job.instances = job.output + header.instancesOffset;
    job.records = job.output + header.recordsOffset;
    job.nodes = job.output + header.nodesOffset;
    job.keyBounds = job.output + header.keyBoundsOffset;
    job.points = header.pointsOffset ? job.output + header.pointsOffset : 0;
    job.shape = header.shape;
    job.pieces = 1;
    return job;
}

SUNSTONE_INLINE WideNode& wideNode(const BuildJob& job, uint32_t index, uint32_t key = 0) {
    return at<WideNode>(job.nodes)[uint64_t(index) * job.motionKeys + key];
}

// Each node's parent.
SUNSTONE_INLINE void linkNodes(const BuildJob& job) {
    const uint32_t count = headerIn(job).numNodes;
    uint32_t* const parents = at<uint32_t>(job.parents);
    for (uint32_t i = globalThread(); i < count; i += gridDim.x * blockDim.x) {
        const WideNode& node = wideNode(job, i);
        const uint32_t children = uint32_t(__popc(node.innerMask));
        for (uint32_t k = 0; k < children; ++k)
            if (node.childBase + k < count)
                parents[node.childBase + k] = i;
        if (i == 0)
            parents[0] = kNoRef;
    }
}

// Makes earlier writes of this thread, and of threads with which it has synchronised, visible to
// every thread that sees its next write. __threadfence() also orders such writes among all threads,
// which takes longer. A single block needs only the order within the block.
SUNSTONE_INLINE void fence() {
    if (gridDim.x == 1)
        asm volatile("fence.acq_rel.cta;" ::: "memory");
    else
        asm volatile("fence.acq_rel.gpu;" ::: "memory");
}

// Loads of data that other multiprocessors write while the kernel runs.
template <class T>
SUNSTONE_INLINE T loadFresh(const T* address) {
    return *const_cast<const volatile T*>(address);
}

// Maps floats to integers with the same order.
SUNSTONE_INLINE uint32_t orderedBits(float a) {
    const uint32_t bits = bitsOf(a);
    return bits >> 31 ? ~bits : bits | 0x80000000u;
}
SUNSTONE_INLINE float fromOrdered(uint32_t bits) {
    return floatOf(bits >> 31 ? bits & 0x7FFFFFFFu : ~bits);
}

// A box in registers.
struct Bounds {
    float lower[3], upper[3];
};
SUNSTONE_INLINE Bounds emptyBounds() {
    const float inf = __builtin_inff();
    return {{inf, inf, inf}, {-inf, -inf, -inf}};
}
SUNSTONE_INLINE Bounds unite(const Bounds& a, const Bounds& b) {
    Bounds r;
    for (int i = 0; i < 3; ++i) {
        r.lower[i] = smaller(a.lower[i], b.lower[i]);
        r.upper[i] = larger(a.upper[i], b.upper[i]);
    }
    return r;
}
SUNSTONE_INLINE bool isEmpty(const Bounds& b) {
    return !(b.lower[0] <= b.upper[0]);
}
SUNSTONE_INLINE float halfArea(const Bounds& b) { // empty: 0
    const float x = larger(sub(b.upper[0], b.lower[0]), 0.0f),
                y = larger(sub(b.upper[1], b.lower[1]), 0.0f),
                z = larger(sub(b.upper[2], b.lower[2]), 0.0f);
    return add(add(mul(x, y), mul(y, z)), mul(z, x));
}

SUNSTONE_INLINE uint32_t refCount(uint32_t ref) { // 1 to 3, 0: more
    return ref >> kRefCountShift;
}
SUNSTONE_INLINE uint32_t refIndex(uint32_t ref) {
    return ref & kRefIndexMask;
}
SUNSTONE_INLINE uint32_t joinCounts(uint32_t a, uint32_t b) {
    const uint32_t sum = refCount(a) + refCount(b);
    return refCount(a) != 0 && refCount(b) != 0 && sum <= kMaxLeafPrimitives ? sum : 0;
}

// The most primitives of a leaf.
SUNSTONE_INLINE uint32_t leafLimit(const BuildJob& job) {
    return job.type == BlockType::kTriangles ? kMaxLeafPrimitives : 1;
}

// A primitive's record at a key.
SUNSTONE_INLINE uint64_t recordAt(const BuildJob& job, uint32_t place, uint32_t key) {
    const uint64_t size = recordSize(job.type, job.shape, job.motionKeys);
    return job.records + place * size + key * (size / job.motionKeys);
}

SUNSTONE_INLINE Bounds primitiveBounds(const BuildJob& job, uint32_t primitive) {
    const U2* const words = at<const U2>(job.boxes + uint64_t(primitive) * sizeof(PrimitiveBox));
    const U2 a = words[0], b = words[1], c = words[2];
    return {{floatOf(a.x), floatOf(a.y), floatOf(b.x)}, {floatOf(b.y), floatOf(c.x), floatOf(c.y)}};
}

} // namespace sunstone::bvh::gpu
