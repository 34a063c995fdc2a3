// SPDX-License-Identifier: Apache-2.0
// Copies to, from and between arrays, where offsets along x are bytes. Compiled twice, see
// runtime.h.
#include "api/cuda/runtime/arrays.h"

#include <algorithm>

using namespace sunstone::cudart;

namespace {

// The memory type of the side of a 2D copy that is not an array.
CUmemorytype memoryType(cudaMemcpyKind kind, bool toArray) {
    switch (kind) {
    case cudaMemcpyHostToDevice:
        return toArray ? CU_MEMORYTYPE_HOST : CU_MEMORYTYPE_ARRAY;
    case cudaMemcpyDeviceToHost:
        return toArray ? CU_MEMORYTYPE_ARRAY : CU_MEMORYTYPE_HOST;
    case cudaMemcpyDeviceToDevice:
        return CU_MEMORYTYPE_DEVICE;
    case cudaMemcpyDefault:
        return CU_MEMORYTYPE_UNIFIED;
    default:
        return CU_MEMORYTYPE_ARRAY;
    }
}

cudaError_t queue(const CUDA_MEMCPY2D& copy, cudaStream_t stream, bool wait) {
    return call([&](const Driver& driver) {
        const CUstream target = streamOf(stream);
        CUresult result = driver.cuMemcpy2DAsync(&copy, target);
        if (!result && wait)
            result = driver.cuStreamSynchronize(target);
        return result;
    });
}

cudaError_t toArray(cudaArray_t dst, size_t x, size_t y, const void* src, size_t pitch,
                    size_t width, size_t height, cudaMemcpyKind kind, cudaStream_t stream,
                    bool wait) {
    if (!dst)
        return remember(cudaErrorInvalidResourceHandle);
    CUDA_MEMCPY2D copy = {};
    copy.srcMemoryType = memoryType(kind, true);
    if (copy.srcMemoryType == CU_MEMORYTYPE_ARRAY) // this kind does not fit a copy to an array
        return remember(cudaErrorInvalidMemcpyDirection);
    if (height > 1 && width > pitch)
        return remember(cudaErrorInvalidPitchValue);
    copy.srcHost = src;
    copy.srcDevice = addressOf(src);
    copy.srcPitch = pitch;
    copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.dstArray = arrayOf(dst);
    copy.dstXInBytes = x;
    copy.dstY = y;
    copy.WidthInBytes = width;
    copy.Height = height;
    return queue(copy, stream, wait);
}

cudaError_t fromArray(void* dst, size_t pitch, cudaArray_const_t src, size_t x, size_t y,
                      size_t width, size_t height, cudaMemcpyKind kind, cudaStream_t stream,
                      bool wait) {
    if (!src)
        return remember(cudaErrorInvalidResourceHandle);
    CUDA_MEMCPY2D copy = {};
    copy.dstMemoryType = memoryType(kind, false);
    if (copy.dstMemoryType == CU_MEMORYTYPE_ARRAY)
        return remember(cudaErrorInvalidMemcpyDirection);
    if (height > 1 && width > pitch)
        return remember(cudaErrorInvalidPitchValue);
    copy.dstHost = dst;
    copy.dstDevice = addressOf(dst);
    copy.dstPitch = pitch;
    copy.srcMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.srcArray = arrayOf(src);
    copy.srcXInBytes = x;
    copy.srcY = y;
    copy.WidthInBytes = width;
    copy.Height = height;
    return queue(copy, stream, wait);
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaMemcpy2DToArray(cudaArray_t dst, size_t x, size_t y,
                                                const void* src, size_t pitch, size_t width,
                                                size_t height, enum cudaMemcpyKind kind) {
    return toArray(dst, x, y, src, pitch, width, height, kind, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy2DToArrayAsync(cudaArray_t dst, size_t x, size_t y,
                                                     const void* src, size_t pitch, size_t width,
                                                     size_t height, enum cudaMemcpyKind kind,
                                                     cudaStream_t stream) {
    return toArray(dst, x, y, src, pitch, width, height, kind, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy2DFromArray(void* dst, size_t pitch, cudaArray_const_t src,
                                                  size_t x, size_t y, size_t width, size_t height,
                                                  enum cudaMemcpyKind kind) {
    return fromArray(dst, pitch, src, x, y, width, height, kind, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy2DFromArrayAsync(void* dst, size_t pitch,
                                                       cudaArray_const_t src, size_t x, size_t y,
                                                       size_t width, size_t height,
                                                       enum cudaMemcpyKind kind,
                                                       cudaStream_t stream) {
    return fromArray(dst, pitch, src, x, y, width, height, kind, stream, false);
}
namespace {

// A position in the rows of an array, taken in sequence.
struct Cursor {
    size_t x, y, rowBytes;

    size_t rest() const { return rowBytes - x; }
    void advance(size_t bytes) {
        x += bytes;
        if (x == rowBytes) {
            x = 0;
            ++y;
        }
    }
};
cudaError_t startAt(cudaArray_const_t array, size_t x, size_t y, Cursor* cursor) {
    if (const cudaError_t error = ensureContext())
        return error;
    CUDA_ARRAY3D_DESCRIPTOR d = {};
    Element element;
    if (const CUresult result = driver().cuArray3DGetDescriptor(&d, arrayOf(array)))
        return fromDriver(result);
    if (const CUresult result = elementOf(driver(), array, &element))
        return fromDriver(result);
    *cursor = {x, y, (d.Width + element.edge - 1) / element.edge * element.bytes};
    return x < cursor->rowBytes ? cudaSuccess : cudaErrorInvalidValue;
}

// Calls `copy(offset, bytes)` for each piece of the bytes that lies in one row of both arrays.
template <class Copy>
cudaError_t inRows(Cursor* a, Cursor* b, size_t bytes, Copy&& copy) {
    size_t done = 0;
    while (done < bytes) {
        const size_t piece = std::min({bytes - done, a->rest(), b ? b->rest() : bytes});
        if (const cudaError_t error = copy(done, piece))
            return error;
        a->advance(piece);
        if (b)
            b->advance(piece);
        done += piece;
    }
    return cudaSuccess;
}

cudaError_t bytesToArray(cudaArray_t dst, size_t x, size_t y, const void* src, size_t bytes,
                         cudaMemcpyKind kind, cudaStream_t stream, bool wait) {
    Cursor to;
    if (const cudaError_t error = startAt(dst, x, y, &to))
        return remember(error);
    return inRows(&to, nullptr, bytes, [&](size_t offset, size_t piece) {
        return toArray(dst, to.x, to.y, static_cast<const char*>(src) + offset, piece, piece, 1,
                       kind, stream, wait);
    });
}
cudaError_t bytesFromArray(void* dst, cudaArray_const_t src, size_t x, size_t y, size_t bytes,
                           cudaMemcpyKind kind, cudaStream_t stream, bool wait) {
    Cursor from;
    if (const cudaError_t error = startAt(src, x, y, &from))
        return remember(error);
    return inRows(&from, nullptr, bytes, [&](size_t offset, size_t piece) {
        return fromArray(static_cast<char*>(dst) + offset, piece, src, from.x, from.y, piece, 1,
                         kind, stream, wait);
    });
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaMemcpyToArray(cudaArray_t dst, size_t x, size_t y, const void* src,
                                              size_t bytes, enum cudaMemcpyKind kind) {
    return bytesToArray(dst, x, y, src, bytes, kind, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyFromArray(void* dst, cudaArray_const_t src, size_t x,
                                                size_t y, size_t bytes, enum cudaMemcpyKind kind) {
    return bytesFromArray(dst, src, x, y, bytes, kind, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyToArrayAsync(cudaArray_t dst, size_t x, size_t y,
                                                   const void* src, size_t bytes,
                                                   enum cudaMemcpyKind kind, cudaStream_t stream) {
    return bytesToArray(dst, x, y, src, bytes, kind, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyFromArrayAsync(void* dst, cudaArray_const_t src, size_t x,
                                                     size_t y, size_t bytes,
                                                     enum cudaMemcpyKind kind,
                                                     cudaStream_t stream) {
    return bytesFromArray(dst, src, x, y, bytes, kind, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyArrayToArray(cudaArray_t dst, size_t dstX, size_t dstY,
                                                   cudaArray_const_t src, size_t srcX, size_t srcY,
                                                   size_t bytes, enum cudaMemcpyKind kind) {
    Cursor to, from;
    if (const cudaError_t error = startAt(dst, dstX, dstY, &to))
        return remember(error);
    if (const cudaError_t error = startAt(src, srcX, srcY, &from))
        return remember(error);
    return inRows(&to, &from, bytes, [&](size_t, size_t piece) {
        return cudaMemcpy2DArrayToArray(dst, to.x, to.y, src, from.x, from.y, piece, 1, kind);
    });
}
SUNSTONE_CUDART cudaError_t cudaMemcpy2DArrayToArray(cudaArray_t dst, size_t dstX, size_t dstY,
                                                     cudaArray_const_t src, size_t srcX,
                                                     size_t srcY, size_t width, size_t height,
                                                     enum cudaMemcpyKind kind) {
    if (kind != cudaMemcpyDeviceToDevice && kind != cudaMemcpyDefault)
        return remember(cudaErrorInvalidMemcpyDirection);
    CUDA_MEMCPY2D copy = {};
    copy.srcMemoryType = copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.srcArray = arrayOf(src);
    copy.srcXInBytes = srcX;
    copy.srcY = srcY;
    copy.dstArray = arrayOf(dst);
    copy.dstXInBytes = dstX;
    copy.dstY = dstY;
    copy.WidthInBytes = width;
    copy.Height = height;
    return queue(copy, nullptr, true);
}
