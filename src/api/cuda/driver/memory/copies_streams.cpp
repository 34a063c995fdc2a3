// SPDX-License-Identifier: Apache-2.0
// Copies and sets, and allocation in stream order. Compiled twice, see shell.h. All of them queue
// work; the synchronous forms wait for it. Ranges are checked before work is queued.
#include "api/cuda/driver/device_faults.h"
#include "api/cuda/driver/graphs/graphs.h"
#include "api/cuda/driver/memory/copies.h"
#include "api/cuda/driver/memory/pools.h"

using namespace sunstone;
using namespace sunstone::api::cuda;
using cpu::MemoryKind;

namespace {

// Queues or captures work. `wait`: returns after it is done.
template <class Job>
void queue(const Job& job, CUstream stream, bool wait, cpu::WorkInfo info) {
    cpu::StreamPtr target = resolveStream(stream);
    if (job.empty())
        return;
    job.check();
    const auto run = [job, home = std::weak_ptr(cpu::contexts().shareCurrent())] {
        runInContext(home, [&] { job.run(); });
    };
    if (wait && cpu::streams().idle(target)) {
        cpu::streams().throwError(target);
        run(); // nothing to wait for, so no worker thread is needed
        return;
    }
    cpu::streams().submit(target, run, {}, std::move(info));
    if (wait)
        cpu::streams().synchronize(target);
}

struct CopyJob : Copy {
    bool empty() const { return shape.empty(); }
};

void queueCopy(const Copy& copy, CUstream stream, bool wait, const CUDA_MEMCPY3D& description) {
    // Copies of pageable memory return when the application may access it again.
    if (!wait && !copy.shape.empty() && copy.touchesPageable())
        wait = !cpu::streams().isCapturing(resolveStream(stream));
    queue(CopyJob{copy}, stream, wait,
          {cpu::WorkKind::kCopy, std::make_shared<CUDA_MEMCPY3D>(description)});
}

CUresult linear(const char* function, const void* dst, const void* src, size_t bytes,
                CUstream stream, bool wait, bool dstDevice, bool srcDevice) {
    return guarded(function, {needsToQueue(wait), stream}, [&] {
        const Copy copy = linearCopy(dst, src, bytes, dstDevice, srcDevice);
        queueCopy(copy, stream, wait, describe(copy));
    });
}

const void* pointerOf(CUdeviceptr address) {
    return reinterpret_cast<const void*>(address);
}

CUresult copy3D(const char* function, const CUDA_MEMCPY3D* copy, CUstream stream, bool wait) {
    return guarded(function, {needsToQueue(wait), stream}, [&] {
        require(copy, "copy is null");
        queueCopy(copyOf(*copy), stream, wait, *copy);
    });
}

CUresult copy2D(const char* function, const CUDA_MEMCPY2D* copy, CUstream stream, bool wait) {
    const CUDA_MEMCPY3D wide = copy ? widen(*copy) : CUDA_MEMCPY3D{};
    return copy3D(function, copy ? &wide : nullptr, stream, wait);
}

template <class T>
CUresult set(const char* function, CUdeviceptr dst, size_t pitch, T value, size_t width,
             size_t height, CUstream stream, bool wait) {
    return guarded(function, {needsToQueue(wait), stream}, [&] {
        auto details = std::make_shared<CUDA_MEMSET_NODE_PARAMS>();
        *details = {dst, pitch, value, sizeof(T), width, height};
        queue(Set{{static_cast<std::byte*>(const_cast<void*>(pointerOf(dst))), pitch},
                  width,
                  height,
                  sizeof(T),
                  value},
              stream, wait, {cpu::WorkKind::kSet, std::move(details)});
    });
}

// Null stands for the current context.
void requirePeers(CUcontext a, CUcontext b) {
    for (CUcontext context : {a, b})
        if (context)
            requireContext(context);
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
    const CUresult result = guarded("cuMemcpyPeerAsync", {Needs::kQueue, stream},
                                    [&] { requirePeers(dstContext, srcContext); });
    return result ? result
                  : linear("cuMemcpyPeerAsync", pointerOf(dst), pointerOf(src), bytes, stream,
                           false, true, true);
}

namespace {

// One side of a copy with an array.
struct ArrayEnd {
    CUarray array;
    size_t offset;
};
void setSource(CUDA_MEMCPY3D& copy, const ArrayEnd& end) {
    copy.srcMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.srcArray = end.array;
    copy.srcXInBytes = end.offset;
}
void setSource(CUDA_MEMCPY3D& copy, CUdeviceptr address) {
    copy.srcMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.srcDevice = address;
}
void setSource(CUDA_MEMCPY3D& copy, const void* address) {
    copy.srcMemoryType = CU_MEMORYTYPE_HOST;
    copy.srcHost = address;
}
void setTarget(CUDA_MEMCPY3D& copy, const ArrayEnd& end) {
    copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.dstArray = end.array;
    copy.dstXInBytes = end.offset;
}
void setTarget(CUDA_MEMCPY3D& copy, CUdeviceptr address) {
    copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.dstDevice = address;
}
void setTarget(CUDA_MEMCPY3D& copy, void* address) {
    copy.dstMemoryType = CU_MEMORYTYPE_HOST;
    copy.dstHost = address;
}

template <class Target, class Source>
CUresult copyRow(const char* function, const Target& dst, const Source& src, size_t bytes,
                 CUstream stream, bool wait) {
    CUDA_MEMCPY3D copy = {};
    setSource(copy, src);
    setTarget(copy, dst);
    copy.WidthInBytes = bytes;
    copy.Height = copy.Depth = 1;
    return copy3D(function, &copy, stream, wait);
}

} // namespace

SUNSTONE_EXPORT CUresult cuMemcpyDtoA(CUarray dst, size_t dstOffset, CUdeviceptr src,
                                      size_t bytes) {
    return copyRow("cuMemcpyDtoA", ArrayEnd{dst, dstOffset}, src, bytes, nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyAtoD(CUdeviceptr dst, CUarray src, size_t srcOffset,
                                      size_t bytes) {
    return copyRow("cuMemcpyAtoD", dst, ArrayEnd{src, srcOffset}, bytes, nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyHtoA(CUarray dst, size_t dstOffset, const void* src,
                                      size_t bytes) {
    return copyRow("cuMemcpyHtoA", ArrayEnd{dst, dstOffset}, src, bytes, nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyAtoH(void* dst, CUarray src, size_t srcOffset, size_t bytes) {
    return copyRow("cuMemcpyAtoH", dst, ArrayEnd{src, srcOffset}, bytes, nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyAtoA(CUarray dst, size_t dstOffset, CUarray src, size_t srcOffset,
                                      size_t bytes) {
    return copyRow("cuMemcpyAtoA", ArrayEnd{dst, dstOffset}, ArrayEnd{src, srcOffset}, bytes,
                   nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpyHtoAAsync(CUarray dst, size_t dstOffset, const void* src,
                                           size_t bytes, CUstream stream) {
    return copyRow("cuMemcpyHtoAAsync", ArrayEnd{dst, dstOffset}, src, bytes, stream, false);
}
SUNSTONE_EXPORT CUresult cuMemcpyAtoHAsync(void* dst, CUarray src, size_t srcOffset, size_t bytes,
                                           CUstream stream) {
    return copyRow("cuMemcpyAtoHAsync", dst, ArrayEnd{src, srcOffset}, bytes, stream, false);
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

namespace {

// There is one device, so copies between contexts are ordinary copies.
CUresult copyPeer(const char* function, const CUDA_MEMCPY3D_PEER* copy, CUstream stream,
                  bool wait) {
    if (!copy)
        return copy3D(function, nullptr, stream, wait);
    const CUresult result = guarded(function, {needsToQueue(wait), stream},
                                    [&] { requirePeers(copy->dstContext, copy->srcContext); });
    if (result)
        return result;
    const CUDA_MEMCPY3D_PEER& c = *copy;
    CUDA_MEMCPY3D plain = {};
    plain.srcXInBytes = c.srcXInBytes;
    plain.srcY = c.srcY;
    plain.srcZ = c.srcZ;
    plain.srcLOD = c.srcLOD;
    plain.srcMemoryType = c.srcMemoryType;
    plain.srcHost = c.srcHost;
    plain.srcDevice = c.srcDevice;
    plain.srcArray = c.srcArray;
    plain.srcPitch = c.srcPitch;
    plain.srcHeight = c.srcHeight;
    plain.dstXInBytes = c.dstXInBytes;
    plain.dstY = c.dstY;
    plain.dstZ = c.dstZ;
    plain.dstLOD = c.dstLOD;
    plain.dstMemoryType = c.dstMemoryType;
    plain.dstHost = c.dstHost;
    plain.dstDevice = c.dstDevice;
    plain.dstArray = c.dstArray;
    plain.dstPitch = c.dstPitch;
    plain.dstHeight = c.dstHeight;
    plain.WidthInBytes = c.WidthInBytes;
    plain.Height = c.Height;
    plain.Depth = c.Depth;
    return copy3D(function, &plain, stream, wait);
}

} // namespace

SUNSTONE_EXPORT CUresult cuMemcpy3DPeer(const CUDA_MEMCPY3D_PEER* copy) {
    return copyPeer("cuMemcpy3DPeer", copy, nullptr, true);
}
SUNSTONE_EXPORT CUresult cuMemcpy3DPeerAsync(const CUDA_MEMCPY3D_PEER* copy, CUstream stream) {
    return copyPeer("cuMemcpy3DPeerAsync", copy, stream, false);
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

namespace {

CUresult allocateAsync(const char* function, CUdeviceptr* address, size_t bytes, CUmemoryPool pool,
                       CUstream stream) {
    return guardedGraph(function, {Needs::kQueue, stream}, [&] {
        require(address, "address is null");
        cpu::StreamPtr target = resolveStream(stream);
        // Memory may exist earlier than stream order requires.
        *address = reinterpret_cast<CUdeviceptr>(allocateFromPool(pool, bytes));
        if (const cpu::CapturedMark state = cpu::streams().captureState(target); state.capture) {
            ownByGraph(*state.graph, *address);
            cpu::streams().submit(target, nullptr, {}, {cpu::WorkKind::kAllocate, nullptr});
        }
    });
}

} // namespace

SUNSTONE_EXPORT CUresult cuMemAllocAsync(CUdeviceptr* address, size_t bytes, CUstream stream) {
    return allocateAsync("cuMemAllocAsync", address, bytes, nullptr, stream);
}
SUNSTONE_EXPORT CUresult cuMemAllocFromPoolAsync(CUdeviceptr* address, size_t bytes,
                                                 CUmemoryPool pool, CUstream stream) {
    if (!pool)
        return guarded("cuMemAllocFromPoolAsync", {Needs::kQueue, stream},
                       [] { require(false, "pool is null"); });
    return allocateAsync("cuMemAllocFromPoolAsync", address, bytes, pool, stream);
}
SUNSTONE_EXPORT CUresult cuMemFreeAsync(CUdeviceptr address, CUstream stream) {
    return guarded("cuMemFreeAsync", {Needs::kQueue, stream}, [&] {
        cpu::StreamPtr target = resolveStream(stream);
        auto found = cpu::memory().find(pointerOf(address));
        require(found && found->base == address && found->kind == MemoryKind::kDevice,
                "not the start of a live device allocation");
        std::function<void()> release; // memory of a graph is freed with the graph
        if (!isOwnedByGraph(address))
            release = [address, id = found->id] {
                if (!cpu::memory().release(pointerOf(address), {MemoryKind::kDevice}, id))
                    refuse(CUDA_ERROR_INVALID_VALUE, pointerOf(address), " was freed twice");
                forgetPoolMemory(pointerOf(address), id);
            };
        cpu::streams().submit(target, std::move(release), {}, {cpu::WorkKind::kFree, nullptr});
    });
}
