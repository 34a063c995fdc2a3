// SPDX-License-Identifier: Apache-2.0
// Moving a structure to another address. The block itself needs no patching (layout.h); relocation
// recognises the copy, and gives instances the handles of their moved children and triangles the
// addresses of their moved opacity micromap arrays.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone::bvh {

struct BlockHeader;
enum class BlockType : uint32_t;

// Identifies copies of a structure. The same for all copies, and without addresses, so that it may
// come from another process.
struct RelocationInfo {
    uint64_t words[4];
};

// Of a memory block with such a magic number. `details`: any data common to all copies.
RelocationInfo makeRelocationInfo(uint32_t magic, uint32_t version, uint32_t count,
                                  uint32_t details, uint64_t size);

// Throws Error(kInvalidValue) if `here`, made from the memory at `block`, is not `info`.
void requireCopy(const RelocationInfo& info, const RelocationInfo& here, const void* block);

// Throws Error(kInvalidValue) if the address holds no structure.
RelocationInfo relocationInfo(const void* block);
// Of the structure with this header, on any device.
RelocationInfo relocationInfo(const BlockHeader& header);

// Whether the words were made by relocationInfo() or micromapRelocationInfo() of a version that writes
// the same memory format.
bool isRelocatable(const RelocationInfo& info);
// The same for structures that begin with another magic number, those of GPUs.
bool isRelocatable(const RelocationInfo& info, uint32_t magic);

// The contents of a relocation info.
uint64_t relocatedSize(const RelocationInfo& info);
BlockType relocatedType(const RelocationInfo& info);
bool holdsInstances(const RelocationInfo& info);
uint32_t relocatedPrimitives(const RelocationInfo& info);
// Whether the structure has this many build inputs. (Counts of millions are not distinguished.)
bool hasInputs(const RelocationInfo& info, uint64_t count);

// Makes the copy at `block` usable. Instances get the `count` handles of `children`, one each; null
// and 0: they keep theirs. Throws Error(kInvalidValue) if the memory does not hold a copy of the
// structure, the count differs, or a handle is invalid.
void relocate(const RelocationInfo& info, void* block, const uint64_t* children, size_t count);

// Relocates the micromaps of a relocated structure of triangles: build input i uses arrays[i] from
// now on, a copy of the array it was built with; null: it keeps that. Throws Error(kInvalidValue)
// if the memory does not hold a copy of the structure, it has no triangles or another number of
// build inputs, or an address holds no array or another one.
void relocateMicromaps(const RelocationInfo& info, void* block, const void* const* arrays,
                       size_t count);

} // namespace sunstone::bvh
