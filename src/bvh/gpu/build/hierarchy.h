// SPDX-License-Identifier: Apache-2.0
// Third step: a binary tree over the sorted primitives, by clustering (Benthin et al., "H-PLOC:
// Hierarchical Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", HPG
// 2024).
//
// Threads climb the radix tree of the Morton codes from its leaves; the second of the two threads
// that reach a node continues. When the range below exceeds 16 primitives, the warp cooperates: its
// lanes hold the clusters of both sides, and pairs of mutually nearest clusters (among 8 to the
// left and right) are merged until few enough remain. These are stored in place of the first
// primitives of the range. At the root all are merged to one.
//
// The distance of clusters and the number that remains decide the quality of the tree; both come
// from experiments (docs/notes/builders-gpu.md). The usual distance, the area of the common box,
// merges large clusters too late, so the distance is the square of that area divided by the areas
// of the two. 16 clusters carried far up the tree overlap, so only 4 remain of ranges beyond 64
// primitives, and the disjoint halves of the radix tree decide more.
//
// The pairs that merge do not depend on the order in which threads run; the numbers of the nodes
// do.
#pragma once

#include "bvh/gpu/build/costs.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kHierarchyThreads = 128;
constexpr uint32_t kClusters = 16;    // the most that remain of a range
constexpr uint32_t kSearchRadius = 8; // to either side
constexpr uint32_t kLargeRange = 64, kClustersOfLargeRange = 4;

// The height at which two neighbours separate in the radix tree: by their codes, then by their
// places.
SUNSTONE_INLINE uint64_t partingOf(const uint64_t* keys, uint32_t i) {
    const uint64_t different = keys[i] ^ keys[i + 1];
    return different ? different | 1ull << 63 : uint64_t(i ^ (i + 1));
}

SUNSTONE_INLINE Bounds loadBounds(const BuildJob& job, uint32_t ref) {
    if (refCount(ref) == 1)
        return primitiveBounds(job, refIndex(ref));
    const U4* const node = at<const U4>(job.binary + uint64_t(refIndex(ref)) * sizeof(BinaryNode));
    const volatile uint32_t* const words = reinterpret_cast<const volatile uint32_t*>(node);
    return {{floatOf(words[0]), floatOf(words[1]), floatOf(words[2])},
            {floatOf(words[4]), floatOf(words[5]), floatOf(words[6])}};
}

SUNSTONE_INLINE void storeNode(const BuildJob& job, uint32_t index, const Bounds& box,
                               uint32_t left, uint32_t right) {
    U4* const node = at<U4>(job.binary + uint64_t(index) * sizeof(BinaryNode));
    node[0] = U4{bitsOf(box.lower[0]), bitsOf(box.lower[1]), bitsOf(box.lower[2]), left};
    node[1] = U4{bitsOf(box.upper[0]), bitsOf(box.upper[1]), bitsOf(box.upper[2]), right};
}

SUNSTONE_INLINE uint64_t loadSavings(const BuildJob& job, uint32_t ref) {
    return refCount(ref) == 1 ? 0 : loadFresh(at<uint64_t>(job.savings) + refIndex(ref));
}

SUNSTONE_INLINE Bounds shuffleDown(const Bounds& b, uint32_t by) {
    Bounds r;
    for (int a = 0; a < 3; ++a) {
        r.lower[a] = __shfl_down_sync(kWholeWarp, b.lower[a], by);
        r.upper[a] = __shfl_down_sync(kWholeWarp, b.upper[a], by);
    }
    return r;
}
SUNSTONE_INLINE Bounds shuffleFrom(const Bounds& b, uint32_t lane) {
    Bounds r;
    for (int a = 0; a < 3; ++a) {
        r.lower[a] = __shfl_sync(kWholeWarp, b.lower[a], int(lane));
        r.upper[a] = __shfl_sync(kWholeWarp, b.upper[a], int(lane));
    }
    return r;
}

