// SPDX-License-Identifier: Apache-2.0
// Copies and sets, and allocation in stream order. Compiled twice, see shell.h. All are queued
// work; the synchronous forms wait for it. Ranges are checked before anything is queued.
#include "api/cuda/driver/arrays.h"
#include "api/cuda/driver/shell.h"

#include <cstring>

using namespace sunstone;
using namespace sunstone::api::cuda;
using cpu::MemoryKind;

namespace {

// One side of a copy: `rows` x `slices` of a pitched block.
struct Side {
    std::byte* base = nullptr;
    size_t pitch = 0;      // between rows
    size_t slicePitch = 0; // between slices
};
struct Shape {
    size_t width = 0, rows = 1, slices = 1;
};

bool multiply(size_t a, size_t b, size_t& result) {
    return !__builtin_mul_overflow(a, b, &result);
}
bool add(size_t a, size_t b, size_t& result) {
    return !__builtin_add_overflow(a, b, &result);
}

// Bytes from the first to the last touched.
size_t extentOf(const Side& side, const Shape& shape) {
    size_t rows = 0, slices = 0, total = 0;
    require(multiply(shape.rows - 1, side.pitch, rows) &&
                multiply(shape.slices - 1, side.slicePitch, slices) && add(rows, slices, total) &&
                add(total, shape.width, total),
            "the size of the copy overflows");
    return total;
}

// Device: inside one live allocation. Host: likewise, or mapped memory of the process.
void checkRange(const void* base, size_t size, bool mustBeDevice) {
    require(base, "an address is null");
    if (cpu::memory().find(base)) {
        if (!cpu::memory().contains(base, size))
            refuse(CUDA_ERROR_INVALID_VALUE, base, " + ", size, " leaves its allocation");
        return;
    }
    if (mustBeDevice)
        refuse(CUDA_ERROR_INVALID_VALUE, base, " is in no allocation");
    if (!cpu::isMapped(base, size))
        refuse(CUDA_ERROR_INVALID_VALUE, base, " + ", size, " is not memory of this process");
}

void copyShape(const Side& dst, const Side& src, const Shape& shape) {
    for (size_t z = 0; z < shape.slices; ++z)
        for (size_t y = 0; y < shape.rows; ++y)
            std::memmove(dst.base + z * dst.slicePitch + y * dst.pitch,
                         src.base + z * src.slicePitch + y * src.pitch, shape.width);
}

// Whether the memory is the application's own pages, which it may change or free as soon as an
// asynchronous call returns... as far as CUDA promises for copies from pageable memory.
bool isPageable(const void* address) {
    return !cpu::memory().find(address);
}

void queueCopy(const Side& dst, const Side& src, const Shape& shape, CUstream stream, bool wait,
               bool dstDevice, bool srcDevice) {
    cpu::StreamPtr target = resolveStream(stream);
    if (shape.width == 0 || shape.rows == 0 || shape.slices == 0)
        return;
    const size_t dstBytes = extentOf(dst, shape), srcBytes = extentOf(src, shape);
    checkRange(dst.base, dstBytes, dstDevice);
    checkRange(src.base, srcBytes, srcDevice);
    // Copies from or to pageable memory return when the application may touch it again.
    wait = wait || isPageable(src.base) || isPageable(dst.base);
    if (wait && cpu::streams().idle(target)) {
        cpu::streams().throwError(target);
        copyShape(dst, src, shape); // nothing to wait for: no need for another thread
        return;
    }
    cpu::streams().submit(target, [=] { copyShape(dst, src, shape); });
    if (wait)
        cpu::streams().synchronize(target);
}

CUresult linear(const char* function, const void* dst, const void* src, size_t bytes,
                CUstream stream, bool wait, bool dstDevice, bool srcDevice) {
    return guarded(function, Needs::kContext, [&] {
        Side to{static_cast<std::byte*>(const_cast<void*>(dst))};
        Side from{static_cast<std::byte*>(const_cast<void*>(src))};
        queueCopy(to, from, {bytes}, stream, wait, dstDevice, srcDevice);
    });
}

const void* pointerOf(CUdeviceptr address) {
    return reinterpret_cast<const void*>(address);
}

// Reads one side of a 2D or 3D description; false if it is device memory by type.
// A block of an array; x and the width are bytes.
Side sideOfArray(CUarray handle, size_t x, size_t y, size_t z, const Shape& shape) {
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
    case CU_MEMORYTYPE_ARRAY: return sideOfArray(array, x, y, z, shape);
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "memory type ", int(type), " is unknown");
    }
    if (pitch == 0)
        pitch = width;
    require(base, "an address is null");
    require(pitch <= kMaxPitch, "a pitch exceeds CU_DEVICE_ATTRIBUTE_MAX_PITCH");
    size_t right = 0, slicePitch = 0, offset = 0, slices = 0, rows = 0;
    require(add(x, width, right) && right <= pitch, "rows are longer than the pitch");
    require(multiply(pitch, height, slicePitch) && multiply(slicePitch, z, slices) &&
                multiply(pitch, y, rows) && add(slices, rows, offset) && add(offset, x, offset),
            "an offset overflows");
    return {static_cast<std::byte*>(const_cast<void*>(base)) + offset, pitch, slicePitch};
}

