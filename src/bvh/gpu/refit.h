// SPDX-License-Identifier: Apache-2.0
// Updates: the tree stays; primitives are read anew and boxes are computed from the leaves up.
//
//   update_check    is this the structure that the host thinks it is? If not, nothing is touched
//   update_records  the record of each primitive; bounds and number of the active ones
//   update_links    each node's parent
//   update_nodes    eight lanes make a node, one each slot. Whoever brings the last child of a node
//                   goes on with it, as in the build's climb; nobody waits
//   update_finish   the header
//
// Every box is a minimum and maximum over the same numbers whatever the order in which threads run,
// so that equal input gives equal bytes; an update from the input of the build gives the nodes and
// records of the build.
//
// What a kind of primitives provides:
//   updateRecord    writes a record from what the record itself tells of its primitive (SBT index
//   and
//                   primitive index), or says that the primitive is inactive
//   recordBounds    the padded box of a record, empty if it is inactive, from the record alone or
//                   from what updateRecord left in job.boxes (UpdatePlan has the room for it)
// With motion keys a node is made at one key after the other, with its boxes at all keys in
// nodeBoxes. A build with motion ends with the same steps: its tree knows the means of boxes only.
#pragma once

#include "bvh/gpu/finish.h"
#include "bvh/gpu/grid.h"
#include "bvh/gpu/instances.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kRefitThreads = 256;

