// SPDX-License-Identifier: Apache-2.0
// Streams and events: create, destroy, query.
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

SUNSTONE_CUDART cudaError_t cudaStreamCreateWithPriority(cudaStream_t* stream, unsigned int flags,
                                                         int priority) {
    return call(
        [&](const Driver& d) { return d.cuStreamCreateWithPriority(stream, flags, priority); });
}
SUNSTONE_CUDART cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned int flags) {
    return cudaStreamCreateWithPriority(stream, flags, 0);
}
SUNSTONE_CUDART cudaError_t cudaStreamCreate(cudaStream_t* stream) {
    return cudaStreamCreateWithPriority(stream, 0, 0);
}
SUNSTONE_CUDART cudaError_t cudaStreamDestroy(cudaStream_t stream) {
    return call([&](const Driver& d) { return d.cuStreamDestroy(stream); });
}

SUNSTONE_CUDART cudaError_t cudaEventCreateWithFlags(cudaEvent_t* event, unsigned int flags) {
    return call([&](const Driver& d) { return d.cuEventCreate(event, flags); });
}
SUNSTONE_CUDART cudaError_t cudaEventCreate(cudaEvent_t* event) {
    return cudaEventCreateWithFlags(event, 0);
}
SUNSTONE_CUDART cudaError_t cudaEventDestroy(cudaEvent_t event) {
    return call([&](const Driver& d) { return d.cuEventDestroy(event); });
}
SUNSTONE_CUDART cudaError_t cudaEventQuery(cudaEvent_t event) {
    return call([&](const Driver& d) { return d.cuEventQuery(event); });
}
SUNSTONE_CUDART cudaError_t cudaEventSynchronize(cudaEvent_t event) {
    return call([&](const Driver& d) { return d.cuEventSynchronize(event); });
}
SUNSTONE_CUDART cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t start,
                                                 cudaEvent_t end) {
    return call([&](const Driver& d) { return d.cuEventElapsedTime(milliseconds, start, end); });
}
