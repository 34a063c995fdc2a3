// SPDX-License-Identifier: Apache-2.0
// The runtime API's surface objects.
#ifndef SUNSTONE_SURFACE_TYPES_H
#define SUNSTONE_SURFACE_TYPES_H
#ifndef __SURFACE_TYPES_H__
#define __SURFACE_TYPES_H__ // disables a toolkit's header
#endif

#include "driver_types.h"

typedef unsigned long long cudaSurfaceObject_t;

enum cudaSurfaceBoundaryMode {
    cudaBoundaryModeZero = 0,
    cudaBoundaryModeClamp = 1,
    cudaBoundaryModeTrap = 2,
};
enum cudaSurfaceFormatMode {
    cudaFormatModeForced = 0,
    cudaFormatModeAuto = 1,
};

#endif