// The position of the n-th set bit.
SUNSTONE_INLINE uint32_t placeOfBit(uint32_t mask, uint32_t n) {
    uint32_t place = 0;
    for (uint32_t width = 16; width > 0; width /= 2) {
        const uint32_t below = uint32_t(__popc(mask >> place & ((1u << width) - 1)));
        if (n >= below) {
            n -= below;
            place += width;
        }
    }
    return place;
}

// The distance of two clusters from the areas of their boxes and of their common one. Not negative.
SUNSTONE_INLINE float clusterDistance(float area, float left, float right) {
    const float own = larger(add(left, right), 0x1p-100f);
    return mul(area, mul(area, __nvvm_rcp_approx_ftz_f(own)));
}

// The sort key of a pair. The order by distance, then by the places of the two, is total, so at
// least one pair is mutual.
SUNSTONE_INLINE uint64_t pairOf(uint32_t distanceBits, uint32_t low, uint32_t high) {
    return uint64_t(distanceBits) << 10 | low << 5 | high;
}
SUNSTONE_INLINE uint32_t otherOf(uint64_t pair, uint32_t lane) {
    const uint32_t low = uint32_t(pair) >> 5 & 31u, high = uint32_t(pair) & 31u;
    return low == lane ? high : low;
}

// The lane whose cluster is nearest to this lane's.
SUNSTONE_INLINE uint32_t nearestCluster(const Bounds& box, uint32_t count) {
    const uint32_t lane = laneOf();
    const float own = halfArea(box);
    uint64_t best = ~0ull;
#pragma unroll
    for (uint32_t r = 1; r <= kSearchRadius; ++r) {
        const float distance = clusterDistance(halfArea(unite(box, shuffleDown(box, r))), own,
                                               __shfl_down_sync(kWholeWarp, own, r));
        const uint32_t bits = lane + r < count ? bitsOf(distance) & 0x7FFFFFFFu : ~0u;
        const uint32_t bitsBefore = __shfl_up_sync(kWholeWarp, bits, r);
        const uint64_t after = pairOf(bits, lane, lane + r),
                       before = pairOf(bitsBefore, lane - r, lane);
        if (lane + r < count && after < best)
            best = after;
        if (lane >= r && lane < count && before < best)
            best = before;
    }
    return otherOf(best, lane);
}

// The nearest clusters among up to eight, for nodes high in the tree, where the rest of the GPU
// waits: each lane measures one pair, in a ring of eight.
constexpr uint32_t kRing = 8;
SUNSTONE_INLINE uint32_t nearestInRing(const Bounds& box, uint32_t count) {
    const uint32_t lane = laneOf(), first = lane % kRing, apart = 1 + lane / kRing,
                   second = (first + apart) % kRing;
    const Bounds a = shuffleFrom(box, first), b = shuffleFrom(box, second);
    const float distance = clusterDistance(halfArea(unite(a, b)), halfArea(a), halfArea(b));
    const uint32_t bits = bitsOf(distance) & 0x7FFFFFFFu;
    uint64_t best = ~0ull;
#pragma unroll
    for (uint32_t r = 1; r <= kRing / 2; ++r) {
        const uint32_t after = (first + r) % kRing, before = (first - r) % kRing;
        const uint32_t bitsAfter = __shfl_sync(kWholeWarp, bits, int(first + kRing * (r - 1))),
                       bitsBefore = __shfl_sync(kWholeWarp, bits, int(before + kRing * (r - 1)));
        const uint64_t pairAfter = first < after ? pairOf(bitsAfter, first, after)
                                                 : pairOf(bitsAfter, after, first),
                       pairBefore = first < before ? pairOf(bitsBefore, first, before)
                                                   : pairOf(bitsBefore, before, first);
        if (after < count && pairAfter < best)
            best = pairAfter;
        if (before < count && pairBefore < best)
            best = pairBefore;
    }
    return otherOf(best, first);
}

