// SPDX-License-Identifier: Apache-2.0
// Updates: the tree stays; primitives are read again and boxes are computed from the leaves up.
//
//   update_check    checks that the structure is the one the host expects; else it stays unchanged
//   update_records  the record of each primitive (of instances by the build's kernels); bounds and
//                   number of the active ones; each node's parent
//   update_nodes    eight lanes make a node, one each slot. The lanes that complete a node's last
//                   child continue with the node, as in the build, without waiting. And the header
//
// Every box is a minimum and maximum over the same numbers for any order of the threads, so equal
// input gives equal bytes. An update from the input of the build gives the nodes and records of the
// build.
//
// A kind of primitives provides:
//   updateRecord    writes a record from its own SBT index and primitive index, or returns that the
//                   primitive is inactive
//   recordBounds    the padded box of a record, empty if it is inactive, from the record alone or
//                   from the data that updateRecord left in job.boxes (UpdatePlan reserves them)
// With motion keys a node is made at one key after the other, with its boxes at all keys in
// nodeBoxes. A build with motion ends with the same steps, because its tree has only the means of
// boxes.
#pragma once

#include "bvh/gpu/build/finish.h"
#include "bvh/gpu/build/grid.h"
#include "bvh/gpu/build/instances.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kRefitThreads = 256;

// Builder::checkUpdate has the same rules on the host.
SUNSTONE_INLINE bool isExpected(const BuildJob& job, const BlockHeader& is,
                                const BlockHeader& wanted) {
    return is.magic == kGpuBlockMagic && is.version == wanted.version && is.type == wanted.type &&
           is.options == wanted.options && (is.options & kOptionUpdate) &&
           is.motionKeys == wanted.motionKeys && is.motionFlags == wanted.motionFlags &&
           is.motionBegin == wanted.motionBegin && is.motionEnd == wanted.motionEnd &&
           is.shape == wanted.shape && is.numInputs == wanted.numInputs &&
           is.numPrimitives == wanted.numPrimitives && is.inputsOffset == wanted.inputsOffset &&
           is.usedSize <= job.outputSize && is.numNodes <= job.maxWide &&
           is.numLeaves <= job.maxReferences;
}

SUNSTONE_INLINE bool hasSameMicromaps(const BuildJob& job, uint32_t i) {
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[i];
    const uint64_t table = headerIn(job).micromapsOffset;
    if (table == 0)
        return input.micromapIndexing == 0;
    const MicromapRecord& is = at<const MicromapRecord>(job.output + table)[i];
    return is.indexing == input.micromapIndexing &&
           (is.indexing == 0 || input.mayChangeMicromaps || is.array == input.micromaps);
}

// One block. Each header is one load; their fields are compared one after the other.
SUNSTONE_KERNEL sunstone_update_check(BuildJob job) {
    constexpr uint32_t kWords = sizeof(BlockHeader) / 4;
    __shared__ BlockHeader headers[2];
    if (threadIdx.x < 2 * kWords)
        reinterpret_cast<uint32_t*>(headers)[threadIdx.x] = at<const uint32_t>(
            threadIdx.x < kWords ? job.output : job.expected)[threadIdx.x % kWords];
    __syncthreads();
    bool same = isExpected(job, headers[0], headers[1]);
    if (same) {
        const uint32_t words = job.numInputs * uint32_t(sizeof(InputRecord) / 4);
        const auto* const are = at<const uint32_t>(job.output + headerIn(job).inputsOffset);
        const auto* const wanted = at<const uint32_t>(job.expected + sizeof(BlockHeader));
        for (uint32_t i = threadIdx.x; i < words; i += blockDim.x)
            same = same && are[i] == wanted[i];
    }
    for (uint32_t i = threadIdx.x; same && i < job.numInputs; i += blockDim.x)
        same = hasSameMicromaps(job, i);
    if (!same)
        atomicExch(&countersOf(job).failure, uint32_t(kNotThatStructure));
}

