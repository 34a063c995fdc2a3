// SPDX-License-Identifier: Apache-2.0
// Moving a structure to another address. The block itself needs no patching (layout.h). Relocation
// checks the copy, and sets the handles of instances' moved children and the addresses of moved
// opacity micromap arrays.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone::bvh {

struct BlockHeader;
enum class BlockType : uint32_t;

// Identifies copies of a structure. It is equal for all copies and has no addresses, so it may come
// from another process.
struct RelocationInfo {
    uint64_t words[4];
};

// The info of a memory block with this magic number. `details`: data common to all copies.
RelocationInfo makeRelocationInfo(uint32_t magic, uint32_t version, uint32_t count,
                                  uint32_t details, uint64_t size);

// Throws Error(kInvalidValue) if `here`, made from the memory at `block`, differs from `info`.
void requireCopy(const RelocationInfo& info, const RelocationInfo& here, const void* block);

// Throws Error(kInvalidValue) if the address holds no structure.
RelocationInfo relocationInfo(const void* block);
// The info of the structure with this header, on any device.
RelocationInfo relocationInfo(const BlockHeader& header);

// Whether relocationInfo() or micromapRelocationInfo() of a version with the same memory format
// made the info.
bool isRelocatable(const RelocationInfo& info);
// As above, for structures with another magic number, those of GPUs.
bool isRelocatable(const RelocationInfo& info, uint32_t magic);

// The contents of a relocation info.
uint64_t relocatedSize(const RelocationInfo& info);
BlockType relocatedType(const RelocationInfo& info);
bool holdsInstances(const RelocationInfo& info);
uint32_t relocatedPrimitives(const RelocationInfo& info);
// Whether the structure has this many build inputs. (Counts of millions are not distinguished.)
bool hasInputs(const RelocationInfo& info, uint64_t count);

// Makes the copy at `block` usable. The instances get the `count` handles of `children`; null and
// 0: they keep their handles. Throws Error(kInvalidValue) if the memory does not hold a copy of the
// structure, the count differs, or a handle is invalid.
void relocate(const RelocationInfo& info, void* block, const uint64_t* children, size_t count);

// Relocates the micromaps of a relocated structure of triangles. Build input i then uses arrays[i],
// a copy of the array of the build; null: it keeps its array. Throws Error(kInvalidValue) if the
// memory does not hold a copy of the structure, it has no triangles or another number of build
// inputs, or an address holds no array or another one.
void relocateMicromaps(const RelocationInfo& info, void* block, const void* const* arrays,
                       size_t count);

} // namespace sunstone::bvh
