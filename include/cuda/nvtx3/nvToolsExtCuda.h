// SPDX-License-Identifier: Apache-2.0
// Names for objects of CUDA's driver API, see nvToolsExt.h.
#ifndef SUNSTONE_NVTOOLSEXT_CUDA_H
#define SUNSTONE_NVTOOLSEXT_CUDA_H

#include "nvToolsExt.h"

#include "../cuda.h"

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

SUNSTONE_NVTX_VOID(nvtxNameCuDeviceA, (CUdevice device, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameCuDeviceW, (CUdevice device, const wchar_t* name))
SUNSTONE_NVTX_VOID(nvtxNameCuContextA, (CUcontext context, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameCuContextW, (CUcontext context, const wchar_t* name))
SUNSTONE_NVTX_VOID(nvtxNameCuStreamA, (CUstream stream, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameCuStreamW, (CUstream stream, const wchar_t* name))
SUNSTONE_NVTX_VOID(nvtxNameCuEventA, (CUevent event, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameCuEventW, (CUevent event, const wchar_t* name))

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#if defined(UNICODE)
#define nvtxNameCuDevice nvtxNameCuDeviceW
#define nvtxNameCuContext nvtxNameCuContextW
#define nvtxNameCuStream nvtxNameCuStreamW
#define nvtxNameCuEvent nvtxNameCuEventW
#else
#define nvtxNameCuDevice nvtxNameCuDeviceA
#define nvtxNameCuContext nvtxNameCuContextA
#define nvtxNameCuStream nvtxNameCuStreamA
#define nvtxNameCuEvent nvtxNameCuEventA
#endif

#endif
