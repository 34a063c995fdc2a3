// SPDX-License-Identifier: Apache-2.0
// The traversal loop, a template over the handling of leaves. Included by files that are compiled
// once per instruction set (see simd.h). The test of nodes is a second parameter.
//
// A Visitor has
//   static constexpr bool kOrdered;     visit near children first (closest hit), or in any order
//   float tmax;                         children beyond it are not visited
//   bool leaf(const uint8_t* block, NodeRef ref);   true ends the traversal
//
// A Nodes, the test of nodes, has
//   Mask test(const uint8_t* node, float tmax, F8& distance);   the children that the ray meets
//   void prefetch(const uint8_t* block, uint64_t offset);
//   reloaded()      the same test, with values for the registers of a loop over nodes
//
// Stack entries are 8 bytes: the bits of the entry distance above, the node below, so that sorting
// children is integer minimum and maximum. Distances are never negative, so their bits order like
// the numbers.
#pragma once

#include "bvh/walk/ray_triangle.h"

namespace sunstone::bvh::SUNSTONE_ISA {

SUNSTONE_INLINE void orderPair(uint64_t& a, uint64_t& b) {
    const uint64_t low = a < b ? a : b, high = a < b ? b : a;
    a = low;
    b = high;
}

// Sorts entries so that the nearest is last.
SUNSTONE_INLINE void sortEntries(uint64_t* e, unsigned count) {
    for (unsigned i = 1; i < count; ++i) {
        const uint64_t entry = e[i];
        unsigned j = i;
        for (; j > 0 && e[j - 1] < entry; --j)
            e[j] = e[j - 1];
        e[j] = entry;
    }
}

SUNSTONE_INLINE void prefetchNode(const uint8_t* block, uint64_t offset) {
    __builtin_prefetch(block + offset);
    __builtin_prefetch(block + offset + 64);
    __builtin_prefetch(block + offset + 128);
    __builtin_prefetch(block + offset + 192);
}

// Prefetches a node or a leaf of triangles. Wide leaves have two more lines; for others the last
// line is prefetched again.
SUNSTONE_INLINE void prefetchChild(const uint8_t* block, NodeRef ref) {
    prefetchNode(block, offsetOf(ref));
    const uint8_t* const last = block + offsetOf(ref) + 192;
    __builtin_prefetch(last + (ref & kWideLeaf) * 32);
    __builtin_prefetch(last + (ref & kWideLeaf) * 64);
}

// Ray values in eight lanes for box tests.
struct SlabLanes {
    F8 nearR[3], nearC[3], farR[3], farC[3], org[3], tmin;
    explicit SlabLanes(const RaySetup& s) : tmin(splat(larger(s.tmin, 0.0f), (F8*)nullptr)) {
        for (int i = 0; i < 3; ++i) {
            nearR[i] = splat(s.nearR[i], (F8*)nullptr);
            nearC[i] = splat(s.nearC[i], (F8*)nullptr);
            farR[i] = splat(s.farR[i], (F8*)nullptr);
            farC[i] = splat(s.farC[i], (F8*)nullptr);
            org[i] = splat(s.org[i], (F8*)nullptr);
        }
    }
};

// The children of a node whose boxes the ray meets before tmax, and their distances. The operand
// order matters for NaN (an infinite plane times zero): min and max return their second operand.
// `near`: RaySetup::nearPlanes.
SUNSTONE_INLINE Mask testNode(const uint8_t* node, const uint32_t* near, const SlabLanes& r,
                              float tmax, F8& distance) {
    F8* const f = nullptr;
    const auto plane = [&](uint32_t offset) {
        return load(reinterpret_cast<const float*>(node + offset), f);
    };
    const F8 nearX = slab(plane(near[0]), r.org[0], r.nearR[0], r.nearC[0]);
    const F8 nearY = slab(plane(near[1]), r.org[1], r.nearR[1], r.nearC[1]);
    const F8 nearZ = slab(plane(near[2]), r.org[2], r.nearR[2], r.nearC[2]);
    const F8 farX = slab(plane(near[0] ^ kPlanesSize), r.org[0], r.farR[0], r.farC[0]);
    const F8 farY = slab(plane(near[1] ^ kPlanesSize), r.org[1], r.farR[1], r.farC[1]);
    const F8 farZ = slab(plane(near[2] ^ kPlanesSize), r.org[2], r.farR[2], r.farC[2]);
    distance = max(max(nearX, nearY), max(nearZ, r.tmin));
    const F8 end = min(min(farX, farY), min(farZ, splat(tmax, f)));
    return lessEqual(distance, end);
}

// The test of nodes without motion (with motion: motion_traverse.h).
struct StillNodes {
    const RaySetup& setup;
    SlabLanes lanes;
    uint32_t near[3];

