// SPDX-License-Identifier: Apache-2.0
// Copies and sets. Compiled twice, see runtime.h. The synchronous forms queue the work and wait for
// it.
#include "api/cuda/runtime/arrays.h"
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

namespace {

// Queues work with `queue(driver, stream)` and waits if asked.
template <class Queue>
cudaError_t queued(cudaStream_t stream, bool wait, Queue&& queue) {
    return call([&](const Driver& d) {
        CUstream target = streamOf(stream);
        CUresult result = queue(d, target);
        if (!result && wait)
            result = d.cuStreamSynchronize(target);
        return result;
    });
}

cudaError_t copyLinear(void* dst, const void* src, size_t bytes, cudaMemcpyKind kind,
                       cudaStream_t stream, bool wait) {
    if (unsigned(kind) > cudaMemcpyDefault)
        return remember(cudaErrorInvalidMemcpyDirection);
    return queued(stream, wait, [&](const Driver& d, CUstream target) {
        switch (kind) {
        case cudaMemcpyHostToDevice:
            return d.cuMemcpyHtoDAsync(addressOf(dst), src, bytes, target);
        case cudaMemcpyDeviceToHost:
            return d.cuMemcpyDtoHAsync(dst, addressOf(src), bytes, target);
        case cudaMemcpyDeviceToDevice:
            return d.cuMemcpyDtoDAsync(addressOf(dst), addressOf(src), bytes, target);
        default:
            return d.cuMemcpyAsync(addressOf(dst), addressOf(src), bytes, target);
        }
    });
}

cudaError_t copy2D(void* dst, size_t dstPitch, const void* src, size_t srcPitch, size_t width,
                   size_t height, cudaMemcpyKind kind, cudaStream_t stream, bool wait) {
    if (unsigned(kind) > cudaMemcpyDefault)
        return remember(cudaErrorInvalidMemcpyDirection);
    if (height > 1 && (width > dstPitch || width > srcPitch))
        return remember(cudaErrorInvalidPitchValue);
    CUDA_MEMCPY2D copy = {};
    copy.srcMemoryType = typeOf(kind, false);
    copy.srcHost = src;
    copy.srcDevice = addressOf(src);
    copy.srcPitch = srcPitch;
    copy.dstMemoryType = typeOf(kind, true);
    copy.dstHost = dst;
    copy.dstDevice = addressOf(dst);
    copy.dstPitch = dstPitch;
    copy.WidthInBytes = width;
    copy.Height = height;
    return queued(stream, wait, [&](const Driver& d, CUstream target) {
        return d.cuMemcpy2DAsync(&copy, target);
    });
}

cudaError_t copy3D(const cudaMemcpy3DParms* parms, cudaStream_t stream, bool wait) {
    if (!parms)
        return remember(cudaErrorInvalidValue);
    if (const cudaError_t error = ensureContext())
        return remember(error);
    CUDA_MEMCPY3D copy = {};
    if (const cudaError_t error = toDriver(*parms, &copy))
        return remember(error);
    return queued(stream, wait, [&](const Driver& d, CUstream target) {
        return d.cuMemcpy3DAsync(&copy, target);
    });
}

cudaError_t toSymbol(const void* symbol, const void* src, size_t bytes, size_t offset,
                     cudaMemcpyKind kind, cudaStream_t stream, bool wait) {
    void* address = nullptr;
    if (kind != cudaMemcpyHostToDevice && kind != cudaMemcpyDeviceToDevice &&
        kind != cudaMemcpyDefault)
        return remember(cudaErrorInvalidMemcpyDirection);
    if (cudaError_t error = findInVariable(symbol, bytes, offset, &address))
        return error;
    return copyLinear(address, src, bytes, kind, stream, wait);
}
cudaError_t fromSymbol(void* dst, const void* symbol, size_t bytes, size_t offset,
                       cudaMemcpyKind kind, cudaStream_t stream, bool wait) {
    void* address = nullptr;
    if (kind != cudaMemcpyDeviceToHost && kind != cudaMemcpyDeviceToDevice &&
        kind != cudaMemcpyDefault)
        return remember(cudaErrorInvalidMemcpyDirection);
    if (cudaError_t error = findInVariable(symbol, bytes, offset, &address))
        return error;
    return copyLinear(dst, address, bytes, kind, stream, wait);
}

cudaError_t set(void* dst, int value, size_t bytes, cudaStream_t stream, bool wait) {
    return queued(stream, wait, [&](const Driver& d, CUstream target) {
        return d.cuMemsetD8Async(addressOf(dst), static_cast<unsigned char>(value), bytes, target);
    });
}
cudaError_t set2D(void* dst, size_t pitch, int value, size_t width, size_t height,
                  cudaStream_t stream, bool wait) {
    return queued(stream, wait, [&](const Driver& d, CUstream target) {
        return d.cuMemsetD2D8Async(addressOf(dst), pitch, static_cast<unsigned char>(value), width,
                                   height, target);
    });
}

// Sets slice after slice, because bytes that must not change may lie between the slices.
cudaError_t set3D(const cudaPitchedPtr& dst, int value, const cudaExtent& extent,
                  cudaStream_t stream, bool wait) {
    const bool isRow = extent.height <= 1 && extent.depth <= 1;
    size_t slice = 0;
    if ((extent.width > dst.pitch && !isRow) || extent.height > dst.ysize ||
        __builtin_mul_overflow(dst.pitch, dst.ysize, &slice))
        return remember(cudaErrorInvalidValue);
    return queued(stream, wait, [&](const Driver& d, CUstream target) {
        const size_t slices = extent.width && extent.height ? extent.depth : 0;
        CUresult result = CUDA_SUCCESS;
        for (size_t z = 0; z < slices && !result; ++z)
            result = d.cuMemsetD2D8Async(addressOf(dst.ptr) + z * slice, dst.pitch,
                                         static_cast<unsigned char>(value), extent.width,
                                         extent.height, target);
        return result;
    });
}

// All devices see the same addresses.
cudaError_t copyPeer(const cudaMemcpy3DPeerParms* parms, cudaStream_t stream, bool wait) {
    if (!parms)
        return remember(cudaErrorInvalidValue);
    int count = 0;
    if (const cudaError_t error = cudaGetDeviceCount(&count))
        return error;
    const auto exists = [&](int device) { return device >= 0 && device < count; };
    if (!exists(parms->srcDevice) || !exists(parms->dstDevice))
        return remember(cudaErrorInvalidDevice);
    const cudaMemcpy3DParms plain = {parms->srcArray, parms->srcPos,           parms->srcPtr,
                                     parms->dstArray, parms->dstPos,           parms->dstPtr,
                                     parms->extent,   cudaMemcpyDeviceToDevice};
    return copy3D(&plain, stream, wait);
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaMemcpy(void* dst, const void* src, size_t bytes,
                                       enum cudaMemcpyKind kind) {
    return copyLinear(dst, src, bytes, kind, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyAsync(void* dst, const void* src, size_t bytes,
                                            enum cudaMemcpyKind kind, cudaStream_t stream) {
    return copyLinear(dst, src, bytes, kind, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy2D(void* dst, size_t dstPitch, const void* src,
                                         size_t srcPitch, size_t width, size_t height,
                                         enum cudaMemcpyKind kind) {
    return copy2D(dst, dstPitch, src, srcPitch, width, height, kind, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy2DAsync(void* dst, size_t dstPitch, const void* src,
                                              size_t srcPitch, size_t width, size_t height,
                                              enum cudaMemcpyKind kind, cudaStream_t stream) {
    return copy2D(dst, dstPitch, src, srcPitch, width, height, kind, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy3D(const struct cudaMemcpy3DParms* copy) {
    return copy3D(copy, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy3DAsync(const struct cudaMemcpy3DParms* copy,
                                              cudaStream_t stream) {
    return copy3D(copy, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyToSymbol(const void* symbol, const void* src, size_t bytes,
                                               size_t offset, enum cudaMemcpyKind kind) {
    return toSymbol(symbol, src, bytes, offset, kind, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyToSymbolAsync(const void* symbol, const void* src,
                                                    size_t bytes, size_t offset,
                                                    enum cudaMemcpyKind kind, cudaStream_t stream) {
    return toSymbol(symbol, src, bytes, offset, kind, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyFromSymbol(void* dst, const void* symbol, size_t bytes,
                                                 size_t offset, enum cudaMemcpyKind kind) {
    return fromSymbol(dst, symbol, bytes, offset, kind, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyFromSymbolAsync(void* dst, const void* symbol, size_t bytes,
                                                      size_t offset, enum cudaMemcpyKind kind,
                                                      cudaStream_t stream) {
    return fromSymbol(dst, symbol, bytes, offset, kind, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemset(void* dst, int value, size_t bytes) {
    return set(dst, value, bytes, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemsetAsync(void* dst, int value, size_t bytes,
                                            cudaStream_t stream) {
    return set(dst, value, bytes, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemset2D(void* dst, size_t pitch, int value, size_t width,
                                         size_t height) {
    return set2D(dst, pitch, value, width, height, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemset2DAsync(void* dst, size_t pitch, int value, size_t width,
                                              size_t height, cudaStream_t stream) {
    return set2D(dst, pitch, value, width, height, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemset3D(struct cudaPitchedPtr dst, int value,
                                         struct cudaExtent extent) {
    return set3D(dst, value, extent, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemset3DAsync(struct cudaPitchedPtr dst, int value,
                                              struct cudaExtent extent, cudaStream_t stream) {
    return set3D(dst, value, extent, stream, false);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy3DPeer(const struct cudaMemcpy3DPeerParms* copy) {
    return copyPeer(copy, nullptr, true);
}
SUNSTONE_CUDART cudaError_t cudaMemcpy3DPeerAsync(const struct cudaMemcpy3DPeerParms* copy,
                                                  cudaStream_t stream) {
    return copyPeer(copy, stream, false);
}