// ---- records ----------------------------------------------------------------------------------

// The build input of a record's SBT word.
SUNSTONE_INLINE uint32_t inputOfSbtWord(const BuildJob& job, uint32_t word) {
    const InputRecord* const records = at<const InputRecord>(job.inputRecords);
    const uint32_t index = word & kSbtIndexMask;
    uint32_t low = 0, high = job.numInputs;
    while (high - low > 1) {
        const uint32_t middle = (low + high) / 2;
        if (records[middle].firstSbtIndex <= index)
            low = middle;
        else
            high = middle;
    }
    return low;
}

// A sphere's record has the primitive in word 4, that of a curve's segment (which is not split if
// updates are allowed) in word 9; the SBT word follows. Without motion the primitive's box goes to
// its place.
template <bool kMotion>
SUNSTONE_INLINE bool updateShapeRecord(const BuildJob& job, uint32_t place, const uint32_t* words,
                                       Bounds& exact) {
    const uint32_t* const reported = words + (job.shape == kSphereShape ? 4 : 9);
    const InputRecord& record =
        at<const InputRecord>(job.inputRecords)[inputOfSbtWord(job, reported[1])];
    const uint32_t local = reported[0] - record.primitiveIndexOffset;
    exact = emptyBounds();
    if (kMotion)
        return local < record.numPrimitives &&
               writeMovingShapeRecord(job, place, wholeShape(job, record.firstPrimitive + local),
                                      exact);
    const bool active =
        local < record.numPrimitives &&
        writeShapeRecord(job, place, wholeShape(job, record.firstPrimitive + local), exact);
    storeBox(job, place, active, exact);
    return active;
}

// For all kinds except instances, whose records the build's kernels read.
template <bool kMotion, bool kShapes>
SUNSTONE_INLINE bool updateRecord(const BuildJob& job, uint32_t place, Bounds& exact) {
    const auto* const words = at<const uint32_t>(recordAt(job, place, 0));
    if constexpr (kShapes)
        return updateShapeRecord<kMotion>(job, place, words, exact);
    // Both kinds have the primitive in word 3 and the SBT word in word 7.
    const uint32_t input = inputOfSbtWord(job, words[7]);
    const InputRecord& record = at<const InputRecord>(job.inputRecords)[input];
    const uint32_t primitive = words[3] - record.primitiveIndexOffset;
    if (primitive >= record.numPrimitives)
        return false;
    return kMotion ? writeMovingRecord(job, place, {input, primitive}, true, exact)
                   : writeRecord(job, place, {input, primitive}, true, exact);
}

// The box of a record at a key, not padded; or that of the whole primitive, if the record is a
// piece of it, or its emitted bounds. For instances, curves and spheres with motion keys only.
template <bool kMotion>
SUNSTONE_INLINE Bounds exactBounds(const BuildJob& job, uint32_t place, uint32_t key, bool whole) {
    if (kMotion && job.type == BlockType::kInstances) {
        const uint32_t index = at<const uint32_t>(job.records)[place];
        if (index >= job.numPrimitives)
            return emptyBounds();
        return boundsOf((whole ? keyBoxesOf(job, index) : tightBoxesOf(job, index))[key]);
    }
    if (kMotion && job.type == BlockType::kShapes)
        return boxOfMovingRecord(job, place, key, whole);
    const U4* const words = at<const U4>(recordAt(job, place, key));
    const U4 a = words[0], b = words[1];
    if (job.type == BlockType::kCustom)
        return {{floatOf(a.x), floatOf(a.y), floatOf(a.z)},
                {floatOf(b.x), floatOf(b.y), floatOf(b.z)}};
    const U4 c = words[2];
    const float v[9] = {floatOf(a.x), floatOf(a.y), floatOf(a.z), floatOf(b.x), floatOf(b.y),
                        floatOf(b.z), floatOf(c.x), floatOf(c.y), floatOf(c.z)};
    return v[0] == v[0] ? boundsOfTriangle(v) : emptyBounds();
}

