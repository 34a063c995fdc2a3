// SPDX-License-Identifier: Apache-2.0
// Fourth step: wide nodes. Eight lanes make one node, a lane for each child: they open children, as
// many at a time as possible, until there are eight, and assign them to slots. Each lane rounds the
// box of its slot. Inner children become tasks. Task i makes node i; idle lanes take tasks in
// order.
//
// Lanes poll for their task. Polling ends under any scheduling: a task comes from a thread that
// already runs, and the thread that finds all primitives in leaves releases the waiting threads.
// For any tree, even a broken one, threads stop once all assigned nodes are written: there are at
// most job.maxWide tasks, and a task without room for its children fails the build. Node numbers
// depend on timing; arrange.h makes the order deterministic.
#pragma once

#include "bvh/gpu/build/grid.h"
#include "bvh/gpu/build/hierarchy.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kCollapseThreads = 128;
constexpr uint32_t kNodesOfBlock = kCollapseThreads / kSlots;

SUNSTONE_INLINE bool isLeaf(uint32_t ref, uint32_t limit) {
    return refCount(ref) != 0 && refCount(ref) <= limit;
}

// A child of the node that is made: its box, and of a binary node its parts.
struct WideChild {
    uint32_t ref, left, right;
    Bounds box;
};

SUNSTONE_INLINE WideChild loadChild(const BuildJob& job, uint32_t ref) {
    if (refCount(ref) == 1)
        return {ref, 0, 0, primitiveBounds(job, refIndex(ref))};
    const U4* const words = at<const U4>(job.binary + uint64_t(refIndex(ref)) * sizeof(BinaryNode));
    const U4 a = words[0], b = words[1];
    return {
        ref,
        a.w,
        b.w,
        {{floatOf(a.x), floatOf(a.y), floatOf(a.z)}, {floatOf(b.x), floatOf(b.y), floatOf(b.z)}}};
}

SUNSTONE_INLINE WideChild shuffleFrom(const WideChild& c, uint32_t lane) {
    WideChild r;
    r.ref = __shfl_sync(kWholeWarp, c.ref, int(lane));
    r.left = __shfl_sync(kWholeWarp, c.left, int(lane));
    r.right = __shfl_sync(kWholeWarp, c.right, int(lane));
    for (int a = 0; a < 3; ++a) {
        r.box.lower[a] = __shfl_sync(kWholeWarp, c.box.lower[a], int(lane));
        r.box.upper[a] = __shfl_sync(kWholeWarp, c.box.upper[a], int(lane));
    }
    return r;
}

SUNSTONE_INLINE CostPart costPart(const BuildJob& job, const WideChild& c) {
    return {refCount(c.ref), halfArea(c.box),
            refCount(c.ref) == 1 ? 0 : at<const uint64_t>(job.savings)[refIndex(c.ref)]};
}

// Eight lanes that make a node. All functions below are for whole warps.
struct NodeLanes {
    uint32_t first; // lane
    uint32_t place; // of this lane among them: its child's number, later its slot's
};
// The lanes' bits in a word of the warp's.
SUNSTONE_INLINE uint32_t bitsOf(const NodeLanes& lanes, uint32_t ballot) {
    return ballot >> lanes.first & 0xFFu;
}

// Lanes that open a child pass its right part to lanes without a child. Returns the lane from which
// this lane's child comes, or this lane.
SUNSTONE_INLINE uint32_t takeFrom(const NodeLanes& lanes, uint32_t opening, uint32_t count) {
    const uint32_t mine = bitsOf(lanes, opening), place = lanes.place;
    if (place < count || place - count >= uint32_t(__popc(mine)))
        return lanes.first + place;
    uint32_t rest = mine;
    for (uint32_t skipped = count; skipped < place; ++skipped)
        rest &= rest - 1;
    return lanes.first + uint32_t(__ffs(int(rest)) - 1);
}

// Replaces opened children by their parts. `from`: as takeFrom() says.
SUNSTONE_INLINE void openChildren(const NodeLanes& lanes, bool opens, const WideChild& left,
                                  const WideChild& right, WideChild& own, uint32_t& count,
                                  uint32_t& from) {
    const uint32_t opening = __ballot_sync(kWholeWarp, opens);
    from = takeFrom(lanes, opening, count);
    const WideChild moved = shuffleFrom(right, from);
    if (opens)
        own = left;
    else if (from != lanes.first + lanes.place)
        own = moved;
    count += uint32_t(__popc(bitsOf(lanes, opening)));
}

