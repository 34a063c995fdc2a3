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
// Only updates of instances with motion keys need scratch memory (updateTempSize); others report a
// little, because a caller may be unable to allocate 0 bytes.
constexpr size_t kUpdateTempSize = kBlockAlignment;

inline uint64_t alignUp(uint64_t value, uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

// OptionBits of the options.
uint32_t optionBits(const BuildOptions& options);

// Throws Error(kInvalidValue) if the buffer is null, misaligned or too small.
void checkBuffer(const char* name, const void* buffer, size_t size, size_t needed);

// Throws Error(kInvalidValue) unless a structure with this header may be updated from inputs of
// this shape.
void checkSameShape(const BlockHeader& header, const BlockHeader& wanted);
void checkSameShape(const BlockHeader& header, const BuildOptions& options, BlockType type,
                    uint32_t keys, uint32_t numInputs, uint32_t numPrimitives);

// The same for the records of its build inputs, as they are now and were in the build.
void checkSameInputs(std::span<const InputRecord> now, const InputRecord* then);

} // namespace sunstone::bvh
