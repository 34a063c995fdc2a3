// SPDX-License-Identifier: Apache-2.0
// Shared by relocations of acceleration structures and of opacity micromap arrays.
#pragma once

#include "api/optix7/shell.h"
#include "bvh/relocate.h"

namespace sunstone::optix7 {

static_assert(sizeof(OptixRelocationInfo) == sizeof(bvh::RelocationInfo));

inline bvh::RelocationInfo translate(const OptixRelocationInfo& info) {
    bvh::RelocationInfo out;
    std::memcpy(&out, &info, sizeof(out));
    return out;
}

// Throws an Error naming the parameter unless `size` bytes at `address` are device memory.
inline void requireDeviceMemory(device::Device& device, const char* name, CUdeviceptr address,
                                size_t size, unsigned alignment) {
    void* pointer = reinterpret_cast<void*>(address);
    if (!pointer)
        fail(Code::kInvalidValue, name, " is 0");
    if (address % alignment != 0)
        fail(Code::kInvalidValue, name, " = ", pointer, " is not a multiple of ", alignment);
    if (!device.isAccessible(pointer, size))
        fail(Code::kInvalidValue, name, " = ", pointer, " with ", size,
             " bytes is not device memory");
}

} // namespace sunstone::optix7
