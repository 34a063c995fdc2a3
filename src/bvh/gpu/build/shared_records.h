// SPDX-License-Identifier: Apache-2.0
// Triangles that several leaves refer to. Where PREFER_FAST_TRACE has split many triangles, each
// triangle has one record, in the order of the inputs, and leaves hold numbers of triangles:
//
//   .. | TriangleRecord of each triangle | numbers of triangles, backwards | WideNode[]
//
// The numbers end where the nodes begin, so that a walk finds them from the nodes' address.
// Inactive triangles have records without references. The lowest bit of the header's recordsOffset
// says that records are shared; it stays set in the address that a walk computes from it.
#pragma once

#include "bvh/gpu/layout.h"
#include "bvh/gpu/portable.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

constexpr uint64_t kSharedBit = 1;

SUNSTONE_GPU_INLINE bool areShared(uint64_t records) {
    return records & kSharedBit;
}
SUNSTONE_GPU_INLINE uint64_t withoutSharedBit(uint64_t records) {
    return records & ~kSharedBit;
}

// Bytes of the numbers, for so many references.
SUNSTONE_GPU_INLINE uint64_t sharedNumbers(uint64_t references) {
    return (references * 4 + 127) / 128 * 128;
}

// The triangle that a reference is to.
SUNSTONE_GPU_INLINE const uint32_t* sharedNumber(const void* nodes, uint32_t reference) {
    return static_cast<const uint32_t*>(nodes) - 1 - uint64_t(reference);
}

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