CUresult copy2D(const char* function, const CUDA_MEMCPY2D* copy, CUstream stream, bool wait) {
    return guarded(function, Needs::kContext, [&] {
        require(copy, "copy is null");
        if (copy->WidthInBytes == 0 || copy->Height == 0) {
            resolveStream(stream);
            return;
        }
        bool dstDevice = false, srcDevice = false;
        const Side src = sideOf(copy->srcMemoryType, copy->srcHost, copy->srcDevice, copy->srcArray,
                                copy->srcXInBytes, copy->srcY, 0, copy->srcPitch, 0,
                                {copy->WidthInBytes, copy->Height}, srcDevice);
        const Side dst = sideOf(copy->dstMemoryType, copy->dstHost, copy->dstDevice, copy->dstArray,
                                copy->dstXInBytes, copy->dstY, 0, copy->dstPitch, 0,
                                {copy->WidthInBytes, copy->Height}, dstDevice);
        queueCopy(dst, src, {copy->WidthInBytes, copy->Height}, stream, wait, dstDevice, srcDevice);
    });
}

CUresult copy3D(const char* function, const CUDA_MEMCPY3D* copy, CUstream stream, bool wait) {
    return guarded(function, Needs::kContext, [&] {
        require(copy, "copy is null");
        require(copy->srcLOD == 0 && copy->dstLOD == 0, "a level of detail is not 0");
        if (copy->WidthInBytes == 0 || copy->Height == 0 || copy->Depth == 0) {
            resolveStream(stream);
            return;
        }
        const size_t srcRows = copy->srcHeight ? copy->srcHeight : copy->Height;
        const size_t dstRows = copy->dstHeight ? copy->dstHeight : copy->Height;
        const Shape shape{copy->WidthInBytes, copy->Height, copy->Depth};
        bool dstDevice = false, srcDevice = false;
        const Side src = sideOf(copy->srcMemoryType, copy->srcHost, copy->srcDevice, copy->srcArray,
                                copy->srcXInBytes, copy->srcY, copy->srcZ, copy->srcPitch, srcRows,
                                shape, srcDevice);
        const Side dst = sideOf(copy->dstMemoryType, copy->dstHost, copy->dstDevice, copy->dstArray,
                                copy->dstXInBytes, copy->dstY, copy->dstZ, copy->dstPitch, dstRows,
                                shape, dstDevice);
        queueCopy(dst, src, shape, stream, wait, dstDevice, srcDevice);
    });
}

template <class T>
void fill(std::byte* row, T value, size_t count) {
    if constexpr (sizeof(T) == 1)
        std::memset(row, value, count);
    else
        std::fill_n(reinterpret_cast<T*>(row), count, value);
}