// Opens children by cost; each has a budget of slots for its descendants.
SUNSTONE_INLINE void openByCosts(const BuildJob& job, const NodeLanes& lanes, bool ready,
                                 WideChild& own, uint32_t& count) {
    uint32_t budget = ready && lanes.place == 0 ? kSlots : 0;
    for (;;) {
        const bool looks = budget > 1 && refCount(own.ref) != 1;
        if (!__any_sync(kWholeWarp, looks))
            return;
        WideChild left = own, right = own;
        uint32_t ofLeft = 1;
        bool opens = false;
        if (looks) {
            left = loadChild(job, own.left);
            right = loadChild(job, own.right);
            const CostPart leftPart = costPart(job, left), rightPart = costPart(job, right);
            const Savings l = unpackSavings(leftPart), r = unpackSavings(rightPart);
            const float saved = shareAnySlots(l, rightPart, budget, ofLeft);
            // The node itself (eight slots) must be opened.
            opens = budget == kSlots ||
                    add(excessOf(job, halfArea(unite(left.box, right.box)),
                                 isLeaf(own.ref, leafLimit(job)), leftPart, rightPart, l, r),
                        saved) > 0;
        }
        uint32_t from;
        openChildren(lanes, opens, left, right, own, count, from);
        const uint32_t ofRight = __shfl_sync(kWholeWarp, budget - ofLeft, int(from));
        budget = opens ? ofLeft : from != lanes.first + lanes.place ? ofRight : looks ? 0 : budget;
    }
}

// The maximum over eight lanes.
SUNSTONE_INLINE uint32_t largestOf(uint32_t number) {
    for (uint32_t step = 1; step < kSlots; step *= 2) {
        const uint32_t other = __shfl_xor_sync(kWholeWarp, number, int(step));
        number = other > number ? other : number;
    }
    return number;
}

// Opens children while there are free slots: first inner children, the largest or (by level) the
// highest, then leaves of several primitives. A node has fewer than eight children only if none can
// be opened.
SUNSTONE_INLINE void openWhileRoom(const BuildJob& job, TreeMode mode, const NodeLanes& lanes,
                                   bool ready, WideChild& own, uint32_t& count) {
    const uint32_t limit = leafLimit(job);
    uint32_t level = 0;
    for (;;) {
        const bool may = ready && lanes.place < count && count < kSlots && refCount(own.ref) != 1;
        if (!__any_sync(kWholeWarp, may))
            return;
        // Areas are not negative, so their bits are in order. The last four bits make room for the
        // child's number.
        const uint32_t rank = mode == kRadixByLevel ? (32 - level) << 4
                                                    : bitsOf(halfArea(own.box)) & ~15u,
                       inner = isLeaf(own.ref, limit) ? 0 : 1u << 31;
        const uint32_t number = may ? inner | rank | (kSlots - lanes.place) : 0;
        const bool opens = largestOf(number) == number && may;
        WideChild left = own, right = own;
        if (opens) {
            left = loadChild(job, own.left);
            right = loadChild(job, own.right);
            ++level;
        }
        uint32_t from;
        openChildren(lanes, opens, left, right, own, count, from);
        level = __shfl_sync(kWholeWarp, level, int(from));
    }
}

// The child of each lane's slot, kSlots: none. Children take the slot of their side of the node,
// the outermost ones first.
SUNSTONE_INLINE uint32_t assignSlots(const NodeLanes& lanes, const WideChild& own, uint32_t count,
                                     const Bounds& whole) {
    float off[3];
    for (int a = 0; a < 3; ++a)
        off[a] = sub(add(own.box.lower[a], own.box.upper[a]), add(whole.lower[a], whole.upper[a]));
    // The fit of a slot in 26 bits, and in the other bits the child and the slot in reverse order;
    // 0: none. The precision suffices, because nearly equal fits may count as equal.
    uint32_t fits[kSlots], child = kSlots;
#pragma unroll
    for (uint32_t s = 0; s < kSlots; ++s) {
        const uint32_t bits = orderedBits(
            add(add(s & 1 ? off[0] : -off[0], s & 2 ? off[1] : -off[1]), s & 4 ? off[2] : -off[2]));
        fits[s] = lanes.place >= count
                      ? 0
                      : ((bits < 64 ? 64 : bits) & ~63u) | (7 - lanes.place) << 3 | (7 - s);
    }
#pragma unroll
    for (uint32_t i = 0; i < kSlots; ++i) {
        uint32_t most[kSlots];
#pragma unroll
        for (uint32_t s = 0; s < kSlots; ++s)
            most[s] = fits[s];
#pragma unroll
        for (uint32_t half = kSlots / 2; half > 0; half /= 2)
#pragma unroll
            for (uint32_t s = 0; s < half; ++s)
                most[s] = most[s] > most[s + half] ? most[s] : most[s + half];
        const uint32_t best = largestOf(most[0]);
        const uint32_t winner = 7 - (best >> 3 & 7u), slot = 7 - (best & 7u);
        if (best != 0 && slot == lanes.place)
            child = winner;
#pragma unroll
        for (uint32_t s = 0; s < kSlots; ++s)
            fits[s] = best != 0 && (s == slot || winner == lanes.place) ? 0 : fits[s];
    }
    return child;
}

