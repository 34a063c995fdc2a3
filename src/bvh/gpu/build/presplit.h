// SPDX-License-Identifier: Apache-2.0
// A step between the boxes and the codes, for PREFER_FAST_TRACE: splits references to long thin
// triangles, by the rules of the CPU's builder (bvh/build/presplit.h). The number of splits of a
// triangle is its priority times the largest factor for which all splits have room. A histogram of
// the priorities gives this factor roughly; then kernels count the splits of factors near it. The
// places of a triangle's parts are prefix sums, so that builds are repeatable.
#pragma once

#include "bvh/build/split_measure.h"
#include "bvh/gpu/build/finish.h"
#include "bvh/gpu/build/sort.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kSplitThreads = 256;
// No triangle is split if the boxes of long thin triangles have less than 1 / kLeastShare of the
// area of all boxes, as among random triangles: rays would not gain.
constexpr uint64_t kLeastShare = 8;
// If at most one of so many triangles is split, leaves hold records of their triangles, which rays
// reach faster; else leaves share records.
constexpr uint32_t kFewSplits = 16;

SUNSTONE_INLINE uint32_t splitBlocks(const BuildJob& job) {
    return (job.numPrimitives + kSplitThreads - 1) / kSplitThreads;
}
// For each triangle its priority with the limit in the last 5 bits, later its number of splits;
// then sums of blocks.
SUNSTONE_INLINE uint32_t* splitWords(const BuildJob& job) {
    return at<uint32_t>(job.keys[1]);
}
SUNSTONE_INLINE uint32_t* splitSums(const BuildJob& job) {
    return splitWords(job) + job.numPrimitives;
}

SUNSTONE_INLINE bool verticesOf(const BuildJob& job, uint32_t primitive, float v[9],
                                uint32_t& flags) {
    const uint32_t i = inputOfPrimitive(job, primitive);
    const DeviceInput& input = at<const DeviceInput>(job.inputs)[i];
    const InputRecord& record = at<const InputRecord>(job.inputRecords)[i];
    const uint32_t local = primitive - record.firstPrimitive;
    flags = sbtWord(input, record, local) >> kGeometryFlagShift;
    return readTriangle(input, local, v);
}

// A triangle's share in the sums of areas, and its splits.
struct SplitShare {
    uint32_t word;
    double box, excess;
};

SUNSTONE_INLINE SplitShare measureTriangle(const BuildJob& job, uint32_t primitive) {
    float v[9];
    uint32_t flags;
    if (!verticesOf(job, primitive, v, flags))
        return {0, 0, 0};
    const SplitMeasure m = splitMeasure(v);
    const SplitShare whole = {0, m.box, 0};
    if (flags & kGeometryRequireSingleAnyHit || !isWorthSplitting(m))
        return whole;
    // The cube root, scaled into the range of floats, because only ratios of priorities matter.
    const float excess = float(m.box - m.need);
    if (!(excess > 0) || excess > 3e38f)
        return whole;
    const float root = __nvvm_ex2_approx_f(mul(__nvvm_lg2_approx_f(excess), 1.0f / 3));
    return {(bitsOf(root) & ~31u) | splitLimit(m), m.box, m.box - m.need};
}

// The scale from areas to integers, whose sums do not depend on the order: 2^32 is the area of the
// scene.
SUNSTONE_INLINE double areaUnits(const Counters& counters) {
    double size[3];
    for (int a = 0; a < 3; ++a)
        size[a] = double(fromOrdered(counters.upper[a])) - double(fromOrdered(~counters.lower[a]));
    const double area = size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
    return area > 0 ? 0x1p32 / area : 0.0;
}

