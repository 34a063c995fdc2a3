// SPDX-License-Identifier: Apache-2.0
// For files that host and device compilers share: the API, its mathematics, and CUDA's vector types
// in namespace optix. Source: OptiX 6.0 API reference, section 8.26.
#ifndef SUNSTONE_OPTIX6_WORLD_H
#define SUNSTONE_OPTIX6_WORLD_H

#include "optix.h"
#include "optix_math.h"
#if !defined(__CUDACC__) && !defined(__CUDACC_RTC__) && __has_include("optixu/optixpp_namespace.h")
#include "optixu/optixpp_namespace.h"
#endif

#endif