// Lists the references of a leaf's primitives, left to right.
SUNSTONE_INLINE void listPrimitives(const BuildJob& job, const WideChild& leaf, uint32_t* to) {
    if (refCount(leaf.ref) == 1) {
        *to = leaf.ref;
        return;
    }
    const uint32_t parts[2] = {leaf.left, leaf.right};
    for (uint32_t part : parts) {
        if (refCount(part) == 1) {
            *to++ = part;
        } else { // of two
            const WideChild pair = loadChild(job, part);
            *to++ = pair.left;
            *to++ = pair.right;
        }
    }
}

// The slots of a warp's lanes, or their children in any order: a bit for each inner child, and two
// for the number of a leaf's primitives.
struct LaneChildren {
    uint32_t inner, ones, twos;
};
SUNSTONE_INLINE uint32_t innerIn(const LaneChildren& c, uint32_t lanes) {
    return uint32_t(__popc(c.inner & lanes));
}
SUNSTONE_INLINE uint32_t primitivesIn(const LaneChildren& c, uint32_t lanes) {
    return uint32_t(__popc(c.ones & lanes)) + 2 * uint32_t(__popc(c.twos & lanes));
}
SUNSTONE_INLINE LaneChildren countChildren(bool used, uint32_t ref, uint32_t limit) {
    const uint32_t primitives = used && isLeaf(ref, limit) ? refCount(ref) : 0;
    return {__ballot_sync(kWholeWarp, used && primitives == 0),
            __ballot_sync(kWholeWarp, (primitives & 1u) != 0),
            __ballot_sync(kWholeWarp, (primitives & 2u) != 0)};
}

// The word in place of a node's task, for arrange.h: the numbers of nodes and records counted below
// it so far, and how many of its eight children need no wait.
constexpr uint32_t kSubtreeBits = kRefCountShift, kSubtreeMask = kRefIndexMask;
SUNSTONE_INLINE uint64_t subtreeWord(uint32_t nodes, uint32_t records, uint32_t children) {
    return uint64_t(children) << 2 * kSubtreeBits | uint64_t(records) << kSubtreeBits | nodes;
}

// The places of a node's children, within the room that the warp has reserved.
struct NodePlace {
    uint32_t index, depth;
    uint32_t childBase, primitiveBase;
};

// Called by lanes that have their slots' children; all eight assemble `image`.
SUNSTONE_INLINE void describeSlot(const BuildJob& job, const NodeLanes& lanes, bool used,
                                  const WideChild& own, const Bounds& whole,
                                  const LaneChildren& all, const NodePlace& place,
                                  WideNode& image) {
    const uint32_t limit = leafLimit(job), slot = lanes.place;
    const uint32_t before = lanesBelow(laneOf()) & ~lanesBelow(lanes.first);
    uint32_t meta = 0;
    if (used && !isLeaf(own.ref, limit)) { // first the words for which others wait
        meta = 1u << 5 | (24 + slot);
        const uint32_t child = place.childBase + innerIn(all, before);
        *(at<volatile uint64_t>(job.tasks) + child) = uint64_t(place.depth + 1) << 32 | own.ref;
        at<uint32_t>(job.links)[child] = place.index;
    }
    if (used && isLeaf(own.ref, limit)) {
        const uint32_t first = primitivesIn(all, before);
        meta = leafMeta(refCount(own.ref), first, limit == 1 && isEmpty(own.box));
        listPrimitives(job, own, at<uint32_t>(job.order) + place.primitiveBase + first);
    }
    image.meta[slot] = uint8_t(meta);
#pragma unroll
    for (int a = 0; a < 3; ++a) {
        const uint32_t exponent = stepExponent(sub(whole.upper[a], whole.lower[a]));
        const float inverse = inverseStep(exponent);
        image.planes[a][slot] =
            uint8_t(used ? lowerByte(own.box.lower[a], whole.lower[a], inverse) : 0);
        image.planes[3 + a][slot] =
            uint8_t(used ? upperByte(own.box.upper[a], whole.lower[a], inverse) : 0);
        if (slot == 0) {
            image.origin[a] = whole.lower[a];
            image.exponents[a] = uint8_t(exponent);
        }
    }
    if (slot == 0) {
        image.innerMask = uint8_t(bitsOf(lanes, all.inner));
        image.childBase = place.childBase;
        image.primitiveBase = place.primitiveBase;
        const uint32_t mine = 0xFFu << lanes.first;
        at<uint64_t>(job.tasks)[place.index] =
            subtreeWord(1, primitivesIn(all, mine), kSlots - innerIn(all, mine));
    }
}

