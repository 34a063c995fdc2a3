// SPDX-License-Identifier: Apache-2.0
// Many rays in flight: independent traversals that take turns, one node or leaf at a time. Included
// by files that are compiled once per instruction set (see bvh/simd.h).
//
// The traversal of a single ray waits for memory, for the test of a node before the next node is
// known, and for mispredicted branches. Here the next node of a ray is prefetched while the other
// rays take their turns, and a step has no branch that depends on the scene. The children that are
// hit are compressed and sorted in registers, their number moves the top of the stack, and the tag
// of the new top entry selects the list that the ray joins. All rays of a list execute the same
// code.
//
// Each ray visits nodes and leaves in the order of traverse() (walk/traverse.h), so its hits equal
// those of a single ray even if they depend on the order.
//
// A Policy has
//
//   static constexpr bool kOrdered   in structures of triangles; instances are always ordered
//   struct Data                      its values for each ray
//   bool leaf(Flight&, NodeRef)      of triangles; may lower Flight::tmax; true ends the ray
//   bool instance(Flight&, NodeRef)  an instance: calls enter() or skip(); true ends the ray
//   void end(Flight&)                the ray has ended
//   bool next(Flight&)               starts a ray in this place (begin()); false: none is left
#pragma once

#include "bvh/walk/traverse.h"

#include <algorithm>

namespace sunstone::bvh::SUNSTONE_ISA {

// Tag of the stack entry that marks the end of a structure. No node has this tag.
constexpr NodeRef kEndTag = 3;

#if defined(__AVX512F__) && defined(__AVX512VL__)

// Four entries, the largest first.
SUNSTONE_INLINE __m256i sortFour(__m256i a) {
    __m256i b = _mm256_shuffle_epi32(a, 0x4E);
    a = _mm256_blend_epi32(_mm256_max_epu64(a, b), _mm256_min_epu64(a, b), 0xCC);
    b = _mm256_permute4x64_epi64(a, 0x4E);
    a = _mm256_blend_epi32(_mm256_max_epu64(a, b), _mm256_min_epu64(a, b), 0xF0);
    b = _mm256_permute4x64_epi64(a, 0xD8);
    return _mm256_blend_epi32(_mm256_max_epu64(a, b), _mm256_min_epu64(a, b), 0xF0);
}

// Replaces the entry at `top` by the children that are hit, in the order of pushChildren(). Returns
// the new top. Writes up to eight entries from `top` on.
template <bool kOrdered>
SUNSTONE_INLINE uint64_t* replaceTop(const NodeRef* children, Mask hits, F8 distance,
                                     uint64_t* top) {
    const __m512i refs =
        _mm512_cvtepu32_epi64(_mm256_load_si256(reinterpret_cast<const __m256i*>(children)));
    const int count = __builtin_popcount(hits);
    if constexpr (kOrdered) {
        const __m512i far =
            _mm512_slli_epi64(_mm512_cvtepu32_epi64(_mm256_castps_si256(distance.v)), 32);
        const __m512i entries =
            _mm512_maskz_compress_epi64(__mmask8(hits), _mm512_or_si512(far, refs));
        // Unused lanes are zero, the smallest value, and come last.
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(top),
                            sortFour(_mm512_castsi512_si256(entries)));
        if (__builtin_expect(count > 4, 0)) {
            _mm512_storeu_si512(top, entries);
            sortEntries(top, unsigned(count));
        }
    } else {
        const __m512i entries = _mm512_maskz_compress_epi64(__mmask8(hits & (hits - 1)), refs);
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(top), _mm512_castsi512_si256(entries));
        if (__builtin_expect(count > 5, 0))
            _mm512_storeu_si512(top, entries);
        const uint64_t first = children[lowestBit(hits | 0x80)];
        top[count - 1] = count ? first : top[-1];
    }
    return top + count - 1;
}

#else

template <bool kOrdered>
SUNSTONE_INLINE uint64_t* replaceTop(const NodeRef* children, Mask hits, F8 distance,
                                     uint64_t* top) {
    struct NoPrefetch {
        static void prefetch(const uint8_t*, uint64_t) {}
    };
    if (hits == 0)
        return top - 1;
    const NodeRef first =
        pushChildren<kOrdered>(NoPrefetch(), nullptr, children, hits, distance, top);
    *top = first;
    return top;
}

