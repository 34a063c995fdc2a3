// SPDX-License-Identifier: Apache-2.0
// Triangles to which several leaves refer. If PREFER_FAST_TRACE has split many triangles, each
// triangle has one record, in the order of the inputs, and leaves hold numbers of triangles:
//
//   .. | TriangleRecord of each triangle | numbers of triangles, backwards | WideNode[]
//
// The numbers end at the start of the nodes, so that traversal finds them from the nodes' address.
// Inactive triangles have records without references. The header's sharesRecords is set if records
// are shared. Traversal keeps this flag in the lowest bit of the records' address, and saves both
// together when it enters an instance.
#pragma once

#include "bvh/gpu/layout.h"
#include "bvh/gpu/portable.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

constexpr uint64_t kSharedTag = 1;

SUNSTONE_INLINE bool areShared(uint64_t taggedRecords) {
    return taggedRecords & kSharedTag;
}
SUNSTONE_INLINE uint64_t withoutTag(uint64_t taggedRecords) {
    return taggedRecords & ~kSharedTag;
}

// Bytes of the numbers of so many references.
SUNSTONE_INLINE uint64_t sharedNumbers(uint64_t references) {
    return (references * 4 + 127) / 128 * 128;
}

// The number of the triangle to which a reference refers.
SUNSTONE_INLINE const uint32_t* sharedNumber(const void* nodes, uint32_t reference) {
    return static_cast<const uint32_t*>(nodes) - 1 - uint64_t(reference);
}

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
