// SPDX-License-Identifier: Apache-2.0
// The opacity micromap of each triangle of a structure: fills MicromapRecord and MicromapRef of the
// block (layout.h) from build inputs.
#pragma once

#include "bvh/input/build_input.h"
#include "bvh/layout.h"
#include "bvh/micromap/micromap.h"

namespace sunstone::bvh {

inline MicromapRecord* micromapRecords(void* block) {
    return reinterpret_cast<MicromapRecord*>(static_cast<uint8_t*>(block) +
                                             headerOf(block)->micromapsOffset);
}
inline const MicromapRecord* micromapRecords(const void* block) {
    return micromapRecords(const_cast<void*>(block));
}

// Bytes that records and refs of these inputs need; 0 without micromaps.
uint64_t micromapTableSize(std::span<const TriangleInput> inputs);

// Fills records and refs at micromapsOffset of the header, whose InputRecords must be set. Throws
// Error(kInvalidValue) if an input's array is invalid. A triangle whose index is out of range has
// no micromap.
void bindMicromaps(uint8_t* block, std::span<const TriangleInput> inputs);

// Throws Error(kInvalidValue) if an update cannot have these micromaps: other indexing than in the
// build, or other arrays without the option to change them.
void checkMicromapUpdate(const BlockHeader& header, std::span<const TriangleInput> inputs);
// As above, with the structure's records (null: none) and option.
void checkMicromapUpdate(const MicromapRecord* records, bool mayChange,
                         std::span<const TriangleInput> inputs);

// Throws Error(kInvalidValue) if the memory at `array` does not hold a copy of the array of input
// i.
void requireSameArray(const BlockHeader& header, size_t i, const void* array);

} // namespace sunstone::bvh
