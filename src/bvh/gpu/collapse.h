// SPDX-License-Identifier: Apache-2.0
// Fourth step: wide nodes. A thread makes one node of a part of the binary tree: it opens the child
// with the largest area until there are eight, puts them into slots, rounds their boxes and hands
// inner children on. Task i makes node i; whoever comes first takes the next one. Threads look for
// their task again and again until it is there, which needs only threads that run already: a task
// is handed out by one that has been taken up. They stop when all nodes given out are written,
// which must come to pass whatever the tree is like: there are no more than job.maxWide tasks, and
// one that has no room for what is below it is given up, with a failure, instead of handing it on.
#pragma once

#include "bvh/gpu/costs.h"
#include "bvh/gpu/grid.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kCollapseThreads = 128;

struct WideChildren {
    uint32_t count;
    uint32_t refs[kSlots];
    Bounds boxes[kSlots];
};

SUNSTONE_BUILDER bool isLeaf(uint32_t ref, uint32_t limit) {
    return refCount(ref) != 0 && refCount(ref) <= limit;
}

SUNSTONE_BUILDER BinaryNode loadNode(const BuildJob& job, uint32_t ref) {
    const U4* const words = at<const U4>(job.binary + uint64_t(refIndex(ref)) * sizeof(BinaryNode));
    const U4 a = words[0], b = words[1];
    return {{floatOf(a.x), floatOf(a.y), floatOf(a.z)},
            a.w,
            {floatOf(b.x), floatOf(b.y), floatOf(b.z)},
            b.w};
}

SUNSTONE_BUILDER Bounds boundsOf(const BuildJob& job, uint32_t ref) {
    if (refCount(ref) == 1)
        return primitiveBounds(job, refIndex(ref));
    const BinaryNode node = loadNode(job, ref);
    return {{node.lower[0], node.lower[1], node.lower[2]},
            {node.upper[0], node.upper[1], node.upper[2]}};
}

// Children in registers: places are found by comparing with each.
SUNSTONE_BUILDER uint32_t refAt(const WideChildren& c, uint32_t place) {
    uint32_t ref = 0;
#pragma unroll
    for (uint32_t i = 0; i < kSlots; ++i)
        ref = i == place ? c.refs[i] : ref;
    return ref;
}
SUNSTONE_BUILDER void putAt(WideChildren& c, uint32_t place, uint32_t ref, const Bounds& box) {
#pragma unroll
    for (uint32_t i = 0; i < kSlots; ++i)
        if (i == place) {
            c.refs[i] = ref;
            c.boxes[i] = box;
        }
}

SUNSTONE_BUILDER CostPart costPart(const BuildJob& job, uint32_t ref, const Bounds& box) {
    return {refCount(ref), halfArea(box),
            refCount(ref) == 1 ? 0 : at<const uint64_t>(job.savings)[refIndex(ref)]};
}

// Opens the children that costs tell to open; each has a budget of slots for its descendants.
SUNSTONE_BUILDER void openByCosts(const BuildJob& job, WideChildren& c) {
    uint32_t budgets = kSlots; // of each child, in 4 bits
    for (uint32_t place = 0; place < c.count;) {
        const uint32_t ref = refAt(c, place), budget = budgets >> 4 * place & 15u;
        if (budget < 2 || refCount(ref) == 1) {
            ++place;
            continue;
        }
        const BinaryNode node = loadNode(job, ref);
        const Bounds left = boundsOf(job, node.left), right = boundsOf(job, node.right);
        const CostPart leftPart = costPart(job, node.left, left),
                       rightPart = costPart(job, node.right, right);
        const Savings l = unpackSavings(leftPart), r = unpackSavings(rightPart);
        uint32_t ofLeft;
        const float saved = shareSlots(l, r, budget, ofLeft);
        // The node itself (eight slots) must be opened.
        if (budget < kSlots) {
            const float area = halfArea(unite(left, right));
            if (!(add(excessOf(job, area, isLeaf(ref, leafLimit(job)), leftPart, rightPart, l, r),
                      saved) > 0)) {
                ++place;
                continue;
            }
        }
        putAt(c, place, node.left, left);
        putAt(c, c.count, node.right, right);
        budgets = (budgets & ~(15u << 4 * place)) | ofLeft << 4 * place |
                  (budget - ofLeft) << 4 * c.count;
        ++c.count;
    }
}

