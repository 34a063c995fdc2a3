// SPDX-License-Identifier: Apache-2.0
// The names of optixu_aabb_namespace.h and optixu_math_namespace.h outside namespace optix.
// Source: OptiX API reference 6.0, section 8.29.
#ifndef SUNSTONE_OPTIXU_AABB_H
#define SUNSTONE_OPTIXU_AABB_H

#include "optixu_aabb_namespace.h"
#include "optixu_math.h"

using optix::Aabb;

#endif
