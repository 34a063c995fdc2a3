// SPDX-License-Identifier: Apache-2.0
// The names of optixu_math_namespace.h outside namespace optix, and uint and ushort where the
// system lacks them. Argument-dependent lookup finds the operators only in the vector types' own
// namespace, the global one. Source: OptiX API reference 6.0, section 8.31.
#ifndef SUNSTONE_OPTIXU_MATH_H
#define SUNSTONE_OPTIXU_MATH_H

#include "optixu_math_namespace.h"

#ifndef RT_UINT_USHORT_DEFINED
#define RT_UINT_USHORT_DEFINED
typedef unsigned int uint;
typedef unsigned short ushort;
#endif

using optix::make_Ray;
using optix::Onb;
using optix::Ray;

using optix::make_float2;
using optix::make_float3;
using optix::make_float4;
using optix::make_int2;
using optix::make_int3;
using optix::make_int4;
using optix::make_longlong2;
using optix::make_longlong3;
using optix::make_longlong4;
using optix::make_uint2;
using optix::make_uint3;
using optix::make_uint4;
using optix::make_ulonglong2;
using optix::make_ulonglong3;
using optix::make_ulonglong4;

using optix::operator+;
using optix::operator-;
using optix::operator*;
using optix::operator/;
using optix::operator+=;
using optix::operator-=;
using optix::operator*=;
using optix::operator/=;
using optix::operator==;
using optix::operator!=;

using optix::bilerp;
using optix::cart_to_pol;
using optix::clamp;
using optix::cosine_sample_hemisphere;
using optix::cross;
using optix::dot;
using optix::expf;
using optix::faceforward;
using optix::float_as_int;
using optix::floor;
using optix::fmaxf;
using optix::fminf;
using optix::fresnel_schlick;
using optix::getByIndex;
using optix::int_as_float;
using optix::intersect_triangle;
using optix::intersect_triangle_branchless;
using optix::intersect_triangle_earlyexit;
using optix::length;
using optix::lerp;
using optix::luminance;
using optix::luminanceCIE;
using optix::max;
using optix::min;
using optix::normalize;
using optix::reflect;
using optix::refract;
using optix::setByIndex;
using optix::smoothstep;
using optix::square_to_disk;
using optix::temperature;

#endif