// Opens children while there is room: inner ones first, the largest or (by level) the highest
// up, then leaves of several primitives. Only a node with nothing left to open has less than eight.
SUNSTONE_BUILDER void openWhileRoom(const BuildJob& job, TreeMode mode, WideChildren& c) {
    const uint32_t limit = leafLimit(job);
    uint32_t levels = 0; // of each child, in 4 bits
    while (c.count < kSlots) {
        uint32_t best = kSlots;
        bool bestInner = false;
        float bestArea = -1;
#pragma unroll
        for (uint32_t i = 0; i < kSlots; ++i) {
            if (i >= c.count || refCount(c.refs[i]) == 1)
                continue;
            const bool inner = !isLeaf(c.refs[i], limit);
            const float area =
                mode == kRadixByLevel ? 16.0f - float(levels >> 4 * i & 15u) : halfArea(c.boxes[i]);
            if (best == kSlots || inner > bestInner || (inner == bestInner && area > bestArea)) {
                best = i;
                bestInner = inner;
                bestArea = area;
            }
        }
        if (best == kSlots)
            break;
        const BinaryNode node = loadNode(job, refAt(c, best));
        putAt(c, best, node.left, boundsOf(job, node.left));
        levels += 1u << 4 * best;
        levels |= (levels >> 4 * best & 15u) << 4 * c.count;
        putAt(c, c.count, node.right, boundsOf(job, node.right));
        ++c.count;
    }
}

SUNSTONE_BUILDER void gatherChildren(const BuildJob& job, TreeMode mode, uint32_t ref,
                                     WideChildren& c) {
    c.count = 1;
#pragma unroll
    for (uint32_t i = 0; i < kSlots; ++i) {
        c.refs[i] = ref;
        c.boxes[i] = emptyBounds();
    }
    c.boxes[0] = boundsOf(job, ref);
    if (mode == kClustered)
        openByCosts(job, c);
    openWhileRoom(job, mode, c);
}

// The child of each slot in 4 bits, 8: none. Children go, the farthest out first, where their place
// in the node tells them to.
SUNSTONE_BUILDER uint32_t assignSlots(const WideChildren& c, const Bounds& whole) {
    uint32_t slots = 0x88888888u, freeSlots = 0xFFu, freeChildren = (1u << c.count) - 1;
    float off[kSlots][3];
#pragma unroll
    for (uint32_t i = 0; i < kSlots; ++i)
#pragma unroll
        for (int a = 0; a < 3; ++a)
            off[i][a] = sub(add(c.boxes[i].lower[a], c.boxes[i].upper[a]),
                            add(whole.lower[a], whole.upper[a]));
    while (freeChildren) {
        float best = -__builtin_inff();
        uint32_t bestChild = uint32_t(__ffs(int(freeChildren)) - 1);
        uint32_t bestSlot = uint32_t(__ffs(int(freeSlots)) - 1);
#pragma unroll
        for (uint32_t i = 0; i < kSlots; ++i) {
            if (!(freeChildren >> i & 1))
                continue;
#pragma unroll
            for (uint32_t s = 0; s < kSlots; ++s) {
                const float fit =
                    add(add(s & 1 ? off[i][0] : -off[i][0], s & 2 ? off[i][1] : -off[i][1]),
                        s & 4 ? off[i][2] : -off[i][2]);
                if ((freeSlots >> s & 1) && fit > best) {
                    best = fit;
                    bestChild = i;
                    bestSlot = s;
                }
            }
        }
        slots = (slots & ~(15u << 4 * bestSlot)) | bestChild << 4 * bestSlot;
        freeSlots &= ~(1u << bestSlot);
        freeChildren &= ~(1u << bestChild);
    }
    return slots;
}