template <class T>
CUresult set(const char* function, CUdeviceptr dst, size_t pitch, T value, size_t width,
             size_t height, CUstream stream, bool wait) {
    return guarded(function, Needs::kContext, [&] {
        cpu::StreamPtr target = resolveStream(stream);
        if (width == 0 || height == 0)
            return;
        Side side{static_cast<std::byte*>(const_cast<void*>(pointerOf(dst))), pitch};
        Shape shape{0, height};
        require(multiply(width, sizeof(T), shape.width), "the size overflows");
        require(height == 1 || pitch >= shape.width, "rows are longer than the pitch");
        require(dst % sizeof(T) == 0 && (height == 1 || pitch % sizeof(T) == 0),
                "address or pitch is not aligned to the value");
        checkRange(side.base, extentOf(side, shape), true);
        auto work = [=] {
            for (size_t y = 0; y < height; ++y)
                fill<T>(side.base + y * pitch, value, width);
        };
        if (wait && cpu::streams().idle(target)) {
            cpu::streams().throwError(target);
            work();
            return;
        }
        cpu::streams().submit(target, work);
        if (wait)
            cpu::streams().synchronize(target);
    });
}

void requirePeers(CUcontext a, CUcontext b) {
    requireContext(a);
    requireContext(b);
}

} // namespace

