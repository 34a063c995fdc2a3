// SPDX-License-Identifier: Apache-2.0
// The micromap of a triangle, by the indices of its build input. For builders on the CPU and on
// GPUs: it compiles as CUDA too.
#pragma once

#include "bvh/build/build.h"
#include "bvh/micromap/micromap.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh {

constexpr int64_t kLastPredefinedIndex = -4;

// The index of a triangle in an index buffer, whose largest values are the predefined indices.
inline int64_t micromapIndexAt(const uint8_t* indices, uint32_t size, uint64_t stride,
                               uint64_t triangle) {
    const uint8_t* const at = indices + triangle * stride;
    if (size == 4) {
        int32_t index;
        __builtin_memcpy(&index, at, sizeof(index));
        return index;
    }
    uint16_t index;
    __builtin_memcpy(&index, at, sizeof(index));
    return index >= 0x10000 + kLastPredefinedIndex ? index - 0x10000 : index;
}

// The reference to the micromap of an index, among `count` of an array; `valid` becomes false if
// the index is out of range.
inline MicromapRef micromapRefOf(int64_t index, uint32_t indexOffset, const MicromapRef* refs,
                                 uint64_t count, bool& valid) {
    if (index < 0 && index >= kLastPredefinedIndex)
        return makeUniformRef(MicromapState(-1 - index));
    const uint64_t place = uint64_t(index) + indexOffset;
    if (index >= 0 && place < count)
        return refs[place];
    valid = false;
    return makeUniformRef(kNoMicromap);
}

} // namespace sunstone::bvh

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