SUNSTONE_KERNEL sunstone_split_measure(BuildJob job) {
    __shared__ uint32_t counts[kSplitBins];
    __shared__ unsigned long long boxAreas, splitAreas;
    for (uint32_t i = threadIdx.x; i < kSplitBins; i += blockDim.x)
        counts[i] = 0;
    if (threadIdx.x == 0)
        boxAreas = splitAreas = 0;
    __syncthreads();
    Counters& counters = countersOf(job);
    const double units = areaUnits(counters);
    unsigned long long ownBoxes = 0, ownSplits = 0;
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        const Bounds box = primitiveBounds(job, i);
        SplitShare measure = {0, 0, 0};
        if (box.lower[0] <= box.upper[0])
            measure = measureTriangle(job, i);
        splitWords(job)[i] = measure.word;
        ownBoxes += (unsigned long long)(measure.box * units);
        ownSplits += (unsigned long long)(measure.excess * units);
        if (measure.word)
            atomicAdd(&counts[measure.word >> 20], 1u);
    }
    if (ownBoxes)
        atomicAdd(&boxAreas, ownBoxes);
    if (ownSplits)
        atomicAdd(&splitAreas, ownSplits);
    __syncthreads();
    for (uint32_t i = threadIdx.x; i < kSplitBins; i += blockDim.x)
        if (counts[i])
            atomicAdd(&counters.splitBins[i], counts[i]);
    if (threadIdx.x == 0) {
        atomicAdd(&counters.boxAreas, boxAreas);
        atomicAdd(&counters.splitAreas, splitAreas);
    }
}

SUNSTONE_INLINE uint32_t splitsOf(float priority, float factor, uint32_t limit) {
    const float splits = mul(priority, factor);
    return splits < float(limit) ? uint32_t(splits) : limit;
}

// The number of splits of a primitive: up to a quarter of a split more, so that some of many equal
// triangles are split if there is no room to split all.
SUNSTONE_INLINE uint32_t splitsOf(uint32_t primitive, uint32_t word, float factor) {
    const float more = mul(float(primitive * 2654435769u >> 8), 0x1p-26f);
    const float splits = add(mul(floatOf(word & ~31u), factor), more);
    const uint32_t limit = word & 31u;
    return splits < float(limit) ? uint32_t(splits) : limit;
}

// The largest number of splits. The more boxes a ray meets, the fuller are the nodes, and the more
// parts fit into 80 bytes per triangle (docs/acceleration.md): 0.7 per triangle if the boxes of the
// long thin triangles have the area of the scene, and 0.05 more whenever this area doubles.
SUNSTONE_INLINE uint64_t splitBudget(const BuildJob& job) {
    const uint64_t room = job.maxReferences - job.numPrimitives;
    const int doubled = 31 - __clzll((long long)(countersOf(job).splitAreas));
    const uint64_t twentieths = doubled > -8 ? uint64_t(14 + doubled) : 6;
    const uint64_t wanted = job.numPrimitives * twentieths / 20;
    return wanted < room ? wanted : room;
}

// One block of kSplitBins / 8 threads.
SUNSTONE_KERNEL sunstone_split_choose(BuildJob job) {
    __shared__ unsigned long long total;
    Counters& counters = countersOf(job);
    const uint64_t budget = splitBudget(job);
    uint32_t low = 0, high = 0x7F000000u; // bits of the factor
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (threadIdx.x == 0)
            total = 0;
        __syncthreads();
        unsigned long long sum = 0;
        for (uint32_t k = 0; k < 8; ++k) {
            const uint32_t bin = threadIdx.x * 8 + k;
            const float most = floatOf(((bin + 1) << 20) - 1);
            if (counters.splitBins[bin])
                sum += uint64_t(counters.splitBins[bin]) *
                       splitsOf(most, floatOf(middle), kMostSplits);
        }
        if (sum)
            atomicAdd(&total, sum);
        __syncthreads();
        if (total <= budget)
            low = middle;
        else
            high = middle;
        __syncthreads();
    }
    if (threadIdx.x == 0) {
        const bool worthwhile = counters.splitAreas * kLeastShare > counters.boxAreas;
        counters.splitFactor = worthwhile ? floatOf(low) : 0.0f;
        counters.splitBudget = budget;
    }
}

// The factors to try: the first is 0, the others are near the histogram's factor.
SUNSTONE_INLINE float splitFactor(const Counters& counters, uint32_t number) {
    const float share = add(0.5f, mul(float(number), 1.5f / (kSplitFactors - 1)));
    return number == 0 ? 0.0f : mul(counters.splitFactor, share);
}

// Counts the splits for each factor.
SUNSTONE_KERNEL __launch_bounds__(kSplitThreads) sunstone_split_try(BuildJob job) {
    Counters& counters = countersOf(job);
    if (counters.splitFactor == 0)
        return;
    __shared__ unsigned long long totals[kSplitFactors];
    if (threadIdx.x < kSplitFactors)
        totals[threadIdx.x] = 0;
    __syncthreads();
    uint32_t own[kSplitFactors] = {};
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        const uint32_t word = splitWords(job)[i];
        if (word == 0)
            continue;
#pragma unroll
        for (uint32_t k = 0; k < kSplitFactors; ++k)
            own[k] += splitsOf(i, word, splitFactor(counters, k));
    }
