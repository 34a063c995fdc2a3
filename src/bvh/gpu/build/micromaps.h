// SPDX-License-Identifier: Apache-2.0
// Opacity micromaps (bvh/micromap/micromap.h): arrays, and the micromap of each triangle of a
// structure. Both equal the CPU's byte for byte.
//
//   micromap_refs    the place of each micromap's states, by prefix sums; one block
//   micromap_states  copies the states, a warp for each micromap; marks uniform ones in their refs
//   micromap_finish  marks the array as valid
//   micromaps        the micromap of each triangle, into the tables of a structure
//   relocate_micromaps  updates the address of a build input's array
#pragma once

#include "bvh/gpu/build/refit.h"
#include "bvh/gpu/build/sort.h"
#include "bvh/micromap/micromap_refs.h"

namespace sunstone::bvh::gpu {

// A header word during the build of an array: 1 while the array is valid.
SUNSTONE_INLINE uint32_t& goesWell(const MicromapJob& job) {
    return at<MicromapArrayHeader>(job.output)->pad[0];
}
SUNSTONE_INLINE MicromapRef* refsOf(const MicromapJob& job) {
    return at<MicromapRef>(job.output + job.refsOffset);
}

struct DeviceMicromap {
    uint32_t byteOffset, level;
    MicromapFormat format;
};
SUNSTONE_INLINE DeviceMicromap readMicromap(const MicromapJob& job, uint32_t i) {
    const auto* const words =
        at<const uint32_t>(job.descriptions + uint64_t(i) * job.descriptionStride);
    return {words[0], words[1] & 0xFFFFu, MicromapFormat(words[1] >> 16)};
}

// Subtracts a description from the histogram's counts. Returns its bytes of states, or 0 if the
// histogram does not count it.
SUNSTONE_INLINE uint32_t countMicromap(const MicromapJob& job, const DeviceMicromap& m,
                                       uint32_t* left) {
    const bool two = m.format == MicromapFormat::kTwoState;
    if (m.level > kMaxMicromapLevel || (!two && m.format != MicromapFormat::kFourState))
        return 0;
    const uint32_t bytes = uint32_t(micromapBytes(m.level, m.format));
    const bool counted = atomicSub(&left[(two ? 0 : kMicromapLevels) + m.level], 1u) - 1 < ~0u >> 1;
    return counted && uint64_t(m.byteOffset) + bytes <= job.statesSize ? bytes : 0;
}

// One block of kSortThreads. Descriptions that do not fit are reported to the host.
SUNSTONE_KERNEL __launch_bounds__(kSortThreads) sunstone_micromap_refs(MicromapJob job) {
    __shared__ uint32_t left[2 * kMicromapLevels], warpSums[kSortThreads / 32], last, bad;
    for (uint32_t i = threadIdx.x; i < 2 * kMicromapLevels; i += blockDim.x)
        left[i] = job.counts[i];
    if (threadIdx.x == 0)
        bad = 0;
    __syncthreads();
    uint64_t before = job.dataOffset;
    for (uint32_t first = 0; first < job.numMicromaps; first += kSortThreads) {
        const uint32_t i = first + threadIdx.x;
        uint32_t bytes = 0;
        DeviceMicromap m = {};
        if (i < job.numMicromaps) {
            m = readMicromap(job, i);
            bytes = countMicromap(job, m, left);
            if (bytes == 0)
                atomicExch(&bad, 1u);
        }
        // Sums within a tile of 256 micromaps, each of up to 4 MiB.
        const uint32_t place = sumBefore(bytes, warpSums);
        if (bytes)
            refsOf(job)[i] = makeMicromapRef(before + place, m.level, m.format);
        if (threadIdx.x == kSortThreads - 1)
            last = place + bytes;
        __syncthreads();
        before += last;
        __syncthreads();
    }
    if (threadIdx.x != 0)
        return;
    MicromapArrayHeader& header = *at<MicromapArrayHeader>(job.output);
    header.version = kMicromapVersion;
    header.usedSize = job.usedSize;
    header.refsOffset = job.refsOffset;
    header.dataOffset = job.dataOffset;
    header.numMicromaps = job.numMicromaps;
    goesWell(job) = !bad;
    if (bad)
        reportFailure(job.report, job.output, kMicromapsDoNotFit);
}

SUNSTONE_KERNEL sunstone_micromap_states(MicromapJob job) {
    if (!goesWell(job))
        return;
    const uint32_t lane = laneOf(), warps = gridDim.x * blockDim.x / 32;
    for (uint32_t i = globalThread() / 32; i < job.numMicromaps; i += warps) {
        const DeviceMicromap m = readMicromap(job, i);
        const auto* const from = at<const uint8_t>(job.states + m.byteOffset);
        auto* const to = at<uint8_t>(job.output + (refsOf(job)[i] >> 8));
        const uint32_t bytes = uint32_t(micromapBytes(m.level, m.format));
        const uint32_t state = from[0] & (m.format == MicromapFormat::kTwoState ? 1u : 3u);
        const uint32_t filled = filledByte(state, m.format), used = usedBits(m.level, m.format);
        bool same = true;
        for (uint32_t k = lane; k < bytes; k += 32) {
            to[k] = from[k];
            same = same && ((from[k] ^ filled) & used) == 0;
        }
        if (__all_sync(kWholeWarp, same) && lane == 0)
            refsOf(job)[i] = makeUniformRef(MicromapState(state));
    }
}

SUNSTONE_KERNEL sunstone_micromap_finish(MicromapJob job) {
    MicromapArrayHeader& header = *at<MicromapArrayHeader>(job.output);
    if (goesWell(job))
        header.magic = kMicromapMagic;
    header.pad[0] = 0;
}

// ---- of a structure ---------------------------------------------------------------------------

SUNSTONE_KERNEL sunstone_micromaps(BuildJob given) {
    if (countersOf(given).failure)
        return;
    const BuildJob job = inStructure(given);
    auto* const table = at<MicromapRecord>(job.output + headerIn(job).micromapsOffset);
    for (uint32_t i = globalThread(); i < job.numPrimitives; i += gridDim.x * blockDim.x) {
        const uint32_t n = inputOfPrimitive(job, i);
        const DeviceInput& input = at<const DeviceInput>(job.inputs)[n];
        if (input.micromapIndexing == 0)
            continue;
        const auto& array = *at<const MicromapArrayHeader>(input.micromaps);
        if (!looksLikeMicromapArray(&array)) {
            atomicExch(&countersOf(job).failure, uint32_t(kNoMicromapArray));
            return;
        }
        const uint32_t local = i - at<const InputRecord>(job.inputRecords)[n].firstPrimitive;
        MicromapRecord& record = table[n];
        if (local == 0) {
            record.array = input.micromaps;
            record.arraySize = array.usedSize;
            record.numMicromaps = array.numMicromaps;
        }
        const bool indexed = MicromapIndexing(input.micromapIndexing) == MicromapIndexing::kIndexed;
        const int64_t index =
            indexed ? micromapIndexAt(at<const uint8_t>(input.micromapIndices),
                                      input.micromapIndexSize, input.micromapIndexStride, local)
                    : int64_t(local);
        bool valid = true;
        at<MicromapRef>(job.output + record.refsOffset)[local] = micromapRefOf(
            index, input.micromapIndexOffset,
            at<const MicromapRef>(input.micromaps + array.refsOffset), array.numMicromaps, valid);
    }
}

// Runs with one thread, by the rules of bvh::relocateMicromaps.
SUNSTONE_KERNEL sunstone_relocate_micromaps(uint64_t block, uint64_t report, uint32_t input,
                                            uint64_t array) {
    const BlockHeader& header = *at<const BlockHeader>(block);
    const auto& is = *at<const MicromapArrayHeader>(array);
    MicromapRecord* const record =
        header.magic == kGpuBlockMagic && header.micromapsOffset != 0 && input < header.numInputs
            ? at<MicromapRecord>(block + header.micromapsOffset) + input
            : nullptr;
    if (!record || !record->refsOffset || !looksLikeMicromapArray(&is) ||
        is.usedSize != record->arraySize || is.numMicromaps != record->numMicromaps)
        return reportFailure(report, block, kNoMicromapCopy);
    record->array = array;
}

} // namespace sunstone::bvh::gpu
