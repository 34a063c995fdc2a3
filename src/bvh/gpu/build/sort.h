// SPDX-License-Identifier: Apache-2.0
// Second step: Morton codes of the primitives, and their sort by 8 bits a pass. A pass reads its
// keys once: each block takes a tile, counts its digits, and gets the places of its digits from the
// tiles before it (Adinets and Merrill, "Onesweep", 2022). Blocks take tiles in the order of their
// start, so that a block waits only for running blocks. The sort is stable; equal codes stay in the
// order of the input.
#pragma once

#include "bvh/gpu/device.h"

namespace sunstone::bvh::gpu {

constexpr uint64_t kInactiveKey = (1ull << 3 * kAxisBits) - 1;

SUNSTONE_INLINE uint64_t spreadBits(uint32_t a) { // 16 bits, two zeros between
    uint64_t x = a;
    x = (x | x << 16) & 0x0000FF0000FFull;
    x = (x | x << 8) & 0x00F00F00F00Full;
    x = (x | x << 4) & 0x0C30C30C30C3ull;
    x = (x | x << 2) & 0x249249249249ull;
    return x;
}

SUNSTONE_INLINE uint64_t mortonCode(const Counters& counters, const Bounds& box) {
    float lower[3], size = 0;
    for (int a = 0; a < 3; ++a) {
        lower[a] = fromOrdered(~counters.lower[a]);
        size = larger(size, sub(fromOrdered(counters.upper[a]), lower[a]));
    }
    const float cells = float(1u << kAxisBits);
    const float scale = size > 0 ? divide(cells, size) : 0.0f;
    uint32_t cell[3];
    for (int a = 0; a < 3; ++a) {
        const float centre = mul(0.5f, box.lower[a]) + mul(0.5f, box.upper[a]);
        const float x = mul(sub(centre, lower[a]), scale);
        cell[a] = uint32_t(smaller(larger(x, 0.0f), cells - 1));
    }
    const uint64_t code = spreadBits(cell[0]) << 2 | spreadBits(cell[1]) << 1 | spreadBits(cell[2]);
    return code < kInactiveKey ? code : kInactiveKey - 1;
}

SUNSTONE_INLINE uint64_t codeOf(const BuildJob& job, uint32_t reference) {
    const Bounds box = primitiveBounds(job, reference);
    return box.lower[0] <= box.upper[0] ? mortonCode(countersOf(job), box) : kInactiveKey;
}

SUNSTONE_KERNEL sunstone_codes(BuildJob job) {
    __shared__ uint32_t counts[kSortPasses][kSortDigits];
    for (uint32_t i = threadIdx.x; i < kSortPasses * kSortDigits; i += blockDim.x)
        counts[i / kSortDigits][i % kSortDigits] = 0;
    __syncthreads();
    Counters& counters = countersOf(job);
    const uint32_t count = counters.numReferences;
    for (uint32_t i = globalThread(); i < count; i += gridDim.x * blockDim.x) {
        const uint64_t code = codeOf(job, i);
        at<uint64_t>(job.keys[0])[i] = code;
        at<uint32_t>(job.values[0])[i] = i | 1u << kRefCountShift;
        for (uint32_t pass = 0; pass < kSortPasses; ++pass)
            atomicAdd(&counts[pass][uint32_t(code >> 8 * pass) & 0xFFu], 1u);
    }
    __syncthreads();
    for (uint32_t i = threadIdx.x; i < kSortPasses * kSortDigits; i += blockDim.x)
        if (const uint32_t count = counts[i / kSortDigits][i % kSortDigits])
            atomicAdd(&counters.histograms[i / kSortDigits][i % kSortDigits], count);
}

// The exclusive prefix sum over the threads of a block.
template <uint32_t kThreads = kSortThreads>
SUNSTONE_INLINE uint32_t sumBefore(uint32_t value, uint32_t* warpSums) {
    const uint32_t lane = laneOf(), warp = threadIdx.x / 32;
    uint32_t sum = value;
    for (uint32_t step = 1; step < 32; step *= 2) {
        const uint32_t other = __shfl_up_sync(kWholeWarp, sum, step);
        if (lane >= step)
            sum += other;
    }
    __syncthreads();
    if (lane == 31)
        warpSums[warp] = sum;
    __syncthreads();
    uint32_t before = 0;
    for (uint32_t w = 0; w < kThreads / 32; ++w)
        before += w < warp ? warpSums[w] : 0;
    return before + sum - value;
}

// The number of earlier keys with this digit among those that the warp has counted; adds this key.
// All lanes of the warp must call.
SUNSTONE_INLINE uint32_t rankInWarp(uint32_t digit, uint32_t* counts) {
    const uint32_t peers = __match_any_sync(kWholeWarp, digit), below = lanesBelow(laneOf());
    const uint32_t before = counts[digit];
    __syncwarp();
    if ((peers & below) == 0)
        counts[digit] = before + uint32_t(__popc(peers));
    __syncwarp();
    return before + uint32_t(__popc(peers & below));
}

// A tile's published state of a digit: none, its own count, or the count of all tiles up to it.
constexpr uint32_t kTileCount = 1u << 30, kTileSum = 2u << 30, kTileValue = kTileCount - 1;

// The number of keys with a digit in earlier tiles. Publishes the sum for later tiles. Loads the
// states of several tiles at once.
SUNSTONE_INLINE uint32_t sumOfTiles(uint32_t* states, uint32_t tile, uint32_t count) {
    constexpr uint32_t kAtOnce = 8;
    if (tile == 0)
        return 0;
    uint32_t sum = 0;
    for (uint32_t end = tile; end > 0;) {
        uint32_t found[kAtOnce];
#pragma unroll
        for (uint32_t i = 0; i < kAtOnce; ++i)
            found[i] = i < end ? loadFresh(states + (end - 1 - i) * kSortDigits) : kTileSum;
        bool known = true; // up to here
        uint32_t next = end > kAtOnce ? end - kAtOnce : 0;
#pragma unroll
        for (uint32_t i = 0; i < kAtOnce; ++i) {
            if (known && found[i] == 0)
                next = end - i;
            known = known && found[i] != 0;
            sum += known ? found[i] & kTileValue : 0;
            if (known && found[i] & kTileSum) {
                next = 0;
                known = false;
            }
        }
        end = next;
    }
    atomicExch(states + tile * kSortDigits, kTileSum | (sum + count));
    return sum;
}

SUNSTONE_KERNEL __launch_bounds__(kSortThreads) sunstone_sort(BuildJob job, uint32_t pass) {
    constexpr uint32_t kWarps = kSortThreads / 32;
    __shared__ uint64_t sortedKeys[kSortTile];
    __shared__ uint32_t sortedValues[kSortTile];
    __shared__ uint32_t counts[kWarps][kSortDigits]; // then: places in the tile
    __shared__ uint32_t places[kSortDigits];         // in the output, minus those in the tile
    __shared__ uint32_t warpSums[kWarps];
    __shared__ uint32_t ownTile;
    Counters& counters = countersOf(job);
    if (threadIdx.x == 0)
        ownTile = atomicAdd(&counters.sortTickets[pass], 1u);
    for (uint32_t w = 0; w < kWarps; ++w)
        counts[w][threadIdx.x] = 0;
    __syncthreads();
    const uint32_t tile = ownTile, first = tile * kSortTile, shift = 8 * pass;
    const uint32_t total = counters.numReferences;
    if (first >= total)
        return;
    const uint32_t inTile = total - first < kSortTile ? total - first : kSortTile;
    const uint64_t* const keysIn = at<const uint64_t>(job.keys[pass & 1]);
    const uint32_t* const valuesIn = at<const uint32_t>(job.values[pass & 1]);
    const uint32_t lane = laneOf(), warp = threadIdx.x / 32;
    uint64_t keys[kSortItems];
    uint32_t values[kSortItems], ranks[kSortItems];
#pragma unroll
    for (uint32_t i = 0; i < kSortItems; ++i) {
        const uint32_t place = warp * 32 * kSortItems + i * 32 + lane;
        keys[i] = place < inTile ? keysIn[first + place] : ~0ull;
        values[i] = place < inTile ? valuesIn[first + place] : 0;
    }
    // During the loads of keys.
    const uint32_t inOutput = sumBefore(counters.histograms[pass][threadIdx.x], warpSums);
#pragma unroll
    for (uint32_t i = 0; i < kSortItems; ++i)
        ranks[i] = rankInWarp(uint32_t(keys[i] >> shift) & 0xFFu, counts[warp]);
    __syncthreads();
    // Thread d handles digit d.
    uint32_t count = 0;
    for (uint32_t w = 0; w < kWarps; ++w) {
        const uint32_t ofWarp = counts[w][threadIdx.x];
        counts[w][threadIdx.x] = count;
        count += ofWarp;
    }
    uint32_t* const states =
        at<uint32_t>(job.tileStates) +
        uint64_t(pass) * ((job.maxReferences + kSortTile - 1) / kSortTile) * kSortDigits +
        threadIdx.x;
    atomicExch(states + tile * kSortDigits, (tile > 0 ? kTileCount : kTileSum) | count);
    const uint32_t local = sumBefore(count, warpSums);
    const uint32_t before = sumOfTiles(states, tile, count);
    places[threadIdx.x] = inOutput + before - local;
    for (uint32_t w = 0; w < kWarps; ++w)
        counts[w][threadIdx.x] += local;
    __syncthreads();
#pragma unroll
    for (uint32_t i = 0; i < kSortItems; ++i) {
        const uint32_t place = counts[warp][uint32_t(keys[i] >> shift) & 0xFFu] + ranks[i];
        sortedKeys[place] = keys[i];
        sortedValues[place] = values[i];
    }
    __syncthreads();
    uint64_t* const keysOut = at<uint64_t>(job.keys[~pass & 1]);
    uint32_t* const valuesOut = at<uint32_t>(job.values[~pass & 1]);
    for (uint32_t i = threadIdx.x; i < inTile; i += kSortThreads) {
        const uint64_t key = sortedKeys[i];
        const uint32_t place = places[uint32_t(key >> shift) & 0xFFu] + i;
        keysOut[place] = key;
        valuesOut[place] = sortedValues[i];
    }
}

} // namespace sunstone::bvh::gpu
