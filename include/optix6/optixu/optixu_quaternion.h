// SPDX-License-Identifier: Apache-2.0
// The names of optixu_quaternion_namespace.h and optixu_math_namespace.h outside namespace optix.
// Source: OptiX API reference 6.0, section 8.37.
#ifndef SUNSTONE_OPTIXU_QUATERNION_H
#define SUNSTONE_OPTIXU_QUATERNION_H

#include "optixu_math.h"
#include "optixu_quaternion_namespace.h"

using optix::nlerp;
using optix::Quaternion;

#endif
