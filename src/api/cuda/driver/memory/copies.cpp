// SPDX-License-Identifier: Apache-2.0
// See copies.h.
#include "api/cuda/driver/memory/copies.h"

#include "api/cuda/driver/device_faults.h"
#include "api/cuda/driver/memory/arrays.h"

#include <algorithm>
#include <cstring>

namespace sunstone::api::cuda {

namespace {

bool multiply(size_t a, size_t b, size_t& result) {
    return !__builtin_mul_overflow(a, b, &result);
}
bool add(size_t a, size_t b, size_t& result) {
    return !__builtin_add_overflow(a, b, &result);
}

// Bytes from the first to the last one accessed.
size_t extentOf(const Side& side, const Shape& shape) {
    size_t rows = 0, slices = 0, total = 0;
    require(multiply(shape.rows - 1, side.pitch, rows) &&
                multiply(shape.slices - 1, side.slicePitch, slices) && add(rows, slices, total) &&
                add(total, shape.width, total),
            "the size of the copy overflows");
    return total;
}

// Device: inside one live allocation. Host: likewise, or mapped memory of the process.
void checkRange(const void* base, size_t size, bool mustBeDevice, bool isWritten) {
    require(base, "an address is null");
    if (cpu::memory().find(base)) {
        if (!cpu::memory().contains(base, size))
            refuse(CUDA_ERROR_INVALID_VALUE, base, " + ", size, " leaves its allocation");
        if (isWritten && !cpu::memory().isWritable(base, size))
            refuse(CUDA_ERROR_INVALID_VALUE, base, " + ", size, " may only be read");
        return;
    }
    if (mustBeDevice)
        refuse(CUDA_ERROR_INVALID_VALUE, base, " is in no allocation");
    if (!cpu::isMapped(base, size))
        refuse(CUDA_ERROR_INVALID_VALUE, base, " + ", size, " is not memory of this process");
}

const void* pointerOf(CUdeviceptr address) {
    return reinterpret_cast<const void*>(address);
}

// A block of an array; x and the width are bytes.
Side sideOfArray(CUarray handle, size_t x, size_t y, size_t z, const Shape& shape) {
    require(handle, "an array is null");
    texture::Array& array = *arrayOf(handle)->array;
    size_t right = 0, bottom = 0, back = 0;
    require(add(x, shape.width, right) && right <= array.rowPitch() && add(y, shape.rows, bottom) &&
                bottom <= array.rowCount() && add(z, shape.slices, back) &&
                back <= array.shape().slices(),
            "the copy leaves the array");
    return {reinterpret_cast<std::byte*>(array.data()) + z * array.slicePitch() +
                y * array.rowPitch() + x,
            array.rowPitch(), array.slicePitch()};
}

// One side of a description; isDevice: the description or the address says that it is device
// memory.
Side sideOf(CUmemorytype type, const void* host, CUdeviceptr device, CUarray array, size_t x,
            size_t y, size_t z, size_t pitch, size_t height, const Shape& shape, bool& isDevice) {
    const size_t width = shape.width;
    const void* base = nullptr;
    isDevice = type == CU_MEMORYTYPE_DEVICE;
    switch (type) {
    case CU_MEMORYTYPE_HOST:
        base = host;
        break;
    case CU_MEMORYTYPE_DEVICE:
    case CU_MEMORYTYPE_UNIFIED:
        base = pointerOf(device);
        break;
    case CU_MEMORYTYPE_ARRAY:
        return sideOfArray(array, x, y, z, shape);
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "memory type ", int(type), " is unknown");
    }
    require(base, "an address is null");
    size_t right = 0, bottom = 0, slicePitch = 0, offset = 0, slices = 0, rows = 0;
    require(add(x, width, right) && (pitch == 0 || right <= pitch),
            "rows are longer than the pitch");
    require(add(y, shape.rows, bottom) && (height == 0 || bottom <= height),
            "there are more rows than the height of a slice");
    pitch = pitch ? pitch : right; // 0: the smallest possible
    height = height ? height : bottom;
    require(pitch <= kMaxPitch || (shape.rows == 1 && shape.slices == 1),
            "a pitch exceeds CU_DEVICE_ATTRIBUTE_MAX_PITCH");
    require(multiply(pitch, height, slicePitch) && multiply(slicePitch, z, slices) &&
                multiply(pitch, y, rows) && add(slices, rows, offset) && add(offset, x, offset),
            "an offset overflows");
    // A range that begins in an allocation is not host memory, for any offset.
    isDevice = isDevice || cpu::memory().find(base);
    size_t first = 0;
    require(add(uintptr_t(base), offset, first), "an offset overflows");
    return {reinterpret_cast<std::byte*>(first), pitch, slicePitch};
}

void copyBytes(const Copy& copy) {
    const auto& [dst, src, shape, dstDevice, srcDevice] = copy;
    if (shape.empty())
        return; // the addresses may be null
    for (size_t z = 0; z < shape.slices; ++z)
        for (size_t y = 0; y < shape.rows; ++y)
            std::memmove(dst.base + z * dst.slicePitch + y * dst.pitch,
                         src.base + z * src.slicePitch + y * src.pitch, shape.width);
}

template <class T>
void fill(const Side& side, size_t width, size_t height, T value) {
    for (size_t y = 0; y < height; ++y)
        std::fill_n(reinterpret_cast<T*>(side.base + y * side.pitch), width, value);
}

void setBytes(const Set& set) {
    if (set.elementSize == 1)
        fill(set.side, set.width, set.height, uint8_t(set.value));
    else if (set.elementSize == 2)
        fill(set.side, set.width, set.height, uint16_t(set.value));
    else
        fill(set.side, set.width, set.height, set.value);
}

} // namespace

