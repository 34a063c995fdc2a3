// SPDX-License-Identifier: Apache-2.0
// Fifth step: moves nodes and records to places that depend on the tree alone, so that equal inputs
// give equal bytes. Until then their places depend on the order in which threads ran.
//
//   nodes     the children of a node in sequence, followed by all nodes below the first child, then
//             by those below the second, and so on
//   records   those of its leaves, followed by all records below its first child, and so on
//
//   subtrees  from the leaves up: the number of nodes and records before each child. The thread
//             that completes a node's last child continues with the node, as in an update
//   arrange   each node adds these numbers up on its way to the root and is copied to scratch
//             memory; the kernel that writes the records copies the nodes back
//
// Collapsing leaves each node's parent in job.links and a subtreeWord() in place of its task. At
// first this word counts the node and its own records, then all nodes and records below it. After
// all children of its parent are counted, it holds the place of its first descendant, relative to
// that of its parent, and its number among the children.
#pragma once

#include "bvh/gpu/build/collapse.h"
#include "bvh/gpu/build/finish.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kArrangeThreads = 256;

SUNSTONE_INLINE uint64_t* subtreesOf(const BuildJob& job) {
    return at<uint64_t>(job.tasks);
}

SUNSTONE_INLINE uint32_t nodesIn(uint64_t subtree) {
    return uint32_t(subtree) & kSubtreeMask;
}
SUNSTONE_INLINE uint32_t recordsIn(uint64_t subtree) {
    return uint32_t(subtree >> kSubtreeBits) & kSubtreeMask;
}
SUNSTONE_INLINE uint32_t childrenIn(uint64_t subtree) {
    return uint32_t(subtree >> 2 * kSubtreeBits);
}

// The most polls for a word that is complete or about to be. The thread that completes a node's
// last child knows that the other children are done, and waits until their words are visible. In a
// broken tree the limit ends the wait.
constexpr uint32_t kMostLooks = 1 << 16;

SUNSTONE_INLINE bool loadSubtrees(const uint64_t* from, uint32_t count, uint64_t to[kSlots]) {
    for (uint32_t looks = 0; looks < kMostLooks; ++looks) {
        bool whole = true;
#pragma unroll
        for (uint32_t k = 0; k < kSlots; ++k) {
            to[k] = k < count ? loadFresh(from + k) : 0;
            whole = whole && (k >= count || childrenIn(to[k]) == kSlots);
        }
        if (whole)
            return true;
    }
    return false;
}

// Gives the children of a node the places of their first descendants.
SUNSTONE_INLINE void placeChildren(const BuildJob& job, uint32_t index, uint64_t subtree,
                                   uint32_t numNodes) {
    const U4* const words = reinterpret_cast<const U4*>(&wideNode(job, index));
    const uint32_t count = uint32_t(__popc(words[0].w >> 24)), first = words[1].x;
    uint64_t* const children = subtreesOf(job) + first;
    uint64_t below[kSlots];
    if (first > numNodes || count > numNodes - first || !loadSubtrees(children, count, below)) {
        atomicExch(&countersOf(job).failure, uint32_t(kTreeBroken));
        return;
    }
    uint32_t records = recordsIn(subtree), nodes = count;
#pragma unroll
    for (uint32_t k = 0; k < kSlots; ++k)
        records -= recordsIn(below[k]); // leaves the node's own
#pragma unroll
    for (uint32_t k = 0; k < kSlots; ++k)
        if (k < count) {
            children[k] = subtreeWord(nodes, records, k);
            nodes += nodesIn(below[k]) - 1;
            records += recordsIn(below[k]);
        }
}

SUNSTONE_INLINE void countSubtrees(const BuildJob& job) {
    const Counters& counters = countersOf(job);
    if (!isWhole(counters))
        return;
    const uint32_t numNodes = uint32_t(counters.allocated);
    uint64_t* const subtrees = subtreesOf(job);
    const uint32_t* const links = at<const uint32_t>(job.links);
    for (uint32_t i = globalThread(); i < numNodes; i += gridDim.x * blockDim.x) {
        // Starts at nodes without inner children; threads reach all other nodes from below.
        uint64_t subtree = loadFresh(subtrees + i);
        if (childrenIn(subtree) != kSlots || nodesIn(subtree) != 1)
            continue;
        uint32_t index = i, parent = links[i];
        // No path is longer.
        for (uint32_t level = 0; level < kMaxWideDepth; ++level) {
            const bool rises = index != 0 && parent < numNodes;
            uint32_t above = 0;
            uint64_t known = 0;
            if (rises) {
                const uint64_t more = subtreeWord(nodesIn(subtree), recordsIn(subtree), 1);
                known = more + atomicAdd(reinterpret_cast<unsigned long long*>(subtrees + parent),
                                         (unsigned long long)(more));
                above = links[parent];
            }
            if (level > 0) // while the load is in flight
                placeChildren(job, index, subtree, numNodes);
            if (!rises || childrenIn(known) != kSlots)
                break;
            index = parent;
            parent = above;
            subtree = known;
        }
    }
}

SUNSTONE_KERNEL __launch_bounds__(kArrangeThreads) sunstone_subtrees(BuildJob job) {
    countSubtrees(job);
}