    // Words of `near` are read one at a time. A wide load of several members of the set-up would
    // wait until their stores have left the queue.
    SUNSTONE_INLINE_MEMBER explicit StillNodes(const RaySetup& s) : setup(s), lanes(s) {
        for (int i = 0; i < 3; ++i)
            near[i] = static_cast<const volatile uint32_t&>(s.nearPlanes[i]);
    }
    SUNSTONE_INLINE_MEMBER StillNodes reloaded() const {
        return StillNodes(SUNSTONE_ISA::reloaded(setup));
    }
    SUNSTONE_INLINE_MEMBER Mask test(const uint8_t* node, float tmax, F8& distance) const {
        return testNode(node, near, lanes, tmax, distance);
    }
    SUNSTONE_INLINE_MEMBER static void prefetch(const uint8_t* block, uint64_t offset) {
        prefetchNode(block, offset);
    }
};

// Returns the next child to visit among the hit children, at least one. The others are pushed, with
// the nearest on top, or in any order.
template <bool kOrdered, class Nodes>
SUNSTONE_INLINE NodeRef pushChildren(const Nodes& nodes, const uint8_t* block,
                                     const NodeRef* children, Mask hits, F8 distance,
                                     uint64_t*& top) {
    const NodeRef lowest = children[lowestBit(hits)];
    const Mask rest = hits & (hits - 1);
    if (rest == 0)
        return lowest;
    if constexpr (!kOrdered) {
        for (Mask m = rest; m; m &= m - 1) {
            *top = children[lowestBit(m)];
            nodes.prefetch(block, offsetOf(NodeRef(*top)));
            ++top;
        }
        return lowest;
    }
    alignas(32) float entry[8];
    store(entry, distance);
    const auto entryOf = [&](unsigned lane) {
        return uint64_t(bitsOf(entry[lane])) << 32 | children[lane];
    };
    uint64_t a = entryOf(lowestBit(hits)), b = entryOf(lowestBit(rest));
    orderPair(a, b);
    Mask more = rest & (rest - 1);
    if (more == 0) {
        *top++ = b;
        nodes.prefetch(block, offsetOf(NodeRef(b)));
        return NodeRef(a);
    }
    uint64_t c = entryOf(lowestBit(more));
    more &= more - 1;
    orderPair(b, c), orderPair(a, b);
    uint64_t* const first = top;
    if (more == 0) {
        top[0] = c, top[1] = b;
        top += 2;
    } else {
        uint64_t d = entryOf(lowestBit(more));
        more &= more - 1;
        orderPair(c, d), orderPair(b, c), orderPair(a, b);
        top[0] = d, top[1] = c, top[2] = b;
        top += 3;
        if (more) {
            *top++ = a;
            for (; more; more &= more - 1)
                *top++ = entryOf(lowestBit(more));
            sortEntries(first, unsigned(top - first));
            a = *--top;
        }
    }
    for (const uint64_t* e = first; e != top; ++e)
        nodes.prefetch(block, offsetOf(NodeRef(*e)));
    return NodeRef(a);
}

// Takes the next node to visit from the stack. False if there is none.
template <class Visitor>
SUNSTONE_INLINE bool popNode(const Visitor& visitor, const uint64_t* stack, uint64_t*& top,
                             NodeRef& ref) {
    for (;;) {
        if (top == stack)
            return false;
        const uint64_t entry = *--top;
        if (!Visitor::kOrdered ||
            __builtin_bit_cast(float, uint32_t(entry >> 32)) <= visitor.tmax) {
            ref = NodeRef(entry);
            return true;
        }
    }
}

// Visits nodes, `ref` the first, up to the next leaf. The ray's vectors stay in registers here; the
// code of leaves needs these registers itself. False if there is no leaf.
template <class Nodes, class Visitor>
SUNSTONE_INLINE bool descend(const Nodes& nodes, const Visitor& visitor, const uint8_t* block,
                             const uint64_t* stack, uint64_t*& top, NodeRef& ref) {
    do {
        const uint8_t* const node = block + offsetOf(ref);
        F8 distance;
        const Mask hits = nodes.test(node, visitor.tmax, distance);
        if (hits)
            ref = pushChildren<Visitor::kOrdered>(
                nodes, block, reinterpret_cast<const Node*>(node)->children, hits, distance, top);
        else if (!popNode(visitor, stack, top, ref))
            return false;
    } while ((ref & kNodeTagMask) == kInner);
    return true;
}

template <class Nodes, class Visitor>
SUNSTONE_INLINE void traverseNodes(const void* blockAddress, const Nodes& nodes, Visitor& visitor) {
    const uint8_t* const block = static_cast<const uint8_t*>(blockAddress);
    NodeRef ref = headerOf(block)->root;
    if (ref == kNoNode)
        return;
    uint64_t stack[kStackSize];
    uint64_t* top = stack;
    for (;;) {
        if ((ref & kNodeTagMask) == kInner &&
            !descend(nodes.reloaded(), visitor, block, stack, top, ref))
            return;
        if (visitor.leaf(block, ref) || !popNode(visitor, stack, top, ref))
            return;
    }
}

template <class Visitor>
SUNSTONE_INLINE void traverse(const void* block, const RaySetup& setup, Visitor& visitor) {
    traverseNodes(block, StillNodes(setup), visitor);
}

} // namespace sunstone::bvh::SUNSTONE_ISA
