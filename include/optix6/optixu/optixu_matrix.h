// SPDX-License-Identifier: Apache-2.0
// The names of optixu_matrix_namespace.h and optixu_math_namespace.h outside namespace optix.
// Source: OptiX API reference 6.0, section 8.35.
#ifndef SUNSTONE_OPTIXU_MATRIX_H
#define SUNSTONE_OPTIXU_MATRIX_H

#include "optixu_math.h"
#include "optixu_matrix_namespace.h"

using optix::make_matrix3x3;
using optix::Matrix;
using optix::Matrix2x2;
using optix::Matrix2x3;
using optix::Matrix2x4;
using optix::Matrix3x2;
using optix::Matrix3x3;
using optix::Matrix3x4;
using optix::Matrix4x2;
using optix::Matrix4x3;
using optix::Matrix4x4;
using optix::VectorDim;

#endif
