// SPDX-License-Identifier: Apache-2.0
#include "bvh/micromap/micromap_array.h"

#include "base/error.h"
#include "base/threads/threads.h"
#include "bvh/parallel.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace sunstone::bvh {
namespace {

// Exceeds every index of a triangle and the size of every buffer.
constexpr uint64_t kMaxMicromaps = 1u << 30;
constexpr uint64_t kMaxStateBytes = uint64_t(1) << 40;
// Callers allocate this size, and some cannot allocate 0 bytes.
constexpr size_t kTempSize = kMicromapArrayAlignment;

using Counts = MicromapCounts;

bool isKind(uint32_t level, MicromapFormat format) {
    return level <= kMaxMicromapLevel &&
           (format == MicromapFormat::kTwoState || format == MicromapFormat::kFourState);
}

Counts countsOf(std::span<const MicromapHistogramEntry> histogram) {
    Counts counts;
    for (size_t i = 0; i < histogram.size(); ++i) {
        const MicromapHistogramEntry& entry = histogram[i];
        if (!isKind(entry.level, entry.format))
            fail(Code::kInvalidValue, "histogram entry ", i, " has level ", entry.level,
                 " and format ", uint32_t(entry.format), ": levels are 0..", kMaxMicromapLevel,
                 ", formats 1 and 2");
        counts.at(entry.level, entry.format) += entry.count;
    }
    return counts;
}

struct Plan : MicromapArrayLayout {
    explicit Plan(std::span<const MicromapHistogramEntry> histogram) {
        counts = countsOf(histogram);
        numMicromaps = 0;
        for (const auto& ofFormat : counts.of)
            for (uint64_t count : ofFormat)
                numMicromaps += std::min(count, kMaxMicromaps + 1);
        uint64_t bytes = 0;
        for (uint32_t level = 0; level <= kMaxMicromapLevel; ++level)
            for (MicromapFormat format : {MicromapFormat::kTwoState, MicromapFormat::kFourState})
                bytes += std::min(counts.at(level, format), kMaxMicromaps) *
                         micromapBytes(level, format);
        if (numMicromaps > kMaxMicromaps || bytes > kMaxStateBytes)
            fail(Code::kInvalidValue, "an array of ", numMicromaps, " micromaps with ", bytes,
                 " bytes of states: the limits are ", kMaxMicromaps, " and ", kMaxStateBytes);
        refsOffset = sizeof(MicromapArrayHeader);
        dataOffset = refsOffset + numMicromaps * sizeof(MicromapRef);
        const uint64_t end = dataOffset + bytes;
        usedSize =
            (end + kMicromapArrayAlignment - 1) / kMicromapArrayAlignment * kMicromapArrayAlignment;
    }
};

MicromapDesc descriptionAt(const MicromapArrayInput& input, uint64_t i) {
    const uint64_t stride =
        input.descriptionStride ? input.descriptionStride : sizeof(MicromapDesc);
    MicromapDesc desc;
    std::memcpy(&desc, static_cast<const uint8_t*>(input.descriptions) + i * stride, sizeof(desc));
    return desc;
}

// Reads all descriptions in order; visit(number, description, format).
template <class Visit>
void forEachMicromap(const MicromapArrayInput& input, const Visit& visit) {
    Counts left = countsOf(input.histogram);
    const uint64_t count = micromapCount(input.histogram);
    if (count && (!input.descriptions || !input.states))
        fail(Code::kInvalidValue, count, " micromaps without descriptions or states");
    for (uint64_t i = 0; i < count; ++i) {
        const MicromapDesc desc = descriptionAt(input, i);
        const MicromapFormat format = MicromapFormat(desc.format);
        if (!isKind(desc.level, format) || left.at(desc.level, format) == 0)
            fail(Code::kInvalidValue, "micromap ", i, " has level ", desc.level, " and format ",
                 desc.format, ": not one that the histogram counts");
        --left.at(desc.level, format);
        visit(i, desc, format);
    }
}

// The state that all micro-triangles have, or kNoMicromap. Bits after the last one in its byte are
// ignored.
MicromapState uniformState(const uint8_t* states, uint32_t level, MicromapFormat format) {
    const bool two = format == MicromapFormat::kTwoState;
    const uint8_t first = states[0] & (two ? 1 : 3);
    if ((states[0] ^ filledByte(first, format)) & usedBits(level, format))
        return kNoMicromap;
    const uint64_t bytes = micromapBytes(level, format);
    return std::memcmp(states, states + 1, bytes - 1) == 0 ? MicromapState(first) : kNoMicromap;
}

const MicromapArrayHeader& checkedHeader(const void* array) {
    if (!isMicromapArray(array))
        fail(Code::kInvalidValue, array, " is no opacity micromap array");
    return *static_cast<const MicromapArrayHeader*>(array);
}

} // namespace

