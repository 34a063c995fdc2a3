// SPDX-License-Identifier: Apache-2.0
// Functions that the builders of all kinds of structures share.
#pragma once

#include "bvh/build/build.h"
#include "bvh/layout.h"

#include <span>

namespace sunstone::bvh {

constexpr uint32_t kMaxPrimitives = 1u << 30;
// References are made in blocks of this many primitives.
constexpr size_t kReferenceBlock = 1u << 14;
// Scratch size of updates that need none. It is not 0, because a caller may be unable to allocate 0
// bytes; only updates of instances with motion keys need more (updateTempSize).
constexpr size_t kUpdateTempSize = kBlockAlignment;

inline uint64_t alignUp(uint64_t value, uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

// The options as OptionBits.
uint32_t optionBits(const BuildOptions& options);

// Throws Error(kInvalidValue) if the buffer is null, misaligned or too small.
void checkBuffer(const char* name, const void* buffer, size_t size, size_t needed);

// Throws Error(kInvalidValue) unless a structure with this header may be updated from inputs of
// this shape.
void checkSameShape(const BlockHeader& header, const BlockHeader& wanted);
void checkSameShape(const BlockHeader& header, const BuildOptions& options, BlockType type,
                    uint32_t keys, uint32_t numInputs, uint32_t numPrimitives);

// Throws Error(kInvalidValue) if the records of the present build inputs differ in shape from those
// of the build.
void checkSameInputs(std::span<const InputRecord> now, const InputRecord* then);

} // namespace sunstone::bvh