#endif

template <class Data, uint32_t kLevels>
struct alignas(64) FlightOf {
    const RaySetup* setup; // in the space of `block`
    const uint8_t* block;
    uint64_t* top; // entry of the next node
    float tmax;
    uint32_t kinds; // kTriangleLists or kInstanceLists, by the type of `block`
    uint32_t level;
    uint32_t place; // of the ray in FlightWalk
    Data data;
    const uint8_t* blocks[kLevels];
    uint32_t kindsAt[kLevels];
    alignas(64) RaySetup setups[kLevels];
};

template <class Policy, uint32_t kRays, uint32_t kLevels>
class FlightWalk {
public:
    using Flight = FlightOf<typename Policy::Data, kLevels>;
    static constexpr uint32_t kTriangleLists = 0, kInstanceLists = 4;

    // Traces the rays that the policy supplies, until it has no more.
    void run(Policy& policy) {
        now_ = 0;
        std::fill_n(counts_[0], kLists, 0u);
        uint32_t flying = 0;
        for (uint32_t i = 0; i < kRays; ++i) {
            flights_[i].place = i;
            if (!policy.next(flights_[i]))
                break;
            advance(flights_[i], 0);
            ++flying;
        }
        while (flying != 0)
            flying -= round(policy);
    }

    // For Policy::next: starts the ray in this structure, whose root is a node.
    void begin(Flight& f, const BlockHeader* header, uint32_t kinds, const float origin[3],
               const float direction[3], float tmin, float tmax) {
        f.tmax = tmax;
        f.level = 0;
        f.top = stacks_[f.place] + kBelow;
        *f.top = kEndTag;
        open(f, header, kinds, origin, direction, tmin);
    }
    // Continues a ray that another traversal has started, with `count` entries of its stack, the
    // next one last.
    void beginAt(Flight& f, const BlockHeader* header, const RaySetup* setup, float tmax,
                 const uint64_t* entries, uint32_t count) {
        f.tmax = tmax;
        f.level = 0;
        uint64_t* const first = stacks_[f.place] + kBelow;
        *first = kEndTag;
        std::copy(entries, entries + count, first + 1);
        f.top = first + count;
        f.setup = setup;
        f.block = reinterpret_cast<const uint8_t*>(header);
        f.kinds = kTriangleLists;
    }
    // For Policy::instance: moves the ray into a structure, whose root is a node; requires
    // canEnter().
    bool canEnter(const Flight& f) const {
        return f.level + 1 < kLevels &&
               size_t(f.top - stacks_[f.place]) + kStackSize + kAbove <= kCapacity;
    }
    void enter(Flight& f, const BlockHeader* header, uint32_t kinds, const float origin[3],
               const float direction[3], float tmin) {
        *f.top = kEndTag;
        ++f.level;
        open(f, header, kinds, origin, direction, tmin);
    }
    // For Policy::instance: the ray does not enter the instance.
    static void skip(Flight& f) { --f.top; }

private:
    static constexpr uint32_t kLists = 8;
    // A step writes one entry below the top and eight entries from the top on.
    static constexpr uint32_t kBelow = 1, kAbove = 10;
    // An odd number of cache lines, so that the first lines of the stacks are in different cache
    // sets.
    static constexpr uint32_t kCapacity =
        ((kLevels > 1 ? 2 : 1) * kStackSize + kBelow + kAbove + 7) / 8 / 2 * 16 + 24;

    void open(Flight& f, const BlockHeader* header, uint32_t kinds, const float origin[3],
              const float direction[3], float tmin) {
        RaySetup& setup = f.setups[f.level];
        setupRay(setup, header, origin, direction, tmin, f.tmax);
        *++f.top = header->root;
        f.setup = &setup;
        f.block = f.blocks[f.level] = reinterpret_cast<const uint8_t*>(header);
        f.kinds = f.kindsAt[f.level] = kinds;
    }