MicromapArrayLayout micromapArrayLayout(std::span<const MicromapHistogramEntry> histogram) {
    return Plan(histogram);
}

uint64_t micromapCount(std::span<const MicromapHistogramEntry> histogram) {
    return Plan(histogram).numMicromaps;
}

MicromapArraySizes micromapArraySizes(std::span<const MicromapHistogramEntry> histogram) {
    return {Plan(histogram).usedSize, kTempSize};
}

uint64_t checkMicromaps(const MicromapArrayInput& input) {
    uint64_t end = 0;
    forEachMicromap(input, [&](uint64_t, const MicromapDesc& desc, MicromapFormat format) {
        end = std::max(end, desc.byteOffset + micromapBytes(desc.level, format));
    });
    return end;
}

void buildMicromapArray(const MicromapArrayInput& input, void* output, size_t outputSize) {
    const Plan plan(input.histogram);
    if (!output || uintptr_t(output) % kMicromapArrayAlignment != 0)
        fail(Code::kInvalidValue, "the output buffer is ", output, ": must be a multiple of ",
             kMicromapArrayAlignment);
    if (outputSize < plan.usedSize)
        fail(Code::kInvalidValue, "the output buffer has ", outputSize, " bytes, the array needs ",
             plan.usedSize);
    auto* const bytes = static_cast<uint8_t*>(output);
    auto& header = *static_cast<MicromapArrayHeader*>(output);
    header = {};
    // The magic number is written last, so that an incomplete array is not valid.
    auto* const refs = reinterpret_cast<MicromapRef*>(bytes + plan.refsOffset);
    uint64_t place = plan.dataOffset;
    forEachMicromap(input, [&](uint64_t i, const MicromapDesc& desc, MicromapFormat format) {
        refs[i] = makeMicromapRef(place, desc.level, format);
        place += micromapBytes(desc.level, format);
    });
    std::memset(bytes + place, 0, plan.usedSize - place);
    auto copy = [&](size_t begin, size_t end, size_t) {
        for (size_t i = begin; i < end; ++i) {
            const uint32_t level = refs[i] >> 4 & 15;
            const bool two = (refs[i] & 3) == kRefTwoState;
            const MicromapFormat format =
                two ? MicromapFormat::kTwoState : MicromapFormat::kFourState;
            uint8_t* const to = bytes + (refs[i] >> 8);
            std::memcpy(
                to, static_cast<const uint8_t*>(input.states) + descriptionAt(input, i).byteOffset,
                micromapBytes(level, format));
            const MicromapState state = uniformState(to, level, format);
            if (state != kNoMicromap)
                refs[i] = makeUniformRef(state);
        }
    };
    inArena([&] { parallelBlocks(plan.numMicromaps, 256, copy); });
    header.version = kMicromapVersion;
    header.usedSize = plan.usedSize;
    header.refsOffset = plan.refsOffset;
    header.dataOffset = plan.dataOffset;
    header.numMicromaps = uint32_t(plan.numMicromaps);
    header.magic = kMicromapMagic;
}

bool isMicromapArray(const void* array) {
    return array && uintptr_t(array) % kMicromapArrayAlignment == 0 &&
           looksLikeMicromapArray(static_cast<const MicromapArrayHeader*>(array));
}

RelocationInfo micromapRelocationInfo(const void* array) {
    const MicromapArrayHeader& header = checkedHeader(array);
    return makeRelocationInfo(header.magic, header.version, header.numMicromaps, 0,
                              header.usedSize);
}

bool holdsMicromaps(const RelocationInfo& info) {
    return uint32_t(info.words[0]) == kMicromapMagic;
}

void relocateMicromapArray(const RelocationInfo& info, void* array) {
    if (!isRelocatable(info) || !holdsMicromaps(info))
        fail(Code::kInvalidValue, "the relocation info is not that of an opacity micromap array");
    requireCopy(info, micromapRelocationInfo(array), array);
}

} // namespace sunstone::bvh
