// SPDX-License-Identifier: Apache-2.0
// Moving a structure to another address. The block itself needs no patching (layout.h); what there
// is to do is to recognise the copy and to give instances the handles of their moved children.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone::bvh {

// What tells a copy from other memory. The same for all copies of a structure, and no address is in
// it, so that it may come from another process.
struct RelocationInfo {
    uint64_t words[4];
};

// Throws Error(kInvalidValue) if there is no structure at the address.
RelocationInfo relocationInfo(const void* block);

// Whether the words were made by relocationInfo() of a version that writes the same memory format.
bool isRelocatable(const RelocationInfo& info);

// Of relocatable infos: what they tell.
uint64_t relocatedSize(const RelocationInfo& info);
bool holdsInstances(const RelocationInfo& info);
uint32_t relocatedPrimitives(const RelocationInfo& info);

// Makes the copy at `block` usable. Instances get the `count` handles of `children`, one each; null
// and 0: they keep those they have. Throws Error(kInvalidValue) if the memory holds no copy of the
// structure, the count differs, or a handle leads nowhere.
void relocate(const RelocationInfo& info, void* block, const uint64_t* children, size_t count);

} // namespace sunstone::bvh
