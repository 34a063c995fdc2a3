// SPDX-License-Identifier: Apache-2.0
// The intrinsics of the classic API: undeclared PTX functions that its device functions call. The
// library replaces the calls when it compiles programs. Source: OptiX 6.0 API reference, section
// 8.18.
#ifndef SUNSTONE_OPTIX6_INTERNAL_H
#define SUNSTONE_OPTIX6_INTERNAL_H

#include "optix_datatypes.h"
#include "optix_declarations.h"
#include "optix_defines.h"
#include "optix_sizet.h"

#define _RT_PRINT_ACTIVE()                                                                         \
    if (!optix::rt_print_active())                                                                 \
        return;

#define SUNSTONE_OPTIX_DEVICE static __forceinline__ __device__

namespace optix {

SUNSTONE_OPTIX_DEVICE void* rt_buffer_get(const void* buffer, unsigned int dim,
                                          unsigned int element_size, optix_size_t i0,
                                          optix_size_t i1, optix_size_t i2, optix_size_t i3) {
    void* element;
    asm volatile("call (%0), _rt_buffer_get_64, (%1, %2, %3, %4, %5, %6, %7);"
                 : "=l"(element)
                 : "l"(buffer), "r"(dim), "r"(element_size), "l"(i0), "l"(i1), "l"(i2), "l"(i3));
    return element;
}

SUNSTONE_OPTIX_DEVICE void* rt_buffer_get_id(int id, unsigned int dim, unsigned int element_size,
                                             optix_size_t i0, optix_size_t i1, optix_size_t i2,
                                             optix_size_t i3) {
    void* element;
    asm volatile("call (%0), _rt_buffer_get_id_64, (%1, %2, %3, %4, %5, %6, %7);"
                 : "=l"(element)
                 : "r"(id), "r"(dim), "r"(element_size), "l"(i0), "l"(i1), "l"(i2), "l"(i3));
    return element;
}

SUNSTONE_OPTIX_DEVICE size_t4 rt_buffer_get_size(const void* buffer, unsigned int dim,
                                                 unsigned int element_size) {
    size_t4 size;
    asm volatile("call (%0, %1, %2, %3), _rt_buffer_get_size_64, (%4, %5, %6);"
                 : "=l"(size.x), "=l"(size.y), "=l"(size.z), "=l"(size.w)
                 : "l"(buffer), "r"(dim), "r"(element_size));
    return size;
}

SUNSTONE_OPTIX_DEVICE size_t4 rt_buffer_get_size_id(int id, unsigned int dim,
                                                    unsigned int element_size) {
    size_t4 size;
    asm volatile("call (%0, %1, %2, %3), _rt_buffer_get_id_size_64, (%4, %5, %6);"
                 : "=l"(size.x), "=l"(size.y), "=l"(size.z), "=l"(size.w)
                 : "r"(id), "r"(dim), "r"(element_size));
    return size;
}

// The site's name is for callees that the host lists; here a call works with any callee.
SUNSTONE_OPTIX_DEVICE void* rt_callable_program_from_id(int id, const char* = 0) {
    void* code;
    asm volatile("call (%0), _rt_callable_program_from_id_64, (%1);" : "=l"(code) : "r"(id));
    return code;
}

SUNSTONE_OPTIX_DEVICE void rt_trace(unsigned int group, float3 origin, float3 direction,
                                    unsigned int ray_type, float tmin, float tmax,
                                    RTvisibilitymask mask, RTrayflags flags, void* prd,
                                    unsigned int prd_size) {
    asm volatile("call _rt_trace_mask_flags_64, (%0, %1, %2, %3, %4, %5, %6, %7, %8, %9, %10, %11, "
                 "%12, %13);"
                 :
                 : "r"(group), "f"(origin.x), "f"(origin.y), "f"(origin.z), "f"(direction.x),
                   "f"(direction.y), "f"(direction.z), "r"(ray_type), "f"(tmin), "f"(tmax),
                   "r"(mask), "r"((unsigned int)flags), "l"(prd), "r"(prd_size)
                 : "memory");
}

SUNSTONE_OPTIX_DEVICE void rt_trace_with_time(unsigned int group, float3 origin, float3 direction,
                                              unsigned int ray_type, float tmin, float tmax,
                                              float time, RTvisibilitymask mask, RTrayflags flags,
                                              void* prd, unsigned int prd_size) {
    asm volatile("call _rt_trace_with_time_mask_flags_64, (%0, %1, %2, %3, %4, %5, %6, %7, %8, %9, "
                 "%10, %11, %12, %13, %14);"
                 :
                 : "r"(group), "f"(origin.x), "f"(origin.y), "f"(origin.z), "f"(direction.x),
                   "f"(direction.y), "f"(direction.z), "r"(ray_type), "f"(tmin), "f"(tmax),
                   "f"(time), "r"(mask), "r"((unsigned int)flags), "l"(prd), "r"(prd_size)
                 : "memory");
}

// The compiler must treat attributes and the distance of the hit as memory.
SUNSTONE_OPTIX_DEVICE bool rt_potential_intersection(float t) {
    int result;
    asm volatile("call (%0), _rt_potential_intersection, (%1);" : "=r"(result) : "f"(t) : "memory");
    return result != 0;
}
SUNSTONE_OPTIX_DEVICE bool rt_report_intersection(unsigned int matlIndex) {
    int result;
    asm volatile("call (%0), _rt_report_intersection, (%1);"
                 : "=r"(result)
                 : "r"(matlIndex)
                 : "memory");
    return result != 0;
}
SUNSTONE_OPTIX_DEVICE void rt_ignore_intersection() {
    asm volatile("call _rt_ignore_intersection, ();" : : : "memory");
}
SUNSTONE_OPTIX_DEVICE void rt_terminate_ray() {
    asm volatile("call _rt_terminate_ray, ();" : : : "memory");
}
SUNSTONE_OPTIX_DEVICE void rt_intersect_child(unsigned int index) {
    asm volatile("call _rt_intersect_child, (%0);" : : "r"(index) : "memory");
}

SUNSTONE_OPTIX_DEVICE float4 rt_transform_tuple(unsigned int kind, float x, float y, float z,
                                                float w) {
    float4 result;
    asm volatile("call (%0, %1, %2, %3), _rt_transform_tuple, (%4, %5, %6, %7, %8);"
                 : "=f"(result.x), "=f"(result.y), "=f"(result.z), "=f"(result.w)
                 : "r"(kind), "f"(x), "f"(y), "f"(z), "f"(w));
    return result;
}
SUNSTONE_OPTIX_DEVICE float3 rt_first_three(float4 v) {
    float3 result;
    result.x = v.x;
    result.y = v.y;
    result.z = v.z;
    return result;
}
SUNSTONE_OPTIX_DEVICE float3 rt_transform_point(RTtransformkind kind, const float3& p) {
    return rt_first_three(rt_transform_tuple(kind, p.x, p.y, p.z, 1.0f));
}
SUNSTONE_OPTIX_DEVICE float3 rt_transform_vector(RTtransformkind kind, const float3& v) {
    return rt_first_three(rt_transform_tuple(kind, v.x, v.y, v.z, 0.0f));
}
SUNSTONE_OPTIX_DEVICE float3 rt_transform_normal(RTtransformkind kind, const float3& n) {
    return rt_first_three(rt_transform_tuple(
        (unsigned int)kind | (unsigned int)RT_INTERNAL_INVERSE_TRANSPOSE, n.x, n.y, n.z, 0.0f));
}
SUNSTONE_OPTIX_DEVICE void rt_get_transform(RTtransformkind kind, float matrix[16]) {
    asm volatile("call (%0, %1, %2, %3, %4, %5, %6, %7, %8, %9, %10, %11, %12, %13, %14, %15), "
                 "_rt_get_transform, (%16);"
                 : "=f"(matrix[0]), "=f"(matrix[1]), "=f"(matrix[2]), "=f"(matrix[3]),
                   "=f"(matrix[4]), "=f"(matrix[5]), "=f"(matrix[6]), "=f"(matrix[7]),
                   "=f"(matrix[8]), "=f"(matrix[9]), "=f"(matrix[10]), "=f"(matrix[11]),
                   "=f"(matrix[12]), "=f"(matrix[13]), "=f"(matrix[14]), "=f"(matrix[15])
                 : "r"((unsigned int)kind));
}

SUNSTONE_OPTIX_DEVICE unsigned int rt_get_primitive_index() {
    unsigned int index;
    asm volatile("call (%0), _rt_get_primitive_index, ();" : "=r"(index));
    return index;
}
SUNSTONE_OPTIX_DEVICE bool rt_is_triangle_hit() {
    unsigned int result;
    asm volatile("call (%0), _rt_is_triangle_hit, ();" : "=r"(result));
    return result != 0;
}
SUNSTONE_OPTIX_DEVICE bool rt_is_triangle_hit_back_face() {
    unsigned int result;
    asm volatile("call (%0), _rt_is_triangle_hit_back_face, ();" : "=r"(result));
    return result != 0;
}
SUNSTONE_OPTIX_DEVICE bool rt_is_triangle_hit_front_face() {
    unsigned int result;
    asm volatile("call (%0), _rt_is_triangle_hit_front_face, ();" : "=r"(result));
    return result != 0;
}
SUNSTONE_OPTIX_DEVICE float2 rt_get_triangle_barycentrics() {
    float2 result;
    asm volatile("call (%0, %1), _rt_get_triangle_barycentrics, ();"
                 : "=f"(result.x), "=f"(result.y));
    return result;
}

SUNSTONE_OPTIX_DEVICE void rt_throw(unsigned int code) {
    asm volatile("call _rt_throw, (%0);" : : "r"(code) : "memory");
}
SUNSTONE_OPTIX_DEVICE unsigned int rt_get_exception_code() {
    unsigned int code;
    asm volatile("call (%0), _rt_get_exception_code, ();" : "=r"(code));
    return code;
}
SUNSTONE_OPTIX_DEVICE int rt_print_active() {
    int active;
    asm volatile("call (%0), _rt_print_active, ();" : "=r"(active));
    return active;
}

// The handle for texture instructions, from a sampler's id.
SUNSTONE_OPTIX_DEVICE unsigned long long rt_texture_handle(int id) {
    unsigned long long handle;
    asm volatile("call (%0), _rt_texture_handle, (%1);" : "=l"(handle) : "r"(id));
    return handle;
}

} // namespace optix

#undef SUNSTONE_OPTIX_DEVICE

#endif