#pragma unroll
    for (uint32_t k = 0; k < kSplitFactors; ++k) {
        uint32_t sum = own[k];
        for (uint32_t step = 1; step < 32; step *= 2)
            sum += __shfl_xor_sync(kWholeWarp, sum, int(step));
        if (laneOf() == 0 && sum)
            atomicAdd(&totals[k], (unsigned long long)sum);
    }
    __syncthreads();
    if (threadIdx.x < kSplitFactors)
        atomicAdd(&counters.splitTotals[threadIdx.x], totals[threadIdx.x]);
}

SUNSTONE_INLINE float chosenFactor(const Counters& counters) {
    uint32_t number = 0;
    while (number + 1 < kSplitFactors && counters.splitTotals[number + 1] <= counters.splitBudget)
        ++number;
    return splitFactor(counters, number);
}

SUNSTONE_KERNEL __launch_bounds__(kSplitThreads) sunstone_split_count(BuildJob job) {
    __shared__ uint32_t sum;
    __shared__ float factor;
    if (threadIdx.x == 0) {
        sum = 0;
        factor = chosenFactor(countersOf(job));
    }
    __syncthreads();
    const uint32_t i = globalThread();
    if (i < job.numPrimitives) {
        const uint32_t word = splitWords(job)[i];
        const uint32_t splits = splitsOf(i, word, factor);
        splitWords(job)[i] = splits;
        if (splits)
            atomicAdd(&sum, splits);
    }
    __syncthreads();
    if (threadIdx.x == 0)
        splitSums(job)[blockIdx.x] = sum;
}

// One block of kSplitThreads turns the sums of blocks into the start of their parts. It clears the
// bins, because the sort counts in their place.
SUNSTONE_KERNEL __launch_bounds__(kSplitThreads) sunstone_split_sum(BuildJob job) {
    __shared__ uint32_t warpSums[kSplitThreads / 32];
    __shared__ uint32_t last;
    const uint32_t blocks = splitBlocks(job);
    for (uint32_t i = threadIdx.x; i < kSplitBins; i += kSplitThreads)
        countersOf(job).splitBins[i] = 0;
    uint32_t before = 0;
    for (uint32_t first = 0; first < blocks; first += kSplitThreads) {
        const uint32_t i = first + threadIdx.x;
        const uint32_t own = i < blocks ? splitSums(job)[i] : 0;
        const uint32_t place = before + sumBefore(own, warpSums);
        if (i < blocks)
            splitSums(job)[i] = place;
        if (threadIdx.x == kSplitThreads - 1)
            last = place + own;
        __syncthreads();
        before = last;
        __syncthreads();
    }
    if (threadIdx.x == 0) {
        Counters& counters = countersOf(job);
        counters.numReferences = job.numPrimitives + before;
        counters.numTreeReferences = counters.numActive + before;
        counters.sharesRecords = uint64_t(before) * kFewSplits > job.numPrimitives;
    }
}

SUNSTONE_INLINE float lengthOf(const Bounds& b, int& axis) {
    float length = -1;
    for (int a = 0; a < 3; ++a)
        if (sub(b.upper[a], b.lower[a]) > length) {
            length = sub(b.upper[a], b.lower[a]);
            axis = a;
        }
    return length;
}