SUNSTONE_BUILDER uint32_t slotOf(uint32_t slots, uint32_t child) {
    uint32_t slot = 0;
    for (uint32_t s = 0; s < kSlots; ++s)
        slot = (slots >> 4 * s & 15u) == child ? s : slot;
    return slot;
}

struct Quantised {
    uint32_t exponents[3];
    uint64_t planes[6];
};

SUNSTONE_BUILDER void quantise(const WideChildren& c, const Bounds& whole, uint32_t slots,
                               Quantised& q) {
#pragma unroll
    for (int a = 0; a < 3; ++a) {
        q.exponents[a] = stepExponent(sub(whole.upper[a], whole.lower[a]));
        const float inverse = inverseStep(q.exponents[a]);
        q.planes[a] = q.planes[3 + a] = 0;
#pragma unroll
        for (uint32_t child = 0; child < kSlots; ++child) {
            if (child >= c.count)
                continue;
            const uint32_t s = slotOf(slots, child);
            q.planes[a] |= uint64_t(lowerByte(c.boxes[child].lower[a], whole.lower[a], inverse))
                           << 8 * s;
            q.planes[3 + a] |= uint64_t(upperByte(c.boxes[child].upper[a], whole.lower[a], inverse))
                               << 8 * s;
        }
    }
}

// References of a leaf's primitives, left to right.
SUNSTONE_BUILDER void listPrimitives(const BuildJob& job, uint32_t ref, uint32_t* to) {
    if (refCount(ref) == 1) {
        *to = ref;
        return;
    }
    const BinaryNode node = loadNode(job, ref);
    uint32_t parts[2] = {node.left, node.right};
    for (uint32_t part : parts) {
        if (refCount(part) == 1) {
            *to++ = part;
        } else { // of two
            const BinaryNode pair = loadNode(job, part);
            *to++ = pair.left;
            *to++ = pair.right;
        }
    }
}

SUNSTONE_BUILDER void writeWideNode(const BuildJob& job, uint32_t index, const WideChildren& c,
                                    uint32_t depth, uint32_t childBase, uint32_t primitiveBase) {
    const uint32_t limit = leafLimit(job);
    Bounds whole = c.boxes[0];
    uint32_t empty = 0; // children
#pragma unroll
    for (uint32_t i = 1; i < kSlots; ++i) // the unused are empty
        whole = unite(whole, c.boxes[i]);
#pragma unroll
    for (uint32_t i = 0; i < kSlots; ++i)
        empty |= uint32_t(isEmpty(c.boxes[i])) << i;
    whole = gridOf(whole);
    const uint32_t slots = assignSlots(c, whole);
    Quantised q;
    quantise(c, whole, slots, q);
    uint32_t innerMask = 0, inner = 0, primitives = 0;
    uint64_t meta = 0;
    for (uint32_t s = 0; s < kSlots; ++s) {
        const uint32_t child = slots >> 4 * s & 15u;
        if (child == kSlots)
            continue;
        const uint32_t ref = refAt(c, child);
        if (isLeaf(ref, limit)) {
            meta |= uint64_t(leafMeta(refCount(ref), primitives,
                                      limit == 1 && (empty >> child & 1u) != 0))
                    << 8 * s;
            listPrimitives(job, ref, at<uint32_t>(job.order) + primitiveBase + primitives);
            primitives += refCount(ref);
        } else {
            innerMask |= 1u << s;
            meta |= uint64_t(1u << 5 | (24 + s)) << 8 * s;
            atomicExch(at<unsigned long long>(job.tasks) + childBase + inner,
                       uint64_t(depth + 1) << 32 | ref);
            ++inner;
        }
    }
    U4* const node = at<U4>(job.nodes + index * nodeSize(job.motionKeys)); // at the first key
    node[0] = U4{bitsOf(whole.lower[0]), bitsOf(whole.lower[1]), bitsOf(whole.lower[2]),
                 q.exponents[0] | q.exponents[1] << 8 | q.exponents[2] << 16 | innerMask << 24};
    node[1] = U4{childBase, primitiveBase, uint32_t(meta), uint32_t(meta >> 32)};
    for (int i = 0; i < 3; ++i)
        node[2 + i] = U4{uint32_t(q.planes[2 * i]), uint32_t(q.planes[2 * i] >> 32),
                         uint32_t(q.planes[2 * i + 1]), uint32_t(q.planes[2 * i + 1] >> 32)};
}