    // Adds the ray to the list of its next node.
    SUNSTONE_INLINE_MEMBER void advance(Flight& f, uint32_t side) {
        const NodeRef ref = NodeRef(*f.top);
        prefetchChild(f.block, ref);
        const uint32_t list = (ref & kNodeTagMask) + f.kinds;
        lists_[side][list][counts_[side][list]++] = uint8_t(f.place);
    }

    // Steps every ray. Returns the number of rays that have ended without a new ray in their place.
    uint32_t round(Policy& policy) {
        const uint32_t now = now_, later = now ^ 1;
        now_ = later;
        std::fill_n(counts_[later], kLists, 0u);
        openNodes<Policy::kOrdered>(now, kTriangleLists + kInner);
        openNodes<true>(now, kInstanceLists + kInner);
        uint32_t ended = 0;
        const auto each = [&](uint32_t list, const auto& endsRay) {
            for (uint32_t k = 0; k < counts_[now][list]; ++k) {
                Flight& f = flights_[lists_[now][list][k]];
                if (endsRay(f)) {
                    policy.end(f);
                    if (!policy.next(f)) {
                        ++ended;
                        continue;
                    }
                }
                advance(f, later);
            }
        };
        const auto visitLeaf = [&](Flight& f) {
            const float before = f.tmax;
            if (policy.leaf(f, NodeRef(*f.top)))
                return true;
            --f.top;
            if (Policy::kOrdered && f.tmax < before)
                dropFarther(f);
            return false;
        };
        each(kTriangleLists + kLeaf, visitLeaf);
        each(kTriangleLists + kWideLeaf, visitLeaf);
        each(kInstanceLists + kLeaf,
             [&](Flight& f) { return policy.instance(f, NodeRef(*f.top)); });
        const auto leave = [](Flight& f) {
            if (f.level == 0)
                return true;
            --f.level;
            f.setup = &f.setups[f.level];
            f.block = f.blocks[f.level];
            f.kinds = f.kindsAt[f.level];
            --f.top;
            return false;
        };
        each(kTriangleLists + kEndTag, leave);
        each(kInstanceLists + kEndTag, leave);
        return ended;
    }

    // Three loops with short iterations, so that the processor overlaps several iterations.
    template <bool kOrdered>
    SUNSTONE_INLINE_MEMBER void openNodes(uint32_t now, uint32_t list) {
        const uint32_t count = counts_[now][list];
        for (uint32_t k = 0; k < count; ++k) {
            const Flight& f = flights_[lists_[now][list][k]];
            const uint8_t* const node = f.block + offsetOf(NodeRef(*f.top));
            F8 distance;
            hits_[k] = testNode(node, f.setup->nearPlanes, SlabLanes(*f.setup), f.tmax, distance);
            store(distances_[k], distance);
            children_[k] = reinterpret_cast<const Node*>(node)->children;
        }
        for (uint32_t k = 0; k < count; ++k) {
            Flight& f = flights_[lists_[now][list][k]];
            f.top = replaceTop<kOrdered>(children_[k], hits_[k],
                                         load(distances_[k], static_cast<F8*>(nullptr)), f.top);
        }
        for (uint32_t k = 0; k < count; ++k)
            advance(flights_[lists_[now][list][k]], now ^ 1);
    }

    // Removes entries behind the hit, which the traversal of a single ray would skip when it pops
    // them.
    void dropFarther(Flight& f) {
        uint64_t* const first = stacks_[f.place] + kBelow;
        uint64_t* to = first;
        for (const uint64_t* from = first; from <= f.top; ++from) {
            const uint64_t entry = *from;
            *to = entry;
            const bool isNear = __builtin_bit_cast(float, uint32_t(entry >> 32)) <= f.tmax;
            to += isNear | (entry == kEndTag); // tmax may be negative
        }
        f.top = to - 1;
    }

    uint32_t now_ = 0;
    uint32_t counts_[2][kLists];
    uint8_t lists_[2][kLists][kRays];
    // The child distances of opened nodes.
    alignas(32) float distances_[kRays][8];
    const NodeRef* children_[kRays];
    Mask hits_[kRays];
    Flight flights_[kRays];
    alignas(64) uint64_t stacks_[kRays][kCapacity];
};

} // namespace sunstone::bvh::SUNSTONE_ISA