// Box of the triangle's part on one side of a plane, inside `piece`.
SUNSTONE_INLINE Bounds sideOf(const float v[9], const Bounds& piece, int axis, double plane,
                              float pad, bool low) {
    double lower[3] = {1e300, 1e300, 1e300}, upper[3] = {-1e300, -1e300, -1e300};
    const auto add3 = [&](const double p[3]) {
        for (int a = 0; a < 3; ++a) {
            lower[a] = p[a] < lower[a] ? p[a] : lower[a];
            upper[a] = p[a] > upper[a] ? p[a] : upper[a];
        }
    };
    for (int i = 0; i < 3; ++i) {
        const int j = i == 2 ? 0 : i + 1;
        const double from[3] = {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
        const double to[3] = {v[3 * j], v[3 * j + 1], v[3 * j + 2]};
        const double p = axis == 0 ? from[0] : axis == 1 ? from[1] : from[2];
        const double q = axis == 0 ? to[0] : axis == 1 ? to[1] : to[2];
        if (low ? p <= plane : p >= plane)
            add3(from);
        if ((p < plane) == (q < plane))
            continue;
        const double t = (plane - p) / (q - p);
        double cut[3];
        for (int a = 0; a < 3; ++a)
            cut[a] = a == axis ? plane : from[a] + t * (to[a] - from[a]);
        add3(cut);
    }
    Bounds result = piece;
    for (int a = 0; a < 3; ++a) {
        if (a == axis && low)
            result.upper[a] = add(float(plane), pad);
        if (a == axis && !low)
            result.lower[a] = sub(float(plane), pad);
        const float l = larger(result.lower[a], sub(float(lower[a]), pad));
        const float u = smaller(result.upper[a], add(float(upper[a]), pad));
        if (l <= u) { // else no part of the triangle is here; any box will do
            result.lower[a] = l;
            result.upper[a] = u;
        }
    }
    return result;
}

SUNSTONE_INLINE void storeReference(const BuildJob& job, uint32_t reference, const Bounds& box) {
    float* const to = at<float>(job.boxes + uint64_t(reference) * sizeof(PrimitiveBox));
    for (int a = 0; a < 3; ++a) {
        to[a] = box.lower[a];
        to[3 + a] = box.upper[a];
    }
}

// Writes `splits` + 1 parts: one in place of the whole, the others from `next`.
SUNSTONE_INLINE void splitTriangle(const BuildJob& job, uint32_t primitive, uint32_t splits,
                                   uint32_t next) {
    struct Part {
        Bounds box;
        uint32_t splits;
    };
    float v[9];
    uint32_t flags;
    verticesOf(job, primitive, v, flags);
    float size = 0;
    for (int a = 0; a < 3; ++a)
        size = larger(size, sub(larger(larger(v[a], v[3 + a]), v[6 + a]),
                                smaller(smaller(v[a], v[3 + a]), v[6 + a])));
    const float pad = mul(2.0f, mul(size, 0x1p-21f));
    Part waiting[kMostSplits + 1];
    uint32_t count = 0;
    Part part = {primitiveBounds(job, primitive), splits};
    uint32_t reference = primitive;
    for (;;) {
        while (part.splits != 0) {
            int axis = 0;
            lengthOf(part.box, axis);
            const float lower = axis == 0   ? part.box.lower[0]
                                : axis == 1 ? part.box.lower[1]
                                            : part.box.lower[2];
            const float upper = axis == 0   ? part.box.upper[0]
                                : axis == 1 ? part.box.upper[1]
                                            : part.box.upper[2];
            const double plane = 0.5 * (double(lower) + double(upper));
            const Bounds left = sideOf(v, part.box, axis, plane, pad, true);
            const Bounds right = sideOf(v, part.box, axis, plane, pad, false);
            int unused;
            const float a = lengthOf(left, unused), b = lengthOf(right, unused);
            const float share = a + b > 0 ? divide(a, a + b) : 0.5f;
            const uint32_t rest = part.splits - 1;
            const uint32_t wanted = uint32_t(add(mul(share, float(rest)), 0.5f));
            const uint32_t first = wanted < rest ? wanted : rest;
            waiting[count++] = {right, rest - first};
            part = {left, first};
        }
        storeReference(job, reference, part.box);
        if (reference >= job.numPrimitives)
            at<uint32_t>(job.origins)[reference - job.numPrimitives] = primitive;
        if (count == 0)
            return;
        reference = next++;
        part = waiting[--count];
    }
}

SUNSTONE_KERNEL __launch_bounds__(kSplitThreads) sunstone_split(BuildJob job) {
    __shared__ uint32_t warpSums[kSplitThreads / 32];
    const uint32_t i = globalThread();
    const uint32_t splits = i < job.numPrimitives ? splitWords(job)[i] : 0;
    const uint32_t place = splitSums(job)[blockIdx.x] + sumBefore(splits, warpSums);
    if (splits)
        splitTriangle(job, i, splits, job.numPrimitives + place);
}

} // namespace sunstone::bvh::gpu