template <bool kMotion>
SUNSTONE_INLINE Bounds recordBounds(const BuildJob& job, uint32_t place, uint32_t key) {
    if (!kMotion && job.type == BlockType::kInstances) {
        const uint32_t index = at<const uint32_t>(job.records)[place];
        return index < job.numPrimitives ? primitiveBounds(job, index) : emptyBounds();
    }
    if (!kMotion && job.type == BlockType::kShapes)
        return primitiveBounds(job, place);
    const Bounds box = exactBounds<kMotion>(job, place, key, false);
    return isEmpty(box) ? emptyBounds() : padBounds(box);
}

template <bool kMotion, bool kShapes>
SUNSTONE_INLINE void updateRecords(const BuildJob& job) {
    const uint32_t count = headerIn(job).numLeaves;
    Bounds found = emptyBounds();
    uint32_t numActive = 0;
    for (uint32_t i = globalThread(); i < count; i += gridDim.x * blockDim.x) {
        Bounds exact;
        if (updateRecord<kMotion, kShapes>(job, i, exact)) {
            found = unite(found, exact);
            ++numActive;
        }
    }
    addToCounters(job, found, numActive);
}

template <bool kMotion, bool kShapes>
SUNSTONE_INLINE void updateRecordsAndLinks(const BuildJob& given) {
    if (countersOf(given).failure)
        return;
    const BuildJob job = inStructure(given);
    linkNodes(job);
    updateRecords<kMotion, kShapes>(job);
}

SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_records(BuildJob given) {
    updateRecordsAndLinks<false, false>(given);
}
SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_shape_records(BuildJob given) {
    updateRecordsAndLinks<false, true>(given);
}
SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_moving_records(BuildJob given) {
    updateRecordsAndLinks<true, false>(given);
}
SUNSTONE_KERNEL
__launch_bounds__(kRefitThreads) sunstone_update_moving_shape_records(BuildJob given) {
    updateRecordsAndLinks<true, true>(given);
}

// ---- nodes ------------------------------------------------------------------------------------

SUNSTONE_INLINE uint64_t nodeBoxAt(const BuildJob& job, uint32_t index, uint32_t key) {
    return job.nodeBoxes + (uint64_t(index) * job.motionKeys + key) * sizeof(PrimitiveBox);
}

// For builds with motion; updates link nodes together with their records.
SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_links(BuildJob given) {
    if (!countersOf(given).failure)
        linkNodes(inStructure(given));
}

// The words of a node before its planes; all eight lanes have them.
struct NodeHead {
    uint32_t innerMask, childBase, primitiveBase, meta[2];
};
SUNSTONE_INLINE NodeHead loadHead(const WideNode& node) {
    const U4* const words = reinterpret_cast<const U4*>(&node);
    const U4 b = words[1];
    return {words[0].w >> 24, b.x, b.y, {b.z, b.w}};
}
SUNSTONE_INLINE uint32_t metaOf(const NodeHead& head, uint32_t slot) {
    return (slot < 4 ? head.meta[0] : head.meta[1]) >> 8 * (slot % 4) & 0xFFu;
}

// The present box of a slot and its meta byte, which depends on whether the slot is active.
template <bool kMotion>
SUNSTONE_INLINE Bounds refitSlot(const BuildJob& job, const NodeHead& node, uint32_t slot,
                                 uint32_t key, uint32_t numNodes, uint32_t numRecords,
                                 uint32_t& meta) {
    Bounds box = emptyBounds();
    const uint32_t mask = node.innerMask;
    meta = metaOf(node, slot);
    if (mask >> slot & 1u) {
        const uint32_t child = node.childBase + uint32_t(__popc(mask & lanesBelow(slot)));
        if (child >= numNodes)
            return box;
        const auto* const words = at<const volatile float>(nodeBoxAt(job, child, key));
        for (int a = 0; a < 3; ++a) {
            box.lower[a] = words[a];
            box.upper[a] = words[3 + a];
        }
        return box;
    }
    const LeafRun run = leafRun(meta);
    for (uint32_t k = 0; k < run.count; ++k) {
        const uint32_t place = node.primitiveBase + run.first + k;
        if (place < numRecords)
            box = unite(box, recordBounds<kMotion>(job, place, key));
    }
    if (run.count == 1 && leafLimit(job) == 1)
        meta = leafMeta(1, run.first, isEmpty(box));
    return box;
}

