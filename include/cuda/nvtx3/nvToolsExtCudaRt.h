// SPDX-License-Identifier: Apache-2.0
// Names for objects of CUDA's runtime API, see nvToolsExt.h.
#ifndef SUNSTONE_NVTOOLSEXT_CUDART_H
#define SUNSTONE_NVTOOLSEXT_CUDART_H

#include "nvToolsExt.h"

#include "../cuda_runtime_api.h"

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

SUNSTONE_NVTX_VOID(nvtxNameCudaDeviceA, (int device, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameCudaDeviceW, (int device, const wchar_t* name))
SUNSTONE_NVTX_VOID(nvtxNameCudaStreamA, (cudaStream_t stream, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameCudaStreamW, (cudaStream_t stream, const wchar_t* name))
SUNSTONE_NVTX_VOID(nvtxNameCudaEventA, (cudaEvent_t event, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameCudaEventW, (cudaEvent_t event, const wchar_t* name))

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#if defined(UNICODE)
#define nvtxNameCudaDevice nvtxNameCudaDeviceW
#define nvtxNameCudaStream nvtxNameCudaStreamW
#define nvtxNameCudaEvent nvtxNameCudaEventW
#else
#define nvtxNameCudaDevice nvtxNameCudaDeviceA
#define nvtxNameCudaStream nvtxNameCudaStreamA
#define nvtxNameCudaEvent nvtxNameCudaEventA
#endif

#endif
