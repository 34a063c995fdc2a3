// SPDX-License-Identifier: Apache-2.0
// The stream operators of optixu_math_stream_namespace.h outside namespace optix, where the vector
// types are, so that every namespace finds them. Source: OptiX API reference 6.0, section 8.33.
#ifndef SUNSTONE_OPTIXU_MATH_STREAM_H
#define SUNSTONE_OPTIXU_MATH_STREAM_H

#include "optixu_aabb.h"
#include "optixu_math.h"
#include "optixu_math_stream_namespace.h"
#include "optixu_matrix.h"

using optix::operator<<;
using optix::operator>>;

#endif
