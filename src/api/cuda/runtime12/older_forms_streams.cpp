// SPDX-License-Identifier: Apache-2.0
// Like older_forms.cpp, for functions on a stream. Compiled twice, see runtime.h.
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

extern "C" {
cudaError_t cudaMemPrefetchAsync_v2(const void* address, size_t bytes, cudaMemLocation location,
                                    unsigned int flags, cudaStream_t stream);
cudaError_t cudaStreamGetCaptureInfo_v3(cudaStream_t stream, cudaStreamCaptureStatus* status,
                                        unsigned long long* id, cudaGraph_t* graph,
                                        const cudaGraphNode_t** dependencies,
                                        const cudaGraphEdgeData** edges, size_t* count);
cudaError_t cudaStreamUpdateCaptureDependencies_v2(cudaStream_t stream,
                                                   cudaGraphNode_t* dependencies,
                                                   const cudaGraphEdgeData* edges, size_t count,
                                                   unsigned int flags);
}

#ifdef __CUDA_API_PER_THREAD_DEFAULT_STREAM
#define SUNSTONE_OLDER(name, params)                                                               \
    SUNSTONE_CUDART cudaError_t older_##name##_ptsz params asm(#name "_ptsz");                     \
    SUNSTONE_CUDART cudaError_t older_##name##_ptsz params
#else
#define SUNSTONE_OLDER(name, params)                                                               \
    SUNSTONE_CUDART cudaError_t older_##name params asm(#name);                                    \
    SUNSTONE_CUDART cudaError_t older_##name params
#endif

SUNSTONE_OLDER(cudaMemPrefetchAsync,
               (const void* address, size_t bytes, int device, cudaStream_t stream)) {
    const cudaMemLocation location = {
        device == cudaCpuDeviceId ? cudaMemLocationTypeHost : cudaMemLocationTypeDevice, device};
    return cudaMemPrefetchAsync_v2(address, bytes, location, 0, stream);
}
SUNSTONE_OLDER(cudaStreamGetCaptureInfo,
               (cudaStream_t stream, cudaStreamCaptureStatus* status, unsigned long long* id)) {
    return cudaStreamGetCaptureInfo_v3(stream, status, id, nullptr, nullptr, nullptr, nullptr);
}
SUNSTONE_CUDART cudaError_t cudaStreamGetCaptureInfo_v2(cudaStream_t stream,
                                                        cudaStreamCaptureStatus* status,
                                                        unsigned long long* id, cudaGraph_t* graph,
                                                        const cudaGraphNode_t** dependencies,
                                                        size_t* count) {
    return cudaStreamGetCaptureInfo_v3(stream, status, id, graph, dependencies, nullptr, count);
}
SUNSTONE_OLDER(cudaStreamUpdateCaptureDependencies,
               (cudaStream_t stream, cudaGraphNode_t* dependencies, size_t count,
                unsigned int flags)) {
    return cudaStreamUpdateCaptureDependencies_v2(stream, dependencies, nullptr, count, flags);
}
