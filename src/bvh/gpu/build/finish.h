// SPDX-License-Identifier: Apache-2.0
// Last steps: the primitives' records and the header; compaction and emitted properties.
#pragma once

#include "bvh/gpu/build/moving_shapes.h"
#include "bvh/gpu/build/shared_records.h"

namespace sunstone::bvh::gpu {

// Writes the record of a triangle or a custom primitive. False if the primitive is inactive (tested
// for triangles only if mayBeInactive); else `exact` is its box.
SUNSTONE_INLINE bool writeRecord(const BuildJob& job, uint32_t place, InputPlace from,
                                 bool mayBeInactive, Bounds& exact) {
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[from.input];
    const InputRecord& record = at<const InputRecord>(job.inputRecords)[from.input];
    const uint32_t reported = from.primitive + record.primitiveIndexOffset;
    const uint32_t word = sbtWord(input, record, from.primitive);
    if (job.type == BlockType::kCustom) {
        const bool active = readCustom(input, from.primitive, exact);
        storeCustom(at<U4>(job.records + uint64_t(place) * sizeof(CustomLeaf)),
                    active ? exact : emptyBounds(), reported, word);
        return active;
    }
    float v[9];
    const bool active = mayBeInactive ? readTriangle(input, from.primitive, v)
                                      : readVertices(input, from.primitive, v);
    if (!active)
        for (float& x : v)
            x = __builtin_nanf("");
    storeTriangle(at<U4>(job.records + uint64_t(place) * sizeof(TriangleRecord)), v, reported,
                  word);
    exact = boundsOfTriangle(v);
    return active;
}

// Writes the records of triangles that leaves share (shared_records.h).
SUNSTONE_INLINE void writeSharedRecords(const BuildJob& job) {
    const uint32_t stride = gridDim.x * blockDim.x, count = countersOf(job).numTreeReferences;
    Bounds unused;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += stride)
        writeRecord(job, i, placeOfPrimitive(job, i), true, unused);
    for (uint32_t i = globalThread(); i < count; i += stride) {
        const uint32_t reference = refIndex(at<const uint32_t>(job.newOrder)[i]);
        const bool whole = reference < job.numPrimitives;
        const uint32_t triangle =
            whole ? reference : at<const uint32_t>(job.origins)[reference - job.numPrimitives];
        *const_cast<uint32_t*>(sharedNumber(at<void>(job.nodes), i)) = triangle;
        if (job.table && whole)
            at<uint32_t>(job.table)[triangle] = triangle;
    }
}

template <bool kMotion, bool kShapes>
SUNSTONE_INLINE void writeRecords(const BuildJob& job) {
    if (!kMotion && !kShapes && countersOf(job).sharesRecords)
        return writeSharedRecords(job);
    const uint32_t count = countersOf(job).numTreeReferences;
    for (uint32_t i = globalThread(); i < count; i += gridDim.x * blockDim.x) {
        const uint32_t reference = refIndex(at<const uint32_t>(job.newOrder)[i]);
        const bool whole = reference < job.numPrimitives;
        const uint32_t primitive =
            whole ? reference : at<const uint32_t>(job.origins)[reference - job.numPrimitives];
        Bounds unused;
        if constexpr (kShapes) {
            const uint32_t word = wordOfReference(job, reference);
            if (kMotion)
                writeMovingShapeRecord(job, i, word, unused);
            else
                writeShapeRecord(job, i, word, unused);
            continue;
        }
        if (job.type == BlockType::kInstances) {
            at<uint32_t>(job.records)[i] = primitive;
            continue;
        }
        const InputPlace from = placeOfPrimitive(job, primitive);
        if (kMotion)
            writeMovingRecord(job, i, from, job.keepInactive, unused);
        else
            writeRecord(job, i, from, job.keepInactive, unused);
        if (job.table && whole)
            at<uint32_t>(job.table)[primitive] = i;
    }
}

