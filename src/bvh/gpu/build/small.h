// SPDX-License-Identifier: Apache-2.0
// Builds of few primitives: the steps from the Morton codes to the tree in one kernel of one block.
// A chain of kernels would take the time of its launches and memory latencies
// (docs/notes/builders-gpu.md has figures). Here threads exchange data in the block's shared
// memory, as far as it fits.
#pragma once

#include "bvh/gpu/build/arrange.h"
#include "bvh/gpu/build/sort.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kSmallItems = kSmallMost / kSmallThreads;
constexpr uint32_t kSmallWarps = kSmallThreads / 32;

// Static shared memory. The sort's counts and the images of nodes are not needed at the same time.
struct SmallScratch {
    union {
        uint32_t counts[kSmallWarps][kSortDigits];
        WideNode images[kSmallThreads / kSlots];
    };
    uint32_t warpSums[kSmallWarps];
    alignas(16) uint8_t counters[kUpdateCounters];
};

// The free part of the block's dynamic shared memory.
struct SharedRoom {
    uint64_t next, end;
};
// Moves an array there if it fits. Its contents are lost.
SUNSTONE_INLINE void takeRoom(SharedRoom& room, uint64_t& array, uint64_t bytes) {
    bytes = (bytes + 15) / 16 * 16;
    if (room.next + bytes > room.end)
        return;
    array = room.next;
    room.next += bytes;
}

// Returns the job with its scratch in shared memory. Arrays for which threads wait come first.
SUNSTONE_INLINE BuildJob inSharedMemory(BuildJob job, SharedRoom room, SmallScratch& scratch) {
    const uint64_t n = job.maxReferences;
    const uint64_t counters = job.counters;
    job.counters = uint64_t(scratch.counters);
    for (uint32_t i = threadIdx.x; i < kUpdateCounters / 4; i += blockDim.x)
        at<uint32_t>(job.counters)[i] = at<const uint32_t>(counters)[i];
    takeRoom(room, job.parents, 4 * n);
    takeRoom(room, job.values[1], 4 * n);
    takeRoom(room, job.keys[0], 8 * n);
    takeRoom(room, job.binary, sizeof(BinaryNode) * n);
    takeRoom(room, job.tasks, 8 * uint64_t(job.maxWide));
    takeRoom(room, job.savings, 8 * n);
    takeRoom(room, job.values[0], 4 * n);
    takeRoom(room, job.links, 4 * uint64_t(job.maxWide));
    const uint64_t boxes = job.boxes;
    takeRoom(room, job.boxes, sizeof(PrimitiveBox) * n);
    if (job.boxes != boxes)
        for (uint64_t i = threadIdx.x; i < sizeof(PrimitiveBox) / 8 * n; i += blockDim.x)
            at<uint64_t>(job.boxes)[i] = at<const uint64_t>(boxes)[i];
    job.order = job.values[1];
    return job;
}

// Sorts the Morton codes with their primitives: as sort.h, with one tile, and with no memory
// between passes except the result arrays.
SUNSTONE_INLINE void sortInBlock(const BuildJob& job, SmallScratch& scratch) {
    const Counters& counters = countersOf(job);
    const uint32_t total = counters.numReferences, lane = laneOf(), warp = threadIdx.x / 32;
    uint64_t* const sortedKeys = at<uint64_t>(job.keys[0]);
    uint32_t* const sortedValues = at<uint32_t>(job.values[0]);
    uint64_t keys[kSmallItems];
    uint32_t values[kSmallItems], ranks[kSmallItems];
    const auto placeOf = [&](uint32_t i) { return warp * 32 * kSmallItems + i * 32 + lane; };
#pragma unroll
    for (uint32_t i = 0; i < kSmallItems; ++i) {
        keys[i] = ~0ull; // sorted last
        if (placeOf(i) < total)
            keys[i] = codeOf(job, placeOf(i));
        values[i] = placeOf(i) | 1u << kRefCountShift;
    }
#pragma clang loop unroll(disable)
    for (uint32_t shift = 0; shift < 8 * kSortPasses; shift += 8) {
        constexpr uint32_t kRows = kSmallThreads / kSortDigits;
        const uint32_t digit = threadIdx.x % kSortDigits, row = threadIdx.x / kSortDigits;
#pragma unroll
        for (uint32_t w = 0; w < kSmallWarps; w += kRows)
            scratch.counts[w + row][digit] = 0;
        __syncthreads();
#pragma unroll
        for (uint32_t i = 0; i < kSmallItems; ++i)
            ranks[i] = rankInWarp(uint32_t(keys[i] >> shift) & 0xFFu, scratch.counts[warp]);
        __syncthreads();
        uint32_t ofWarps[kSmallWarps], count = 0;
        if (row == 0)
#pragma unroll
            for (uint32_t w = 0; w < kSmallWarps; ++w)
                ofWarps[w] = scratch.counts[w][digit];
        if (row == 0)
#pragma unroll
            for (uint32_t w = 0; w < kSmallWarps; ++w)
                count += ofWarps[w];
        uint32_t before = sumBefore<kSmallThreads>(count, scratch.warpSums);
        if (row == 0)
#pragma unroll
            for (uint32_t w = 0; w < kSmallWarps; ++w) {
                scratch.counts[w][digit] = before;
                before += ofWarps[w];
            }
        __syncthreads();
#pragma unroll
        for (uint32_t i = 0; i < kSmallItems; ++i) {
            const uint32_t place =
                scratch.counts[warp][uint32_t(keys[i] >> shift) & 0xFFu] + ranks[i];
            if (place < total) {
                sortedKeys[place] = keys[i];
                sortedValues[place] = values[i];
            }
        }
        __syncthreads();
#pragma unroll
        for (uint32_t i = 0; i < kSmallItems; ++i)
            if (placeOf(i) < total) {
                keys[i] = sortedKeys[placeOf(i)];
                values[i] = sortedValues[placeOf(i)];
            }
    }
    __syncthreads();
}

