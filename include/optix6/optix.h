// SPDX-License-Identifier: Apache-2.0
// The classic API: its device half for device compilers, its host half for all others. Source: OptiX
// 6.0 API reference, section 8.8.
#ifndef SUNSTONE_OPTIX6_H
#define SUNSTONE_OPTIX6_H

/* major * 10000 + minor * 100 + micro */
#define OPTIX_VERSION 60000

#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#include "optix_device.h"
#else
#include "optix_host.h"
#endif

#endif