// Merges mutually nearest pairs; the remaining clusters are in the first lanes.
SUNSTONE_INLINE uint32_t mergePairs(const BuildJob& job, uint32_t& ref, Bounds& box,
                                    unsigned long long& savings, uint32_t count) {
    const uint32_t lane = laneOf();
    const bool valid = lane < count;
    const uint32_t found = count <= kRing ? nearestInRing(box, count) : nearestCluster(box, count);
    const uint32_t nearest = valid ? found & 31u : lane;
    const uint32_t back = __shfl_sync(kWholeWarp, nearest, int(nearest));
    const bool mutual = valid && back == lane && nearest != lane;
    const bool merges = mutual && lane < nearest;
    const uint32_t merging = __ballot_sync(kWholeWarp, merges);
    uint32_t first = 0; // place of the new nodes: needed last, so that its latency is hidden
    if (lane == 0)
        first = atomicAdd(&countersOf(job).nextNode, uint32_t(__popc(merging)));
    const uint32_t otherRef = __shfl_sync(kWholeWarp, ref, int(nearest));
    const Bounds other = shuffleFrom(box, nearest);
    const unsigned long long otherSavings = __shfl_sync(kWholeWarp, savings, int(nearest));
    const uint32_t leftRef = ref;
    if (merges) {
        const CostPart left = {refCount(ref), halfArea(box), savings},
                       right = {refCount(otherRef), halfArea(other), otherSavings};
        const uint32_t primitives = joinCounts(ref, otherRef);
        box = unite(box, other);
        savings = joinSavings(job, halfArea(box), primitives != 0 && primitives <= leafLimit(job),
                              left, right);
        ref = primitives << kRefCountShift;
    }
    const uint32_t kept = __ballot_sync(kWholeWarp, valid && (!mutual || merges));
    const uint32_t left = uint32_t(__popc(kept));
    first = __shfl_sync(kWholeWarp, first, 0);
    if (merges) {
        const uint32_t index = first + uint32_t(__popc(merging & lanesBelow(lane)));
        storeNode(job, index, box, leftRef, otherRef);
        at<uint64_t>(job.savings)[index] = savings;
        ref |= index;
    }
    const uint32_t from = lane < left ? placeOfBit(kept, lane) : lane;
    ref = __shfl_sync(kWholeWarp, ref, int(from));
    box = shuffleFrom(box, from);
    savings = __shfl_sync(kWholeWarp, savings, int(from));
    return left;
}

SUNSTONE_INLINE void storeRoot(const BuildJob& job, uint32_t ref) {
    countersOf(job).root = ref + 1;
    *at<uint64_t>(job.tasks) = ref;
}

// A range of the sorted primitives, and the start of its right half.
struct ClusterRange {
    uint32_t first, last, split;
};

SUNSTONE_INLINE void mergeClusters(const BuildJob& job, ClusterRange range, bool toOne) {
    uint32_t* const clusters = at<uint32_t>(job.values[1]);
    const uint32_t lane = laneOf();
    const uint32_t place = lane < kClusters ? range.first + lane : range.split + lane - kClusters;
    const uint32_t end = lane < kClusters ? range.split : range.last + 1;
    uint32_t ref = place < end ? loadFresh(clusters + place) : kNoRef;
    const uint32_t present = __ballot_sync(kWholeWarp, ref != kNoRef);
    uint32_t count = uint32_t(__popc(present));
    ref = __shfl_sync(kWholeWarp, ref, int(lane < count ? placeOfBit(present, lane) : lane));
    Bounds box = lane < count ? loadBounds(job, ref) : emptyBounds();
    unsigned long long savings = lane < count ? loadSavings(job, ref) : 0;
    const uint32_t wanted = toOne                                     ? 1
                            : range.last - range.first >= kLargeRange ? kClustersOfLargeRange
                                                                      : kClusters;
    while (count > wanted)
        count = mergePairs(job, ref, box, savings, count);
    if (lane < kClusters && range.first + lane <= range.last)
        const_cast<volatile uint32_t*>(clusters)[range.first + lane] = lane < count ? ref : kNoRef;
    if (toOne && lane == 0)
        storeRoot(job, ref);
    __syncwarp();
    fence();
}