// The place of a node, and of its first descendants.
struct NewPlace {
    uint32_t index, childBase, primitiveBase;
};
SUNSTONE_INLINE NewPlace newPlaceOf(const BuildJob& job, uint32_t index, uint32_t numNodes) {
    if (index == 0)
        return {0, 1, 0};
    const uint64_t* const subtrees = subtreesOf(job);
    const uint32_t* const links = at<const uint32_t>(job.links);
    const uint64_t own = subtrees[index];
    uint32_t nodes = 1, records = 0, above = links[index];
    for (uint32_t level = 1; level < kMaxWideDepth && above != 0 && above < numNodes; ++level) {
        const uint64_t word = subtrees[above];
        above = links[above];
        nodes += nodesIn(word);
        records += recordsIn(word);
    }
    return {nodes + childrenIn(own), nodes + nodesIn(own), records + recordsIn(own)};
}

// Eight lanes move a node. Each lane has a part of its bytes and the references of one slot's leaf.
struct MovedPart {
    U4 words;
    uint32_t references[kMaxLeafPrimitives];
    LeafRun run;
    bool fits;
};

// Loads the bytes of a node, then the data that they refer to. All lanes of the warp must call.
SUNSTONE_INLINE U4 loadPart(const BuildJob& job, uint32_t index, uint32_t numNodes) {
    const uint32_t slot = laneOf() % kSlots;
    if (index >= numNodes || slot >= sizeof(WideNode) / 16)
        return U4{0, 0, 0, 0};
    return reinterpret_cast<const U4*>(&wideNode(job, index))[slot];
}
SUNSTONE_INLINE void loadReferences(const BuildJob& job, const NewPlace& to, MovedPart& part) {
    const uint32_t slot = laneOf() % kSlots, count = countersOf(job).numTreeReferences;
    const int lane = int(laneOf() - slot);
    const uint32_t innerMask = __shfl_sync(kWholeWarp, part.words.w, lane) >> 24,
                   base = __shfl_sync(kWholeWarp, part.words.y, lane + 1),
                   low = __shfl_sync(kWholeWarp, part.words.z, lane + 1),
                   high = __shfl_sync(kWholeWarp, part.words.w, lane + 1);
    part.run = {0, 0};
    if (!(innerMask >> slot & 1u))
        part.run = leafRun((slot < 4 ? low : high) >> 8 * (slot % 4) & 0xFFu);
    const uint32_t end = part.run.first + part.run.count;
    part.fits = base + end <= count && to.primitiveBase + end <= count;
    const uint32_t* const order = at<const uint32_t>(job.order) + base + part.run.first;
    for (uint32_t k = 0; k < kMaxLeafPrimitives; ++k)
        part.references[k] = part.fits && k < part.run.count ? order[k] : 0;
}

SUNSTONE_INLINE void storePart(const BuildJob& job, const MovedPart& part, const NewPlace& to) {
    const uint32_t slot = laneOf() % kSlots;
    uint32_t* const order = at<uint32_t>(job.newOrder) + to.primitiveBase + part.run.first;
    for (uint32_t k = 0; k < kMaxLeafPrimitives; ++k)
        if (k < part.run.count)
            order[k] = part.references[k];
    if (slot < sizeof(WideNode) / 16)
        at<U4>(job.newNodes + uint64_t(to.index) * sizeof(WideNode))[slot] =
            slot == 1 ? U4{to.childBase, to.primitiveBase, part.words.z, part.words.w} : part.words;
}

// Each lane finds the places of one node. Then eight lanes together move a node; they move several
// nodes, whose memory latencies overlap.
SUNSTONE_INLINE void arrangeNodes(const BuildJob& job) {
    constexpr uint32_t kTogether = 4, kNodesOfWarp = 32 / kSlots;
    const Counters& counters = countersOf(job);
    if (!isWhole(counters))
        return;
    const uint32_t numNodes = uint32_t(counters.allocated), lane = laneOf();
    if (numNodes != 0 &&
        subtreesOf(job)[0] != subtreeWord(numNodes, counters.numTreeReferences, kSlots)) {
        atomicExch(&countersOf(job).failure, uint32_t(kTreeBroken)); // a stray write has changed it
        return;
    }
    for (uint32_t first = globalThread() - lane; first < numNodes;
         first += gridDim.x * blockDim.x) {
        NewPlace own = {};
        if (first + lane < numNodes)
            own = newPlaceOf(job, first + lane, numNodes);
#pragma unroll
        for (uint32_t begin = 0; begin < 32; begin += kTogether * kNodesOfWarp) {
            const uint32_t from = begin + lane / kSlots;
            MovedPart parts[kTogether];
#pragma unroll
            for (uint32_t k = 0; k < kTogether; ++k)
                parts[k].words = loadPart(job, first + from + k * kNodesOfWarp, numNodes);
            NewPlace places[kTogether];
#pragma unroll
            for (uint32_t k = 0; k < kTogether; ++k) {
                const int lane = int(from + k * kNodesOfWarp);
                places[k] = {__shfl_sync(kWholeWarp, own.index, lane),
                             __shfl_sync(kWholeWarp, own.childBase, lane),
                             __shfl_sync(kWholeWarp, own.primitiveBase, lane)};
                loadReferences(job, places[k], parts[k]);
            }
#pragma unroll
            for (uint32_t k = 0; k < kTogether; ++k) {
                if (first + from + k * kNodesOfWarp >= numNodes)
                    continue;
                if (parts[k].fits && places[k].index < numNodes)
                    storePart(job, parts[k], places[k]);
                else
                    atomicExch(&countersOf(job).failure, uint32_t(kTreeBroken));
            }
        }
    }
}

SUNSTONE_KERNEL __launch_bounds__(kArrangeThreads) sunstone_arrange(BuildJob job) {
    arrangeNodes(job);
}

} // namespace sunstone::bvh::gpu