// Adds the lanes' numbers of nodes and primitives to the counter and returns where each lane's
// begin: nodes, and primitives above 32 bits.
SUNSTONE_BUILDER uint64_t allocate(Counters& counters, uint32_t nodes, uint32_t primitives) {
    const uint32_t lane = laneOf(), own = nodes | primitives << 16;
    uint32_t sum = own;
    for (uint32_t step = 1; step < 32; step *= 2) {
        const uint32_t other = __shfl_up_sync(kWholeWarp, sum, step);
        if (lane >= step)
            sum += other;
    }
    unsigned long long first = 0;
    if (lane == 31)
        first = atomicAdd(reinterpret_cast<unsigned long long*>(&counters.allocated),
                          (unsigned long long)(sum >> 16) << 32 | (sum & 0xFFFFu));
    first = __shfl_sync(kWholeWarp, first, 31);
    const uint32_t before = sum - own;
    return first + (uint64_t(before >> 16) << 32 | (before & 0xFFFFu));
}

// Nodes are given out by those not yet written, so that equal numbers mean the end; the number
// written is read first.
SUNSTONE_BUILDER bool isOver(const Counters& counters) {
    const uint32_t finished = loadFresh(&counters.finished);
    __threadfence();
    return finished == uint32_t(loadFresh(&counters.allocated)) || loadFresh(&counters.failure);
}

SUNSTONE_KERNEL __launch_bounds__(kCollapseThreads) sunstone_collapse(BuildJob job, TreeMode mode) {
    Counters& counters = countersOf(job);
    const uint32_t numActive = counters.numTreeReferences, lane = laneOf(), limit = leafLimit(job);
    if (numActive == 0 || (mode == kRadixByLevel && !counters.tooDeep))
        return;
    bool hasTicket = false;
    uint32_t index = 0, deepest = 0;
    for (;;) {
        const uint32_t takers = __ballot_sync(kWholeWarp, !hasTicket);
        uint32_t first = 0;
        if (lane == 0 && takers)
            first = atomicAdd(&counters.nextTask, uint32_t(__popc(takers)));
        first = __shfl_sync(kWholeWarp, first, 0);
        if (!hasTicket)
            index = first + uint32_t(__popc(takers & lanesBelow(lane)));
        hasTicket = true;
        const uint64_t task =
            index < job.maxWide ? loadFresh(at<uint64_t>(job.tasks) + index) : ~0ull;
        const bool ready = task != ~0ull;
        if (!__any_sync(kWholeWarp, ready)) {
            if (__any_sync(kWholeWarp, isOver(counters)))
                break;
            continue;
        }
        WideChildren children;
        uint32_t inner = 0, primitives = 0;
        if (ready) {
            gatherChildren(job, mode, uint32_t(task), children);
#pragma unroll
            for (uint32_t i = 0; i < kSlots; ++i) {
                if (i >= children.count)
                    continue;
                if (isLeaf(children.refs[i], limit))
                    primitives += refCount(children.refs[i]);
                else
                    ++inner;
            }
        }
        const uint64_t place = allocate(counters, inner, primitives);
        if (ready) {
            const uint32_t depth = uint32_t(task >> 32);
            if (uint32_t(place) + inner <= job.maxWide &&
                uint32_t(place >> 32) + primitives <= numActive)
                writeWideNode(job, index, children, depth, uint32_t(place), uint32_t(place >> 32));
            else
                atomicExch(&counters.failure, uint32_t(kTreeBroken));
            deepest = depth > deepest ? depth : deepest;
            hasTicket = false;
        }
        const uint32_t written = uint32_t(__popc(__ballot_sync(kWholeWarp, ready)));
        if (lane == 0)
            atomicAdd(&counters.finished, written);
    }
    if (deepest)
        atomicMax(&counters.depth, deepest);
}

} // namespace sunstone::bvh::gpu