// The warp merges the ranges of the lanes that wait for it, one after the other.
SUNSTONE_INLINE void mergeWaiting(const BuildJob& job, uint32_t count, const ClusterRange& range,
                                  bool waits) {
    uint32_t waiting = __ballot_sync(kWholeWarp, waits);
    while (waiting) {
        const int lane = __ffs(int(waiting)) - 1;
        waiting &= waiting - 1;
        const ClusterRange next = {__shfl_sync(kWholeWarp, range.first, lane),
                                   __shfl_sync(kWholeWarp, range.last, lane),
                                   __shfl_sync(kWholeWarp, range.split, lane)};
        mergeClusters(job, next, next.first == 0 && next.last == count - 1);
    }
}

// One step up the radix tree. False if the other half of the parent is incomplete: its thread
// continues.
SUNSTONE_INLINE bool climb(const uint64_t* keys, uint32_t* parents, uint32_t count,
                           ClusterRange& range) {
    const bool isLeft =
        range.first == 0 ||
        (range.last != count - 1 && partingOf(keys, range.last) < partingOf(keys, range.first - 1));
    const uint32_t parent = isLeft ? range.last : range.first - 1;
    const uint32_t other = atomicExch(parents + parent, isLeft ? range.first : range.last);
    if (other == kNoRef)
        return false;
    if (isLeft) {
        range.split = range.last + 1;
        range.last = other;
    } else {
        range.split = range.first;
        range.first = other;
    }
    return true;
}

// One thread makes a node of the two halves of a range.
SUNSTONE_INLINE void joinHalves(const BuildJob& job, ClusterRange range, bool whole) {
    volatile uint32_t* const clusters = at<volatile uint32_t>(job.values[1]);
    const uint32_t left = clusters[range.first], right = clusters[range.split];
    const uint32_t index = range.split - 1; // where the tree splits: unique for each node
    storeNode(job, index, unite(loadBounds(job, left), loadBounds(job, right)), left, right);
    const uint32_t ref = joinCounts(left, right) << kRefCountShift | index;
    clusters[range.first] = ref;
    if (whole)
        storeRoot(job, ref);
    fence();
}

// Each thread climbs from its primitive. All threads of a warp must call.
SUNSTONE_INLINE void makeHierarchy(const BuildJob& job, TreeMode mode, uint32_t self) {
    Counters& counters = countersOf(job);
    const uint32_t count = counters.numTreeReferences;
    if (self == 0)
        counters.allocated = count != 0;
    bool climbing = self < count;
    if (climbing) {
        const uint32_t ref = at<uint32_t>(job.values[0])[self];
        *at<volatile uint32_t>(job.values[1] + 4 * uint64_t(self)) = ref;
        fence();
        if (count == 1) {
            storeRoot(job, ref);
            climbing = false;
        }
    }
    const uint64_t* const keys = at<const uint64_t>(job.keys[0]);
    uint32_t* const parents = at<uint32_t>(job.parents);
    ClusterRange range = {self, self, 0};
    while (__any_sync(kWholeWarp, climbing)) {
        if (climbing)
            climbing = climb(keys, parents, count, range);
        fence();
        const bool whole = climbing && range.first == 0 && range.last == count - 1;
        if (mode != kClustered) {
            if (climbing)
                joinHalves(job, range, whole);
        } else {
            mergeWaiting(job, count, range,
                         climbing && (whole || range.last - range.first >= kClusters));
        }
        if (whole)
            climbing = false;
    }
}

// As many resident warps as possible, because they mostly wait for memory.
SUNSTONE_KERNEL __launch_bounds__(kHierarchyThreads, 8) sunstone_clusters(BuildJob job) {
    makeHierarchy(job, kClustered, globalThread());
}
SUNSTONE_KERNEL __launch_bounds__(kHierarchyThreads) sunstone_radix_tree(BuildJob job) {
    makeHierarchy(job, kRadix, globalThread());
}

} // namespace sunstone::bvh::gpu