// Makes the nodes level by level. Groups of lanes without a node wait at the barrier, where they do
// not slow others down.
SUNSTONE_INLINE void collapseInBlock(const BuildJob& job, TreeMode mode, WideNode* images) {
    const Counters& counters = countersOf(job);
    const NodeLanes lanes = {laneOf() & ~7u, laneOf() & 7u};
    const uint32_t group = threadIdx.x / kSlots, groups = blockDim.x / kSlots;
    uint32_t begin = 0, end = 1;
    for (uint32_t level = 0; begin < end; ++level) {
        // All groups of a warp take part.
        for (uint32_t first = begin; first + (group & ~3u) < end; first += groups) {
            const uint32_t index = first + group;
            const uint64_t task =
                index < end ? loadFresh(at<uint64_t>(job.tasks) + index) : kNoTask;
            makeNodes(job, mode, lanes, task < kNoMoreTasks, index, task, images[group]);
        }
        __syncthreads();
        begin = end;
        end = uint32_t(loadFresh(&counters.allocated));
        end = end < job.maxWide ? end : job.maxWide;
        if (begin < end && threadIdx.x == 0)
            countersOf(job).depth = level + 1;
        __syncthreads();
    }
}

// Makes a tree, and a second one if the first is too deep (sunstone_retry does this for large
// builds).
SUNSTONE_INLINE void makeTreeInBlock(const BuildJob& job, TreeMode mode, SmallScratch& scratch) {
    Counters& counters = countersOf(job);
    const uint32_t count = counters.numTreeReferences;
    for (;;) {
        for (uint32_t i = threadIdx.x; i < job.maxReferences; i += blockDim.x)
            at<uint32_t>(job.parents)[i] = kNoRef;
        for (uint32_t i = threadIdx.x; i < job.maxWide; i += blockDim.x)
            at<uint64_t>(job.tasks)[i] = kNoTask;
        __syncthreads();
        for (uint32_t first = 0; first < count; first += blockDim.x)
            makeHierarchy(job, mode, first + threadIdx.x);
        __syncthreads();
        collapseInBlock(job, mode, scratch.images);
        __syncthreads();
        if (loadFresh(&counters.depth) < kMaxWideDepth || mode == kRadixByLevel)
            return;
        mode = kRadixByLevel;
        __syncthreads(); // before the depth changes
        if (threadIdx.x == 0) {
            counters.tooDeep = 1;
            counters.depth = 0;
            counters.finished = 0;
            counters.nextNode = 0;
            counters.nextTask = 0;
        }
    }
}

// Copies the data that the next kernels read to global memory.
SUNSTONE_INLINE void leaveSharedMemory(const BuildJob& from, const BuildJob& to) {
    const auto copy = [](uint64_t source, uint64_t target, uint64_t words) {
        for (uint64_t i = threadIdx.x; i < words; i += blockDim.x)
            at<uint32_t>(target)[i] = at<const uint32_t>(source)[i];
    };
    const uint32_t numNodes = uint32_t(countersOf(from).allocated);
    const uint64_t nodes = numNodes < from.maxWide ? numNodes : from.maxWide;
    copy(from.counters, to.counters, kUpdateCounters / 4);
    copy(from.tasks, to.tasks, 2 * nodes);
    copy(from.links, to.links, nodes);
    copy(from.order, to.order, from.maxReferences);
}

SUNSTONE_KERNEL __launch_bounds__(kSmallThreads)
    sunstone_small_tree(BuildJob given, TreeMode mode, uint32_t sharedBytes) {
    extern __shared__ U4 room[];
    __shared__ SmallScratch scratch;
    const uint64_t begin = uint64_t(room);
    const BuildJob job = inSharedMemory(given, {begin, begin + sharedBytes}, scratch);
    __syncthreads();
    sortInBlock(job, scratch);
    if (countersOf(job).numTreeReferences != 0)
        makeTreeInBlock(job, mode, scratch);
    __syncthreads();
    countSubtrees(job);
    __syncthreads();
    leaveSharedMemory(job, given);
}

// The first kernel of a build or an update: writes the host's bytes and sets words. Each copy or
// memset of the driver would take as long as a kernel.
SUNSTONE_KERNEL sunstone_begin(BeginJob job) {
    const uint32_t stride = gridDim.x * blockDim.x;
    uint32_t from = 0;
    for (const BeginJob::Part& part : job.parts) {
        for (uint32_t i = globalThread(); i < part.words; i += stride)
            at<uint32_t>(part.to)[i] = job.words[from + i];
        from += part.words;
    }
    for (const BeginJob::Fill& fill : job.fills)
        for (uint64_t i = globalThread(); i < fill.words; i += stride)
            at<uint32_t>(fill.to)[i] = fill.word;
}

} // namespace sunstone::bvh::gpu