SUNSTONE_INLINE uint64_t roundUp(uint64_t value, uint64_t unit) {
    return (value + unit - 1) / unit * unit;
}
// Bytes of the data before the nodes, which moves with the nodes, and the start of the nodes in a
// compacted copy.
SUNSTONE_INLINE uint64_t bytesBeforeNodes(const BlockHeader& header) {
    return header.sharesRecords ? sharedNumbers(header.numLeaves) : 0;
}
SUNSTONE_INLINE uint64_t compactNodes(const BlockHeader& header) {
    const uint64_t record = recordSize(kindOf(header.type), header.shape, header.motionKeys);
    const uint32_t count = header.sharesRecords ? header.numPrimitives : header.numLeaves;
    return roundUp(header.recordsOffset + count * record, 128) + bytesBeforeNodes(header);
}

SUNSTONE_INLINE void zeroWords(uint64_t from, uint64_t to) {
    const uint64_t stride = uint64_t(gridDim.x) * blockDim.x;
    for (uint64_t i = from / 16 + globalThread(); i < to / 16; i += stride)
        *at<U4>(16 * i) = U4{0, 0, 0, 0};
}
// Zeroes the gaps between the parts of a structure, after the records (scratch) and after the
// nodes, so that neither the structure nor its copies contain earlier contents of the buffers.
SUNSTONE_INLINE void zeroRest(const BuildJob& job) {
    const uint64_t records = recordSize(job.type, job.shape, job.motionKeys);
    const Counters& counters = countersOf(job);
    const bool shared = counters.sharesRecords;
    uint64_t end =
        job.records + (shared ? job.numPrimitives : counters.numTreeReferences) * records;
    uint64_t next = job.nodes - (shared ? uint64_t(counters.numTreeReferences) * 4 : 0);
    if (globalThread() == 0) {
        for (; end % 16 != 0; end += 4) // of instances
            *at<uint32_t>(end) = 0;
        for (; next % 16 != 0; next -= 4) // of numbers of triangles
            *at<uint32_t>(next - 4) = 0;
    }
    zeroWords(roundUp(end, 16), next);
    end = job.nodes + uint32_t(countersOf(job).allocated) * nodeSize(job.motionKeys);
    zeroWords(end, roundUp(end, 128));
#pragma unroll
    for (uint32_t i = 0; i < kMaxGaps; ++i)
        if (globalThread() < job.gaps[i].size)
            at<uint8_t>(job.output + job.gaps[i].offset)[globalThread()] = 0;
}

// Copies the nodes back from scratch memory (arrange.h).
SUNSTONE_INLINE void takeNodes(const BuildJob& job) {
    constexpr uint32_t kWords = sizeof(WideNode) / 16;
    const uint64_t words = uint64_t(uint32_t(countersOf(job).allocated)) * kWords;
    const uint64_t stride = uint64_t(gridDim.x) * blockDim.x, size = nodeSize(job.motionKeys);
    for (uint64_t i = globalThread(); i < words; i += stride)
        at<U4>(job.nodes + i / kWords * size)[i % kWords] = at<const U4>(job.newNodes)[i];
}

// The header's fields about active primitives.
SUNSTONE_INLINE void describeContents(BlockHeader& header, const Counters& counters) {
    const bool any = counters.numActive != 0;
    header.numActive = counters.numActive;
    float largest = 0;
    for (int a = 0; a < 3; ++a) {
        header.lower[a] = any ? fromOrdered(~counters.lower[a]) : __builtin_inff();
        header.upper[a] = any ? fromOrdered(counters.upper[a]) : -__builtin_inff();
        largest = larger(largest, larger(magnitude(header.lower[a]), magnitude(header.upper[a])));
    }
    header.largestCoordinate = largest;
    header.root = any ? 0 : kNoNode;
}

// Whether the tree holds each reference exactly once.
SUNSTONE_INLINE bool isWhole(const Counters& counters) {
    return !counters.failure && counters.finished == uint32_t(counters.allocated) &&
           uint32_t(counters.allocated >> 32) == counters.numTreeReferences;
}