// The state of eight lanes: each has its slot's box, all have the node's.
struct RefitBoxes {
    Bounds own, whole;
    uint32_t meta;
};

// Eight lanes make a node; a lane's slot is its last three bits. All lanes of the warp must call.
// Stores the node's box for its parent.
template <bool kMotion>
SUNSTONE_INLINE RefitBoxes refitBoxes(const BuildJob& job, uint32_t index, const NodeHead& head,
                                      bool active, uint32_t key, uint32_t numNodes,
                                      uint32_t numRecords) {
    RefitBoxes boxes = {emptyBounds(), {}, 0};
    const uint32_t slot = laneOf() % kSlots;
    if (active)
        boxes.own = refitSlot<kMotion>(job, head, slot, key, numNodes, numRecords, boxes.meta);
    boxes.whole = uniteOfEight(boxes.own);
    if (active && slot == 0) {
        auto* const words = at<volatile float>(nodeBoxAt(job, index, key));
        for (int a = 0; a < 3; ++a) {
            words[a] = boxes.whole.lower[a];
            words[3 + a] = boxes.whole.upper[a];
        }
    }
    return boxes;
}

SUNSTONE_INLINE void storePlanes(const NodeHead& head, const RefitBoxes& boxes, WideNode& node) {
    const uint32_t slot = laneOf() % kSlots;
    const Bounds grid = gridOf(boxes.whole), &own = boxes.own;
    const bool used = boxes.meta != 0;
    node.meta[slot] = uint8_t(boxes.meta);
#pragma unroll
    for (int a = 0; a < 3; ++a) {
        const uint32_t exponent = stepExponent(sub(grid.upper[a], grid.lower[a]));
        const float inverse = inverseStep(exponent);
        node.planes[a][slot] = uint8_t(used ? lowerByte(own.lower[a], grid.lower[a], inverse) : 0);
        node.planes[3 + a][slot] =
            uint8_t(used ? upperByte(own.upper[a], grid.lower[a], inverse) : 0);
        if (slot == 0) {
            node.origin[a] = grid.lower[a];
            node.exponents[a] = uint8_t(exponent);
        }
    }
    if (slot == 0) { // the first key has set it for all keys
        node.innerMask = uint8_t(head.innerMask);
        node.childBase = head.childBase;
        node.primitiveBase = head.primitiveBase;
    }
}

template <bool kMotion>
SUNSTONE_INLINE void updateNodes(const BuildJob& job) {
    const uint32_t numNodes = headerIn(job).numNodes, numRecords = headerIn(job).numLeaves;
    const uint32_t lane = laneOf(), step = gridDim.x * blockDim.x / kSlots;
    const uint32_t* const parents = at<const uint32_t>(job.parents);
    // The warp's four nodes, then the next ones.
    const uint32_t firstOfWarp = (globalThread() - lane) / kSlots;
    for (uint32_t first = firstOfWarp; first < numNodes; first += step) {
        uint32_t index = first + lane / kSlots;
        NodeHead head = {1, 0, 0, {0, 0}};
        uint32_t parent = kNoRef;
        if (index < numNodes) {
            head = loadHead(wideNode(job, index));
            parent = parents[index];
        }
        bool active = head.innerMask == 0;
        while (__any_sync(kWholeWarp, active)) {
            // Data for the next level up, in case this is the last child.
            const bool mayRise = active && parent < numNodes;
            NodeHead above = head;
            uint32_t parentAbove = kNoRef;
            if (mayRise) {
                above = loadHead(wideNode(job, parent));
                parentAbove = parents[parent];
            }
            RefitBoxes boxes;
            for (uint32_t key = 0; key < job.motionKeys; ++key) {
                boxes = refitBoxes<kMotion>(job, index, head, active, key, numNodes, numRecords);
                if (kMotion && active)
                    storePlanes(head, boxes, wideNode(job, index, key));
            }
            bool last = false;
            if (mayRise && lane % kSlots == 0) {
                fence();
                last = atomicAdd(at<uint32_t>(job.arrivals) + parent, 1u) + 1 ==
                       uint32_t(__popc(above.innerMask));
                fence();
            }
            if (!kMotion && active) // needs no wait
                storePlanes(head, boxes, wideNode(job, index));
            active = __shfl_sync(kWholeWarp, last, int(lane & ~7u));
            index = parent;
            head = above;
            parent = parentAbove;
        }
    }
}

