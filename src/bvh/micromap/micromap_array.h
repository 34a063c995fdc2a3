// SPDX-License-Identifier: Apache-2.0
// Builds arrays of opacity micromaps into a buffer of the caller, and relocates them. The rules for
// buffers are those of build.h: addresses are host addresses, contents are not trusted. Read
// micromap.h first.
#pragma once

#include "bvh/micromap/micromap.h"
#include "bvh/relocate.h"

#include <array>
#include <span>

namespace sunstone::bvh {

// The number of micromaps of one kind in an array. Several entries of one kind add up.
struct MicromapHistogramEntry {
    uint32_t count;
    uint32_t level;
    MicromapFormat format;
};

// The 8 bytes that describe one micromap of the input.
struct MicromapDesc {
    uint32_t byteOffset; // of its states in the input buffer
    uint16_t level;
    uint16_t format;
};
static_assert(sizeof(MicromapDesc) == 8);

struct MicromapArrayInput {
    std::span<const MicromapHistogramEntry> histogram;
    const void* states = nullptr;       // base of MicromapDesc::byteOffset
    const void* descriptions = nullptr; // MicromapDesc records
    uint32_t descriptionStride = 0;     // 0: packed
};

struct MicromapArraySizes {
    size_t output = 0;
    size_t temp = 0;
};

constexpr size_t kMicromapArrayAlignment = 128;

// The number of micromaps of each kind.
struct MicromapCounts {
    std::array<std::array<uint64_t, kMaxMicromapLevel + 1>, 2> of{};

    uint64_t& at(uint32_t level, MicromapFormat format) {
        return of[format == MicromapFormat::kFourState][level];
    }
};

// The places of the parts of an array.
struct MicromapArrayLayout {
    MicromapCounts counts;
    uint64_t numMicromaps, refsOffset, dataOffset, usedSize;
};

// Throws as micromapArraySizes.
MicromapArrayLayout micromapArrayLayout(std::span<const MicromapHistogramEntry> histogram);

// Number of micromaps that the histogram has.
uint64_t micromapCount(std::span<const MicromapHistogramEntry> histogram);

// The sizes of any array with this histogram. Throws Error(kInvalidValue) for an unknown level or
// format, and for more micromaps than an array can hold.
MicromapArraySizes micromapArraySizes(std::span<const MicromapHistogramEntry> histogram);

// The number of bytes of `states` that the descriptions refer to. Throws Error(kInvalidValue) if
// they contradict the histogram.
uint64_t checkMicromaps(const MicromapArrayInput& input);

// Builds into `output` (128-byte aligned). The bytes of states that checkMicromaps() returns must
// be readable. Throws as checkMicromaps(), and Error(kInvalidValue) if the output buffer is too
// small; `output` then holds no array.
void buildMicromapArray(const MicromapArrayInput& input, void* output, size_t outputSize);

// Whether the memory at this address holds an array. It must be readable.
bool isMicromapArray(const void* array);

// As relocationInfo() for structures, for an array.
RelocationInfo micromapRelocationInfo(const void* array);
bool holdsMicromaps(const RelocationInfo& info);

// Makes the copy at `array` usable. Throws Error(kInvalidValue) if the memory does not hold a copy
// of the info's array.
void relocateMicromapArray(const RelocationInfo& info, void* array);

} // namespace sunstone::bvh