// The header is complete only with its magic number.
SUNSTONE_INLINE void finish(const BuildJob& job) {
    BlockHeader& header = *at<BlockHeader>(job.output);
    Counters& counters = countersOf(job);
    if (!isWhole(counters)) {
        if (!counters.failure)
            counters.failure = kTreeBroken;
        header.magic = 0;
        header.usedSize = sizeof(BlockHeader);
        return reportFailure(job.report, job.output, counters.failure);
    }
    describeContents(header, counters);
    header.wholeRoot = counters.numTreeReferences ? 0 : kNoNode;
    header.numNodes = uint32_t(counters.allocated);
    header.numLeaves = counters.numTreeReferences;
    header.treeTooDeep = counters.tooDeep;
    header.sharesRecords = counters.sharesRecords ? uint16_t(kSharedTag) : uint16_t(0);
    header.usedSize =
        roundUp(compactNodes(header) + header.numNodes * nodeSize(header.motionKeys), 128);
    __threadfence();
    header.magic = kGpuBlockMagic;
}

// Writes records and header, which no thread of this kernel reads. Curves and spheres have separate
// kernels, because these take a GPU's compiler several times as long.
template <bool kMotion, bool kShapes>
SUNSTONE_INLINE void finishTree(const BuildJob& job) {
    if (isWhole(countersOf(job))) {
        takeNodes(job);
        writeRecords<kMotion, kShapes>(job);
        zeroRest(job);
    }
    if (globalThread() == 0)
        finish(job);
}
SUNSTONE_KERNEL sunstone_records(BuildJob job) {
    finishTree<false, false>(job);
}
SUNSTONE_KERNEL sunstone_shape_records(BuildJob job) {
    finishTree<false, true>(job);
}
SUNSTONE_KERNEL sunstone_moving_records(BuildJob job) {
    finishTree<true, false>(job);
}
SUNSTONE_KERNEL sunstone_moving_shape_records(BuildJob job) {
    finishTree<true, true>(job);
}

SUNSTONE_INLINE bool mayCompact(const BlockHeader& header, uint64_t from, uint64_t to,
                                uint64_t bytes) {
    return header.magic == kGpuBlockMagic && bytes >= header.usedSize &&
           (from >= to + header.usedSize || to >= from + header.usedSize);
}

// Copies a structure into a buffer of so many bytes, without gaps between its parts.
SUNSTONE_KERNEL sunstone_compact(uint64_t from, uint64_t to, uint64_t bytes, uint64_t report) {
    const BlockHeader& header = *at<const BlockHeader>(from);
    if (!mayCompact(header, from, to, bytes)) {
        if (globalThread() == 0)
            reportFailure(report, to, kNotCompacted);
        return;
    }
    const uint64_t newNodes = compactNodes(header), moved = newNodes - bytesBeforeNodes(header);
    const uint64_t first = sizeof(BlockHeader) / 16, words = header.usedSize / 16;
    const uint64_t stride = uint64_t(gridDim.x) * blockDim.x;
    for (uint64_t i = globalThread(); i < words; i += stride) {
        if (i < first)
            continue;
        const uint64_t source = 16 * i < moved ? 16 * i : 16 * i - newNodes + header.nodesOffset;
        at<U4>(to)[i] = *at<const U4>(from + source);
    }
    if (globalThread() == 0) {
        BlockHeader copy = header;
        copy.nodesOffset = newNodes;
        *at<BlockHeader>(to) = copy;
    }
}

enum EmittedProperty : uint32_t { kEmitCompactedSize = 1, kEmitBounds = 2 };

SUNSTONE_KERNEL sunstone_emit(uint64_t block, uint64_t to, uint32_t what) {
    const BlockHeader& header = *at<const BlockHeader>(block);
    if (what == kEmitCompactedSize) {
        *at<uint64_t>(to) = header.usedSize;
        return;
    }
    if (isMoving(header.type)) { // a box for each key
        for (uint32_t i = 0; i < 6 * header.motionKeys; ++i)
            at<float>(to)[i] = at<const float>(block + header.keyBoundsOffset)[i];
        return;
    }
    for (int a = 0; a < 3; ++a) {
        at<float>(to)[a] = header.lower[a];
        at<float>(to)[3 + a] = header.upper[a];
    }
}

} // namespace sunstone::bvh::gpu