// Places in the structure are where its header says, be it compacted or not.
SUNSTONE_BUILDER BuildJob inStructure(BuildJob job) {
    const BlockHeader& header = *at<const BlockHeader>(job.output);
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
SUNSTONE_BUILDER const BlockHeader& headerIn(const BuildJob& job) {
    return *at<const BlockHeader>(job.output);
}

// The host has the same rules: Builder::checkUpdate.
SUNSTONE_BUILDER bool isExpected(const BuildJob& job) {
    const BlockHeader& is = headerIn(job);
    const BlockHeader& wanted = *at<const BlockHeader>(job.expected);
    return is.magic == kGpuBlockMagic && is.version == wanted.version && is.type == wanted.type &&
           is.options == wanted.options && (is.options & kOptionUpdate) &&
           is.motionKeys == wanted.motionKeys && is.motionFlags == wanted.motionFlags &&
           is.motionBegin == wanted.motionBegin && is.motionEnd == wanted.motionEnd &&
           is.shape == wanted.shape && is.numInputs == wanted.numInputs &&
           is.numPrimitives == wanted.numPrimitives && is.inputsOffset == wanted.inputsOffset &&
           is.usedSize <= job.outputSize && is.numNodes <= job.maxWide &&
           is.numLeaves <= job.maxReferences;
}

SUNSTONE_BUILDER bool hasSameMicromaps(const BuildJob& job, uint32_t i) {
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[i];
    const uint64_t table = headerIn(job).micromapsOffset;
    if (table == 0)
        return input.micromapIndexing == 0;
    const MicromapRecord& is = at<const MicromapRecord>(job.output + table)[i];
    return is.indexing == input.micromapIndexing &&
           (is.indexing == 0 || input.mayChangeMicromaps || is.array == input.micromaps);
}

// One block.
SUNSTONE_KERNEL sunstone_update_check(BuildJob job) {
    bool same = isExpected(job);
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

// The build input that a record's SBT word tells of.
SUNSTONE_BUILDER uint32_t inputOfSbtWord(const BuildJob& job, uint32_t word) {
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
// updates are allowed) in word 9; the SBT word is behind it. Without motion its box will be at its
// place.
template <bool kMotion>
SUNSTONE_BUILDER bool updateShapeRecord(const BuildJob& job, uint32_t place, const uint32_t* words,
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

// With kMotion what has motion keys, and instances that the other kernel has left.
template <bool kMotion>
SUNSTONE_BUILDER bool updateRecord(const BuildJob& job, uint32_t place, Bounds& exact) {
    if (job.type == BlockType::kInstances) {
        const uint32_t index = at<const uint32_t>(job.records)[place];
        return index < job.numPrimitives && (!kMotion || isForLater(job, index)) &&
               readInstance<kMotion>(job, index, exact);
    }
    const auto* const words = at<const uint32_t>(recordAt(job, place, 0));
    if (job.type == BlockType::kShapes)
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

// What a record holds at a key, not padded; or the whole primitive, of which it may hold a piece, or
// what is told of it. Of instances, curves and spheres with motion keys alone.
template <bool kMotion>
SUNSTONE_BUILDER Bounds exactBounds(const BuildJob& job, uint32_t place, uint32_t key, bool whole) {
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
SUNSTONE_BUILDER Bounds recordBounds(const BuildJob& job, uint32_t place, uint32_t key) {
    if (!kMotion && job.type == BlockType::kInstances) {
        const uint32_t index = at<const uint32_t>(job.records)[place];
        return index < job.numPrimitives ? primitiveBounds(job, index) : emptyBounds();
    }
    if (!kMotion && job.type == BlockType::kShapes)
        return primitiveBounds(job, place);
    const Bounds box = exactBounds<kMotion>(job, place, key, false);
    return isEmpty(box) ? emptyBounds() : padBounds(box);
}

template <bool kMotion>
SUNSTONE_BUILDER void updateRecords(const BuildJob& job) {
    const uint32_t count = headerIn(job).numLeaves;
    Bounds found = emptyBounds();
    uint32_t numActive = 0;
    for (uint32_t i = globalThread(); i < count; i += gridDim.x * blockDim.x) {
        Bounds exact;
        if (updateRecord<kMotion>(job, i, exact)) {
            found = unite(found, exact);
            ++numActive;
        }
    }
    addToCounters(job, found, numActive);
}

SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_records(BuildJob given) {
    if (!countersOf(given).failure)
        updateRecords<false>(inStructure(given));
}
SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_moving_records(BuildJob given) {
    if (!countersOf(given).failure && (given.motionKeys > 1 || countersOf(given).leftInstances))
        updateRecords<true>(inStructure(given));
}

// ---- nodes ------------------------------------------------------------------------------------

SUNSTONE_BUILDER WideNode& wideNode(const BuildJob& job, uint32_t index, uint32_t key = 0) {
    return at<WideNode>(job.nodes)[uint64_t(index) * job.motionKeys + key];
}
SUNSTONE_BUILDER uint64_t nodeBoxAt(const BuildJob& job, uint32_t index, uint32_t key) {
    return job.nodeBoxes + (uint64_t(index) * job.motionKeys + key) * sizeof(PrimitiveBox);
}

SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_links(BuildJob given) {
    if (countersOf(given).failure)
        return;
    const BuildJob job = inStructure(given);
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

// What a slot holds now; sets its meta byte where that tells of it. `node` is that of the first
// key.
template <bool kMotion>
SUNSTONE_BUILDER Bounds refitSlot(const BuildJob& job, WideNode& node, uint32_t slot, uint32_t key,
                                  uint32_t numNodes, uint32_t numRecords) {
    Bounds box = emptyBounds();
    const uint32_t mask = node.innerMask;
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
    const LeafRun run = leafRun(node.meta[slot]);
    for (uint32_t k = 0; k < run.count; ++k) {
        const uint32_t place = node.primitiveBase + run.first + k;
        if (place < numRecords)
            box = unite(box, recordBounds<kMotion>(job, place, key));
    }
    if (run.count == 1 && leafLimit(job) == 1)
        node.meta[slot] = uint8_t(leafMeta(1, run.first, isEmpty(box)));
    return box;
}

SUNSTONE_BUILDER Bounds uniteOfEight(Bounds box) {
    for (uint32_t step = 1; step < kSlots; step *= 2) {
        Bounds other;
        for (int a = 0; a < 3; ++a) {
            other.lower[a] = __shfl_xor_sync(kWholeWarp, box.lower[a], int(step));
            other.upper[a] = __shfl_xor_sync(kWholeWarp, box.upper[a], int(step));
        }
        box = unite(box, other);
    }
    return box;
}

// By eight lanes, whose slots are their last three bits; all lanes of the warp take part.
template <bool kMotion>
SUNSTONE_BUILDER void refitNode(const BuildJob& job, uint32_t index, bool active, uint32_t key,
                                uint32_t numNodes, uint32_t numRecords) {
    const uint32_t slot = laneOf() & 7u;
    WideNode& first = wideNode(job, active ? index : 0);
    WideNode& node = wideNode(job, active ? index : 0, key);
    const Bounds own =
        active ? refitSlot<kMotion>(job, first, slot, key, numNodes, numRecords) : emptyBounds();
    const Bounds whole = uniteOfEight(own), grid = gridOf(whole);
    if (!active)
        return;
    if (key > 0) {
        node.meta[slot] = first.meta[slot];
        if (slot == 0) {
            node.innerMask = first.innerMask;
            node.childBase = first.childBase;
            node.primitiveBase = first.primitiveBase;
        }
    }
    for (int a = 0; a < 3; ++a) {
        const uint32_t exponent = stepExponent(sub(grid.upper[a], grid.lower[a]));
        const float inverse = inverseStep(exponent);
        const bool used = node.meta[slot] != 0;
        node.planes[a][slot] = uint8_t(used ? lowerByte(own.lower[a], grid.lower[a], inverse) : 0);
        node.planes[3 + a][slot] =
            uint8_t(used ? upperByte(own.upper[a], grid.lower[a], inverse) : 0);
        if (slot == 0) {
            node.origin[a] = grid.lower[a];
            node.exponents[a] = uint8_t(exponent);
            auto* const words = at<volatile float>(nodeBoxAt(job, index, key));
            words[a] = whole.lower[a];
            words[3 + a] = whole.upper[a];
        }
    }
}

template <bool kMotion>
SUNSTONE_BUILDER void updateNodes(const BuildJob& job) {
    const uint32_t numNodes = headerIn(job).numNodes, numRecords = headerIn(job).numLeaves;
    const uint32_t lane = laneOf(), step = gridDim.x * blockDim.x / kSlots;
    // The warp's four nodes, then the next ones.
    const uint32_t firstOfWarp = (globalThread() - lane) / kSlots;
    for (uint32_t first = firstOfWarp; first < numNodes; first += step) {
        uint32_t index = first + lane / kSlots;
        bool active = index < numNodes && wideNode(job, index).innerMask == 0;
        while (__any_sync(kWholeWarp, active)) {
            for (uint32_t key = 0; key < job.motionKeys; ++key)
                refitNode<kMotion>(job, index, active, key, numNodes, numRecords);
            // Up, if this was the last child.
            uint32_t next = kNoRef;
            if (active && lane % kSlots == 0) {
                const uint32_t parent = at<const uint32_t>(job.parents)[index];
                __threadfence();
                if (parent < numNodes && atomicAdd(at<uint32_t>(job.arrivals) + parent, 1u) + 1 ==
                                             uint32_t(__popc(wideNode(job, parent).innerMask)))
                    next = parent;
                __threadfence();
            }
            index = __shfl_sync(kWholeWarp, next, int(lane & ~7u));
            active = index != kNoRef;
        }
    }
}

SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_nodes(BuildJob given) {
    if (!countersOf(given).failure)
        updateNodes<false>(inStructure(given));
}
// What moves takes twice the registers.
SUNSTONE_KERNEL __launch_bounds__(kRefitThreads) sunstone_update_moving_nodes(BuildJob given) {
    if (!countersOf(given).failure)
        updateNodes<true>(inStructure(given));
}

// ---- bounds at the keys -----------------------------------------------------------------------

// Blocks share the keys among themselves. job.keyWords: for each key three maxima of ~orderedBits
// and three of orderedBits, zeroed before.
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

// ---- the end ----------------------------------------------------------------------------------

SUNSTONE_KERNEL sunstone_update_finish(BuildJob job) {
    const Counters& counters = countersOf(job);
    if (counters.failure)
        return reportFailure(job.report, job.output, counters.failure);
    describeContents(*at<BlockHeader>(job.output), counters);
}

} // namespace sunstone::bvh::gpu