// Values of a task: not yet assigned; no further tasks.
constexpr uint64_t kNoTask = ~0ull, kNoMoreTasks = ~1ull;

// The warp that completes the tree releases the groups of lanes that wait for tasks. Each group
// waits for at most one task.
SUNSTONE_INLINE void endTasks(const BuildJob& job, uint32_t numNodes) {
    const uint64_t waiting = uint64_t(numNodes) + gridDim.x * kNodesOfBlock;
    const uint64_t end = waiting < job.maxWide ? waiting : job.maxWide;
    for (uint64_t i = numNodes + laneOf(); i < end; i += 32)
        at<volatile uint64_t>(job.tasks)[i] = kNoMoreTasks;
}

// Makes the nodes whose tasks the warp's lanes have.
SUNSTONE_INLINE void makeNodes(const BuildJob& job, TreeMode mode, const NodeLanes& lanes,
                               bool ready, uint32_t index, uint64_t task, WideNode& image) {
    Counters& counters = countersOf(job);
    const uint32_t numActive = counters.numTreeReferences, limit = leafLimit(job);
    uint32_t count = ready;
    WideChild own = {1u << kRefCountShift, 0, 0, emptyBounds()};
    if (ready && lanes.place == 0)
        own = loadChild(job, uint32_t(task));
    if (mode == kClustered)
        openByCosts(job, lanes, ready, own, count);
    openWhileRoom(job, mode, lanes, ready, own, count);

    // Reserves room for the children while slots are found.
    LaneChildren all = countChildren(lanes.place < count, own.ref, limit);
    const uint32_t inner = innerIn(all, kWholeWarp), primitives = primitivesIn(all, kWholeWarp);
    unsigned long long room = 0;
    if (laneOf() == 0)
        room = atomicAdd(reinterpret_cast<unsigned long long*>(&counters.allocated),
                         (unsigned long long)(primitives) << 32 | inner);
    const Bounds whole = gridOf(uniteOfEight(own.box));
    const uint32_t child = assignSlots(lanes, own, count, whole);
    const bool used = child < kSlots;
    own = shuffleFrom(own, lanes.first + (used ? child : lanes.place));
    all = countChildren(used, own.ref, limit);

    room = __shfl_sync(kWholeWarp, room, 0);
    const uint32_t before = lanesBelow(lanes.first), mine = 0xFFu << lanes.first;
    const NodePlace place = {index, uint32_t(task >> 32), uint32_t(room) + innerIn(all, before),
                             uint32_t(room >> 32) + primitivesIn(all, before)};
    const bool fits = place.childBase + innerIn(all, mine) <= job.maxWide &&
                      place.primitiveBase + primitivesIn(all, mine) <= numActive;
    if (ready && fits)
        describeSlot(job, lanes, used, own, whole, all, place, image);
    else if (ready)
        atomicExch(&counters.failure, uint32_t(kTreeBroken));
    __syncwarp();
    if (ready && fits && lanes.place < sizeof(WideNode) / 16) { // at the first key
        U4* const node = at<U4>(job.nodes + index * nodeSize(job.motionKeys));
        node[lanes.place] = reinterpret_cast<const U4*>(&image)[lanes.place];
    }
    if (uint32_t(room >> 32) + primitives == numActive)
        endTasks(job, uint32_t(room) + inner);
    const uint32_t written = uint32_t(__popc(__ballot_sync(kWholeWarp, ready))) / kSlots;
    if (laneOf() == 0)
        atomicAdd(&counters.finished, written);
}

// Only unwritten nodes assign further nodes, so equal numbers mean the end. The number of written
// nodes must be read first.
SUNSTONE_INLINE bool isOver(const Counters& counters) {
    const uint32_t finished = loadFresh(&counters.finished);
    fence();
    return finished == uint32_t(loadFresh(&counters.allocated)) || loadFresh(&counters.failure);
}

// Polls of a task between two checks for the end, which a broken tree needs. Rare checks do not
// slow other groups down.
constexpr uint32_t kLooksBetween = 64;

