// SPDX-License-Identifier: Apache-2.0
// The mathematical headers together, with their names outside namespace optix. Source: OptiX API
// reference 6.0, sections 8.8, 8.29 to 8.38.
#ifndef SUNSTONE_OPTIX6_MATH_H
#define SUNSTONE_OPTIX6_MATH_H

#include "optixu/optixu_aabb.h"
#include "optixu/optixu_math.h"
#include "optixu/optixu_matrix.h"
#include "optixu/optixu_quaternion.h"

#endif
