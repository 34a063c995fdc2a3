// SPDX-License-Identifier: Apache-2.0
// OptiX 7.6 API: the one header an application or a device program includes; ../optix7/optix.h
// describes its contents. This folder is an include root of its own, and its headers are those of
// ../optix7 with the additions of OptiX 7.5 and 7.6. Source: OptiX API reference 7.6.
#ifndef SUNSTONE_OPTIX76_OPTIX_H
#define SUNSTONE_OPTIX76_OPTIX_H

#include "internal/optix_76_api.h"

/* major * 10000 + minor * 100 + micro. Build scripts read the next line: keep it literal. */
#define OPTIX_VERSION 70600

#if defined(__CUDACC__) || defined(__CUDA__)
#include "optix_device.h"
#else
#include "optix_host.h"
#endif

#endif