// Writes the header of an update, after the records.
SUNSTONE_INLINE void finishUpdate(const BuildJob& job) {
    const Counters& counters = countersOf(job);
    if (counters.failure)
        return reportFailure(job.report, job.output, counters.failure);
    describeContents(*at<BlockHeader>(job.output), counters);
}

template <bool kMotion>
SUNSTONE_INLINE void updateNodesAndHeader(const BuildJob& given) {
    if (globalThread() == 0 && given.expected)
        finishUpdate(given);
    if (!countersOf(given).failure)
        updateNodes<kMotion>(inStructure(given));
}
SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_nodes(BuildJob given) {
    updateNodesAndHeader<false>(given);
}
// With motion keys the kernel takes twice the registers.
SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_moving_nodes(BuildJob given) {
    updateNodesAndHeader<true>(given);
}

// ---- bounds at the keys -----------------------------------------------------------------------

// Each block handles some of the keys. job.keyWords: for each key three maxima of ~orderedBits and
// three of orderedBits, zeroed before.
SUNSTONE_KERNEL sunstone_key_bounds(BuildJob given) {
    __shared__ uint32_t most[6];
    if (countersOf(given).failure)
        return;
    const BuildJob job = inStructure(given);
    const uint32_t count = headerIn(job).numLeaves, key = blockIdx.x % job.motionKeys;
    const uint32_t step = gridDim.x / job.motionKeys * blockDim.x;
    if (threadIdx.x < 6)
        most[threadIdx.x] = 0;
    __syncthreads();
    Bounds found = emptyBounds();
    for (uint32_t i = blockIdx.x / job.motionKeys * blockDim.x + threadIdx.x; i < count; i += step)
        found = unite(found, exactBounds<true>(job, i, key, true));
    if (!isEmpty(found))
        for (int a = 0; a < 3; ++a) {
            atomicMax(&most[a], ~orderedBits(found.lower[a]));
            atomicMax(&most[3 + a], orderedBits(found.upper[a]));
        }
    __syncthreads();
    if (threadIdx.x < 6)
        atomicMax(at<uint32_t>(job.keyWords) + uint64_t(key) * 6 + threadIdx.x, most[threadIdx.x]);
}

SUNSTONE_KERNEL sunstone_key_finish(BuildJob given) {
    if (countersOf(given).failure)
        return;
    const BuildJob job = inStructure(given);
    const bool any = headerIn(job).numActive != 0;
    for (uint32_t key = globalThread(); key < job.motionKeys; key += gridDim.x * blockDim.x) {
        const uint32_t* const words = at<const uint32_t>(job.keyWords) + uint64_t(key) * 6;
        KeyBounds& to = at<KeyBounds>(job.keyBounds)[key];
        for (int a = 0; a < 3; ++a) {
            to.lower[a] = any ? fromOrdered(~words[a]) : __builtin_inff();
            to.upper[a] = any ? fromOrdered(words[3 + a]) : -__builtin_inff();
        }
    }
}

} // namespace sunstone::bvh::gpu
