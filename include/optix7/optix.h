// SPDX-License-Identifier: Apache-2.0
// OptiX 7.4 API: the one header an application or a device program includes. Device compilers
// (nvcc, NVRTC, clang in CUDA mode) get the device functions, all others the host functions; a .cu
// file that also calls the host API additionally includes optix_host.h or optix_stubs.h. Source:
// OptiX API reference 7.4, section 6.1.
#ifndef SUNSTONE_OPTIX7_OPTIX_H
#define SUNSTONE_OPTIX7_OPTIX_H

/* major * 10000 + minor * 100 + micro. Build scripts read the next line: keep it literal. */
#define OPTIX_VERSION 70400

#if defined(__CUDACC__) || defined(__CUDA__)
#include "optix_device.h"
#else
#include "optix_host.h"
#endif

#endif