SUNSTONE_EXPORT CUresult cuMemcpy(CUdeviceptr dst, CUdeviceptr src, size_t bytes) {
    return linear("cuMemcpy", pointerOf(dst), pointerOf(src), bytes, nullptr, true, false, false);
}
SUNSTONE_EXPORT CUresult cuMemcpyAsync(CUdeviceptr dst, CUdeviceptr src, size_t bytes,
                                       CUstream stream) {
    return linear("cuMemcpyAsync", pointerOf(dst), pointerOf(src), bytes, stream, false, false,
                  false);
}
SUNSTONE_EXPORT CUresult cuMemcpyHtoD(CUdeviceptr dst, const void* src, size_t bytes) {
    return linear("cuMemcpyHtoD", pointerOf(dst), src, bytes, nullptr, true, true, false);
}
SUNSTONE_EXPORT CUresult cuMemcpyHtoDAsync(CUdeviceptr dst, const void* src, size_t bytes,
                                           CUstream stream) {
    return linear("cuMemcpyHtoDAsync", pointerOf(dst), src, bytes, stream, false, true, false);
}
SUNSTONE_EXPORT CUresult cuMemcpyDtoH(void* dst, CUdeviceptr src, size_t bytes) {
    return linear("cuMemcpyDtoH", dst, pointerOf(src), bytes, nullptr, true, false, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyDtoHAsync(void* dst, CUdeviceptr src, size_t bytes,
                                           CUstream stream) {
    return linear("cuMemcpyDtoHAsync", dst, pointerOf(src), bytes, stream, false, false, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyDtoD(CUdeviceptr dst, CUdeviceptr src, size_t bytes) {
    return linear("cuMemcpyDtoD", pointerOf(dst), pointerOf(src), bytes, nullptr, true, true, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyDtoDAsync(CUdeviceptr dst, CUdeviceptr src, size_t bytes,
                                           CUstream stream) {
    return linear("cuMemcpyDtoDAsync", pointerOf(dst), pointerOf(src), bytes, stream, false, true,
                  true);
}
SUNSTONE_EXPORT CUresult cuMemcpyPeer(CUdeviceptr dst, CUcontext dstContext, CUdeviceptr src,
                                      CUcontext srcContext, size_t bytes) {
    const CUresult result =
        guarded("cuMemcpyPeer", Needs::kContext, [&] { requirePeers(dstContext, srcContext); });
    return result ? result
                  : linear("cuMemcpyPeer", pointerOf(dst), pointerOf(src), bytes, nullptr, true,
                           true, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyPeerAsync(CUdeviceptr dst, CUcontext dstContext, CUdeviceptr src,
                                           CUcontext srcContext, size_t bytes, CUstream stream) {
    const CUresult result = guarded("cuMemcpyPeerAsync", Needs::kContext,
                                    [&] { requirePeers(dstContext, srcContext); });
    return result ? result
                  : linear("cuMemcpyPeerAsync", pointerOf(dst), pointerOf(src), bytes, stream,
                           false, true, true);
}

SUNSTONE_EXPORT CUresult cuMemcpy2D(const CUDA_MEMCPY2D* copy) {
    return copy2D("cuMemcpy2D", copy, nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpy2DUnaligned(const CUDA_MEMCPY2D* copy) {
    return copy2D("cuMemcpy2DUnaligned", copy, nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpy2DAsync(const CUDA_MEMCPY2D* copy, CUstream stream) {
    return copy2D("cuMemcpy2DAsync", copy, stream, false);
}
SUNSTONE_EXPORT CUresult cuMemcpy3D(const CUDA_MEMCPY3D* copy) {
    return copy3D("cuMemcpy3D", copy, nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpy3DAsync(const CUDA_MEMCPY3D* copy, CUstream stream) {
    return copy3D("cuMemcpy3DAsync", copy, stream, false);
}

#define SUNSTONE_SETS(bits, T)                                                                     \
    SUNSTONE_EXPORT CUresult cuMemsetD##bits(CUdeviceptr dst, T value, size_t count) {             \
        return set<T>("cuMemsetD" #bits, dst, 0, value, count, 1, nullptr, true);                  \
    }                                                                                              \
    SUNSTONE_EXPORT CUresult cuMemsetD##bits##Async(CUdeviceptr dst, T value, size_t count,        \
                                                    CUstream stream) {                             \
        return set<T>("cuMemsetD" #bits "Async", dst, 0, value, count, 1, stream, false);          \
    }                                                                                              \
    SUNSTONE_EXPORT CUresult cuMemsetD2D##bits(CUdeviceptr dst, size_t pitch, T value,             \
                                               size_t width, size_t height) {                      \
        return set<T>("cuMemsetD2D" #bits, dst, pitch, value, width, height, nullptr, true);       \
    }                                                                                              \
    SUNSTONE_EXPORT CUresult cuMemsetD2D##bits##Async(                                             \
        CUdeviceptr dst, size_t pitch, T value, size_t width, size_t height, CUstream stream) {    \
        return set<T>("cuMemsetD2D" #bits "Async", dst, pitch, value, width, height, stream,       \
                      false);                                                                      \
    }
SUNSTONE_SETS(8, unsigned char)
SUNSTONE_SETS(16, unsigned short)
SUNSTONE_SETS(32, unsigned int)

SUNSTONE_EXPORT CUresult cuMemAllocAsync(CUdeviceptr* address, size_t bytes, CUstream stream) {
    return guarded("cuMemAllocAsync", Needs::kContext, [&] {
        require(address, "address is null");
        resolveStream(stream);
        // Memory that exists early serves as well as memory that exists in time.
        *address = reinterpret_cast<CUdeviceptr>(
            cpu::memory().allocate(bytes, MemoryKind::kDevice, 0, cpu::contexts().current()));
    });
}
SUNSTONE_EXPORT CUresult cuMemFreeAsync(CUdeviceptr address, CUstream stream) {
    return guarded("cuMemFreeAsync", Needs::kContext, [&] {
        cpu::StreamPtr target = resolveStream(stream);
        auto found = cpu::memory().find(pointerOf(address));
        require(found && found->base == address && found->kind == MemoryKind::kDevice,
                "not the start of a live device allocation");
        cpu::streams().submit(target, [address] {
            if (!cpu::memory().release(pointerOf(address), {MemoryKind::kDevice}))
                refuse(CUDA_ERROR_INVALID_VALUE, pointerOf(address), " was freed twice");
        });
    });
}