void Copy::check() const {
    checkRange(dst.base, extentOf(dst, shape), dstDevice, true);
    checkRange(src.base, extentOf(src, shape), srcDevice, false);
}

void Copy::run() const {
    accessMemory("a copy", [this] { copyBytes(*this); });
}

bool Copy::touchesPageable() const {
    return !cpu::memory().find(src.base) || !cpu::memory().find(dst.base);
}

Copy linearCopy(const void* dst, const void* src, size_t bytes, bool dstDevice, bool srcDevice) {
    return {{static_cast<std::byte*>(const_cast<void*>(dst))},
            {static_cast<std::byte*>(const_cast<void*>(src))},
            {bytes},
            dstDevice,
            srcDevice};
}

Copy copyOf(const CUDA_MEMCPY3D& d) {
    Copy copy;
    copy.shape = {d.WidthInBytes, d.Height, d.Depth};
    if (copy.shape.empty())
        return copy;
    require((d.srcMemoryType != CU_MEMORYTYPE_ARRAY || d.srcLOD == 0) &&
                (d.dstMemoryType != CU_MEMORYTYPE_ARRAY || d.dstLOD == 0),
            "a level of detail is not 0");
    copy.src = sideOf(d.srcMemoryType, d.srcHost, d.srcDevice, d.srcArray, d.srcXInBytes, d.srcY,
                      d.srcZ, d.srcPitch, d.srcHeight, copy.shape, copy.srcDevice);
    copy.dst = sideOf(d.dstMemoryType, d.dstHost, d.dstDevice, d.dstArray, d.dstXInBytes, d.dstY,
                      d.dstZ, d.dstPitch, d.dstHeight, copy.shape, copy.dstDevice);
    return copy;
}

CUDA_MEMCPY3D widen(const CUDA_MEMCPY2D& d) {
    CUDA_MEMCPY3D wide = {};
    wide.srcXInBytes = d.srcXInBytes;
    wide.srcY = d.srcY;
    wide.srcMemoryType = d.srcMemoryType;
    wide.srcHost = d.srcHost;
    wide.srcDevice = d.srcDevice;
    wide.srcArray = d.srcArray;
    wide.srcPitch = d.srcPitch;
    wide.dstXInBytes = d.dstXInBytes;
    wide.dstY = d.dstY;
    wide.dstMemoryType = d.dstMemoryType;
    wide.dstHost = d.dstHost;
    wide.dstDevice = d.dstDevice;
    wide.dstArray = d.dstArray;
    wide.dstPitch = d.dstPitch;
    wide.WidthInBytes = d.WidthInBytes;
    wide.Height = d.Height;
    wide.Depth = 1;
    return wide;
}

CUDA_MEMCPY3D describe(const Copy& linear) {
    CUDA_MEMCPY3D d = {};
    d.srcMemoryType = CU_MEMORYTYPE_UNIFIED;
    d.srcDevice = reinterpret_cast<CUdeviceptr>(linear.src.base);
    d.dstMemoryType = CU_MEMORYTYPE_UNIFIED;
    d.dstDevice = reinterpret_cast<CUdeviceptr>(linear.dst.base);
    d.WidthInBytes = d.srcPitch = d.dstPitch = linear.shape.width;
    d.Height = d.Depth = d.srcHeight = d.dstHeight = 1;
    return d;
}

void Set::check() const {
    require(elementSize == 1 || elementSize == 2 || elementSize == 4,
            "the size of an element must be 1, 2 or 4 bytes");
    Shape shape{0, height};
    require(multiply(width, elementSize, shape.width), "the size overflows");
    require(height == 1 || side.pitch >= shape.width, "rows are longer than the pitch");
    require(uintptr_t(side.base) % elementSize == 0 &&
                (height == 1 || side.pitch % elementSize == 0),
            "address or pitch is not aligned to the value");
    checkRange(side.base, extentOf(side, shape), true, true);
}

void Set::run() const {
    accessMemory("a set", [this] { setBytes(*this); });
}

} // namespace sunstone::api::cuda
