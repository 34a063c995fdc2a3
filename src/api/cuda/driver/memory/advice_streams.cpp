// SPDX-License-Identifier: Apache-2.0
// Prefetches, in stream order. Compiled twice, see shell.h.
#include "api/cuda/driver/memory/advice.h"

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

CUresult prefetch(CUdeviceptr address, size_t bytes, const CUmemLocation& location, unsigned flags,
                  CUstream stream) {
    return guarded("cuMemPrefetchAsync", {Needs::kQueue, stream}, [&] {
        require(flags == 0, "flags must be 0");
        requireShared(address, bytes);
        requireLocation(location);
        const cpu::StreamPtr target = resolveStream(stream);
        if (cpu::streams().isCapturing(target))
            throw cpu::CaptureError(cpu::CaptureError::kUnsupported,
                                    "prefetches cannot be captured");
        cpu::streams().submit(target, [=] {
            advise(address, bytes, [&](Advice& known) { known.lastPrefetch = location; });
        });
    });
}

} // namespace

SUNSTONE_EXPORT CUresult cuMemPrefetchAsync(CUdeviceptr address, size_t bytes,
                                            CUmemLocation location, unsigned int flags,
                                            CUstream stream) {
    return prefetch(address, bytes, location, flags, stream);
}

// The form of CUDA 12 and earlier.
#undef cuMemPrefetchAsync
#ifdef CUDA_API_PER_THREAD_DEFAULT_STREAM
#define SUNSTONE_FIRST_FORM "cuMemPrefetchAsync_ptsz"
#define sunstoneMemPrefetchAsync1 sunstoneMemPrefetchAsync1_ptsz
#else
#define SUNSTONE_FIRST_FORM "cuMemPrefetchAsync"
#endif
SUNSTONE_EXPORT CUresult sunstoneMemPrefetchAsync1(CUdeviceptr address, size_t bytes,
                                                   CUdevice device,
                                                   CUstream stream) asm(SUNSTONE_FIRST_FORM);
SUNSTONE_EXPORT CUresult sunstoneMemPrefetchAsync1(CUdeviceptr address, size_t bytes,
                                                   CUdevice device, CUstream stream) {
    return prefetch(address, bytes, locationOf(device), 0, stream);
}