SUNSTONE_INLINE void collapse(const BuildJob& job, TreeMode mode, WideNode* images) {
    Counters& counters = countersOf(job);
    const NodeLanes lanes = {laneOf() & ~7u, laneOf() & 7u};
    WideNode& image = images[threadIdx.x / kSlots];
    bool hasTicket = false;
    uint32_t index = 0, deepest = 0;
    for (uint32_t looks = 1;; ++looks) {
        const uint32_t takers = __ballot_sync(kWholeWarp, !hasTicket && lanes.place == 0);
        uint32_t first = 0;
        if (laneOf() == 0 && takers)
            first = atomicAdd(&counters.nextTask, uint32_t(__popc(takers)));
        first = __shfl_sync(kWholeWarp, first, 0);
        if (!hasTicket)
            index = first + uint32_t(__popc(takers & lanesBelow(lanes.first)));
        hasTicket = true;
        unsigned long long task = kNoMoreTasks;
        if (lanes.place == 0 && index < job.maxWide)
            task = loadFresh(at<uint64_t>(job.tasks) + index);
        task = __shfl_sync(kWholeWarp, task, int(lanes.first));
        const bool ready = task < kNoMoreTasks;
        if (!__any_sync(kWholeWarp, ready)) {
            if (!__any_sync(kWholeWarp, task == kNoTask) ||
                (looks % kLooksBetween == 0 && __any_sync(kWholeWarp, isOver(counters))))
                break;
            continue;
        }
        makeNodes(job, mode, lanes, ready, index, task, image);
        if (ready) {
            const uint32_t depth = uint32_t(task >> 32);
            deepest = depth > deepest ? depth : deepest;
            hasTicket = false;
        }
    }
    if (lanes.place == 0 && deepest > loadFresh(&counters.depth))
        atomicMax(&counters.depth, deepest);
}

SUNSTONE_KERNEL __launch_bounds__(kCollapseThreads) sunstone_collapse(BuildJob job, TreeMode mode) {
    __shared__ WideNode images[kNodesOfBlock];
    if (countersOf(job).numTreeReferences != 0)
        collapse(job, mode, images);
}

// Runs a step of a kernel in parts that blocks take. A block that finds no part left waits for the
// other blocks, which already run.
template <class Work>
SUNSTONE_INLINE void inParts(uint32_t turns[2], uint32_t numParts, const Work& work) {
    __shared__ uint32_t taken;
    for (;;) {
        if (threadIdx.x == 0)
            taken = atomicAdd(&turns[0], 1u);
        __syncthreads();
        const uint32_t part = taken;
        if (part >= numParts)
            break;
        work(part);
        __syncthreads();
        if (threadIdx.x == 0) {
            fence();
            atomicAdd(&turns[1], 1u);
        }
    }
    while (loadFresh(&turns[1]) < numParts) {
    }
    fence();
    __syncthreads();
}

// Makes another tree if the present one is too deep; in a separate kernel, because this is rare.
SUNSTONE_KERNEL __launch_bounds__(kCollapseThreads) sunstone_retry(BuildJob job) {
    __shared__ WideNode images[kNodesOfBlock];
    Counters& counters = countersOf(job);
    // The depth never decreases, so that all blocks decide the same.
    if (counters.depth < kMaxWideDepth)
        return;
    constexpr uint32_t kPart = 64 * kCollapseThreads;
    const uint32_t most = job.maxReferences > job.maxWide ? job.maxReferences : job.maxWide;
    inParts(counters.retryTurns[0], (most + kPart - 1) / kPart, [&](uint32_t part) {
        const uint32_t end = most - part * kPart < kPart ? most : (part + 1) * kPart;
        for (uint32_t i = part * kPart + threadIdx.x; i < end; i += blockDim.x) {
            if (i < job.maxReferences)
                at<uint32_t>(job.parents)[i] = kNoRef;
            if (i < job.maxWide)
                at<uint64_t>(job.tasks)[i] = kNoTask;
        }
        if (part == 0 && threadIdx.x == 0) {
            counters.tooDeep = 1;
            counters.finished = 0;
            counters.nextNode = 0;
            counters.nextTask = 0;
        }
    });
    const uint32_t count = counters.numTreeReferences;
    inParts(counters.retryTurns[1], (count + kCollapseThreads - 1) / kCollapseThreads,
            [&](uint32_t part) {
                makeHierarchy(job, kRadixByLevel, part * kCollapseThreads + threadIdx.x);
            });
    collapse(job, kRadixByLevel, images);
}

} // namespace sunstone::bvh::gpu
