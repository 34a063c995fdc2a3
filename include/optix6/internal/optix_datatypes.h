// SPDX-License-Identifier: Apache-2.0
// The ray of the classic API, for host and device. Source: OptiX API reference 6.0, sections 7.40,
// 8.11.
#ifndef SUNSTONE_OPTIX6_DATATYPES_H
#define SUNSTONE_OPTIX6_DATATYPES_H

#ifndef __CUDACC_RTC__
#include <vector_types.h>
#endif

#include "optix_declarations.h"

/* The tmax of a ray without an end. */
#define RT_DEFAULT_MAX 1.e27f

#ifdef __cplusplus
namespace optix {
#endif

/* A ray: the points origin + t * direction with tmin < t < tmax. ray_type selects the programs of a
   material and the miss program. In C it has no namespace and no constructors. */
typedef struct Ray {
#ifdef __cplusplus
    RT_HOSTDEVICE Ray() {}
    RT_HOSTDEVICE Ray(float3 origin_, float3 direction_, unsigned int ray_type_, float tmin_,
                      float tmax_ = RT_DEFAULT_MAX)
        : origin(origin_), direction(direction_), ray_type(ray_type_), tmin(tmin_), tmax(tmax_) {}
#endif

    float3 origin;
    float3 direction;
    unsigned int ray_type;
    float tmin;
    float tmax;
} Ray;

static __inline__ RT_HOSTDEVICE Ray make_Ray(float3 origin, float3 direction, unsigned int ray_type,
                                             float tmin, float tmax) {
    Ray ray;
    ray.origin = origin;
    ray.direction = direction;
    ray.ray_type = ray_type;
    ray.tmin = tmin;
    ray.tmax = tmax;
    return ray;
}

#ifdef __cplusplus
} // namespace optix
#endif

#endif
