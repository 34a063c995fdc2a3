// SPDX-License-Identifier: Apache-2.0
// Bodies of the device functions declared in optix_7_device.h. Source: OptiX API reference 7.4,
// section 6.3.
//
// An intrinsic is an undeclared PTX function that only the library's compiler knows; operand order
// and types are binary interface (listed in tests/headers/optix7_intrinsics.tsv). An asm is
// volatile if it has a side effect, or if its result may change within one program; the compiler
// may merge or move the others. Calls that run other programs clobber memory, because payload words
// may hold addresses that those programs use.
#if !defined(SUNSTONE_OPTIX7_OPTIX_7_DEVICE_H)
#include "optix_7_device.h" /* included by itself: comes back here after the declarations */
#elif !defined(SUNSTONE_OPTIX7_OPTIX_7_DEVICE_IMPL_H)
#define SUNSTONE_OPTIX7_OPTIX_7_DEVICE_IMPL_H

/* Functions without arguments that return one value of a register type. */
#define OPTIX_IMPL_GETTER(type, constraint, name, intrinsic)                                       \
    static __forceinline__ __device__ type name() {                                                \
        type value;                                                                                \
        asm("call (%0), " intrinsic ", ();" : constraint(value) :);                                \
        return value;                                                                              \
    }

/* The same with the handle of a traversable as argument. */
#define OPTIX_IMPL_FROM_HANDLE(type, constraint, name, intrinsic)                                  \
    static __forceinline__ __device__ type name(OptixTraversableHandle handle) {                   \
        type value;                                                                                \
        asm("call (%0), " intrinsic ", (%1);" : constraint(value) : "l"(handle) :);                \
        return value;                                                                              \
    }

/* Three-component vectors, one intrinsic for each component. */
#define OPTIX_IMPL_VECTOR(type, component, constraint, name, intrinsic)                            \
    static __forceinline__ __device__ type name() {                                                \
        component x, y, z;                                                                         \
        asm("call (%0), " intrinsic "_x, ();" : constraint(x) :);                                  \
        asm("call (%0), " intrinsic "_y, ();" : constraint(y) :);                                  \
        asm("call (%0), " intrinsic "_z, ();" : constraint(z) :);                                  \
        return make_##type(x, y, z);                                                               \
    }

namespace optix_impl {

static __forceinline__ __device__ unsigned int optixFloatBits(float value) {
    unsigned int bits;
    asm("mov.b32 %0, %1;" : "=r"(bits) : "f"(value));
    return bits;
}

static __forceinline__ __device__ float optixBitsFloat(unsigned int bits) {
    float value;
    asm("mov.b32 %0, %1;" : "=f"(value) : "r"(bits));
    return value;
}

/** Whether all types are unsigned int, as payload words must be. */
template <typename... T>
struct OptixAllWords {
    static const bool value = true;
};
template <typename First, typename... Rest>
struct OptixAllWords<First, Rest...> {
    static const bool value = false;
};
template <typename... Rest>
struct OptixAllWords<unsigned int, Rest...> {
    static const bool value = OptixAllWords<Rest...>::value;
};

/** The single intrinsic behind all forms of optixTrace. It always takes and returns 32 payload
    words, of which the first `count` are used. */
static __forceinline__ __device__ void
optixTraceWords(unsigned int type, OptixTraversableHandle handle, float3 origin, float3 direction,
                float tmin, float tmax, float time, OptixVisibilityMask mask, unsigned int flags,
                unsigned int offset, unsigned int stride, unsigned int miss, unsigned int count,
                unsigned int (&p)[32]) {
    asm volatile(
        "call ("
        "%0, %1, %2, %3, %4, %5, %6, %7, %8, %9, %10, %11, %12, %13, %14, %15, "
        "%16, %17, %18, %19, %20, %21, %22, %23, %24, %25, %26, %27, %28, %29, %30, %31"
        "), _optix_trace_typed_32, ("
        "%32, %33, %34, %35, %36, %37, %38, %39, %40, %41, %42, %43, %44, %45, %46, %47, "
        "%48, %49, %50, %51, %52, %53, %54, %55, %56, %57, %58, %59, %60, %61, %62, %63, "
        "%64, %65, %66, %67, %68, %69, %70, %71, %72, %73, %74, %75, %76, %77, %78, %79, "
        "%80"
        ");"
        : "=r"(p[0]), "=r"(p[1]), "=r"(p[2]), "=r"(p[3]), "=r"(p[4]), "=r"(p[5]), "=r"(p[6]),
          "=r"(p[7]), "=r"(p[8]), "=r"(p[9]), "=r"(p[10]), "=r"(p[11]), "=r"(p[12]), "=r"(p[13]),
          "=r"(p[14]), "=r"(p[15]), "=r"(p[16]), "=r"(p[17]), "=r"(p[18]), "=r"(p[19]), "=r"(p[20]),
          "=r"(p[21]), "=r"(p[22]), "=r"(p[23]), "=r"(p[24]), "=r"(p[25]), "=r"(p[26]), "=r"(p[27]),
          "=r"(p[28]), "=r"(p[29]), "=r"(p[30]), "=r"(p[31])
        : "r"(type), "l"(handle), "f"(origin.x), "f"(origin.y), "f"(origin.z), "f"(direction.x),
          "f"(direction.y), "f"(direction.z), "f"(tmin), "f"(tmax), "f"(time), "r"(mask),
          "r"(flags), "r"(offset), "r"(stride), "r"(miss), "r"(count), "r"(p[0]), "r"(p[1]),
          "r"(p[2]), "r"(p[3]), "r"(p[4]), "r"(p[5]), "r"(p[6]), "r"(p[7]), "r"(p[8]), "r"(p[9]),
          "r"(p[10]), "r"(p[11]), "r"(p[12]), "r"(p[13]), "r"(p[14]), "r"(p[15]), "r"(p[16]),
          "r"(p[17]), "r"(p[18]), "r"(p[19]), "r"(p[20]), "r"(p[21]), "r"(p[22]), "r"(p[23]),
          "r"(p[24]), "r"(p[25]), "r"(p[26]), "r"(p[27]), "r"(p[28]), "r"(p[29]), "r"(p[30]),
          "r"(p[31])
        : "memory");
}

} // namespace optix_impl

/* ---- Rays ---- */

/* The body of optixTrace. A macro, so that the default payload type is a literal beside the call:
   without optimisation a compiler passes arguments through memory. */
#define OPTIX_IMPL_TRACE(TYPE)                                                                     \
    static_assert(sizeof...(Payload) <= OPTIX_COMPILE_DEFAULT_MAX_PAYLOAD_VALUE_COUNT,             \
                  "optixTrace takes at most 32 payload words");                                    \
    static_assert(optix_impl::OptixAllWords<Payload...>::value,                                    \
                  "payload words are variables of type unsigned int");                             \
    unsigned int words[32] = {payload...};                                                         \
    optix_impl::optixTraceWords(TYPE, handle, rayOrigin, rayDirection, tmin, tmax, rayTime,        \
                                visibilityMask, rayFlags, SBToffset, SBTstride, missSBTIndex,      \
                                (unsigned int)sizeof...(Payload), words);                          \
    unsigned int i = 0;                                                                            \
    const int written[] = {0, (payload = words[i++], 0)...};                                       \
    (void)i;                                                                                       \
    (void)written

template <typename... Payload>
static __forceinline__ __device__ void
optixTrace(OptixPayloadTypeID type, OptixTraversableHandle handle, float3 rayOrigin,
           float3 rayDirection, float tmin, float tmax, float rayTime,
           OptixVisibilityMask visibilityMask, unsigned int rayFlags, unsigned int SBToffset,
           unsigned int SBTstride, unsigned int missSBTIndex, Payload&... payload) {
    OPTIX_IMPL_TRACE((unsigned int)type);
}

template <typename... Payload>
static __forceinline__ __device__ void
optixTrace(OptixTraversableHandle handle, float3 rayOrigin, float3 rayDirection, float tmin,
           float tmax, float rayTime, OptixVisibilityMask visibilityMask, unsigned int rayFlags,
           unsigned int SBToffset, unsigned int SBTstride, unsigned int missSBTIndex,
           Payload&... payload) {
    OPTIX_IMPL_TRACE((unsigned int)OPTIX_PAYLOAD_TYPE_DEFAULT);
}

#undef OPTIX_IMPL_TRACE

OPTIX_IMPL_VECTOR(float3, float, "=f", optixGetWorldRayOrigin, "_optix_get_world_ray_origin")
OPTIX_IMPL_VECTOR(float3, float, "=f", optixGetWorldRayDirection, "_optix_get_world_ray_direction")
OPTIX_IMPL_VECTOR(float3, float, "=f", optixGetObjectRayOrigin, "_optix_get_object_ray_origin")
OPTIX_IMPL_VECTOR(float3, float, "=f", optixGetObjectRayDirection,
                  "_optix_get_object_ray_direction")
OPTIX_IMPL_GETTER(float, "=f", optixGetRayTmin, "_optix_get_ray_tmin")
OPTIX_IMPL_GETTER(float, "=f", optixGetRayTime, "_optix_get_ray_time")
OPTIX_IMPL_GETTER(unsigned int, "=r", optixGetRayFlags, "_optix_get_ray_flags")
OPTIX_IMPL_GETTER(unsigned int, "=r", optixGetRayVisibilityMask, "_optix_get_ray_visibility_mask")

/* Volatile: an accepted report changes the value. */
static __forceinline__ __device__ float optixGetRayTmax() {
    float value;
    asm volatile("call (%0), _optix_get_ray_tmax, ();" : "=f"(value) :);
    return value;
}

/* ---- Payload ---- */

#define OPTIX_IMPL_PAYLOAD(slot)                                                                   \
    static __forceinline__ __device__ void optixSetPayload_##slot(unsigned int p) {                \
        asm volatile("call _optix_set_payload, (%0, %1);" : : "r"(slot), "r"(p) :);                \
    }                                                                                              \
    static __forceinline__ __device__ unsigned int optixGetPayload_##slot() {                      \
        unsigned int value;                                                                        \
        asm volatile("call (%0), _optix_get_payload, (%1);" : "=r"(value) : "r"(slot) :);          \
        return value;                                                                              \
    }

OPTIX_IMPL_PAYLOAD(0)
OPTIX_IMPL_PAYLOAD(1)
OPTIX_IMPL_PAYLOAD(2)
OPTIX_IMPL_PAYLOAD(3)
OPTIX_IMPL_PAYLOAD(4)
OPTIX_IMPL_PAYLOAD(5)
OPTIX_IMPL_PAYLOAD(6)
OPTIX_IMPL_PAYLOAD(7)
OPTIX_IMPL_PAYLOAD(8)
OPTIX_IMPL_PAYLOAD(9)
OPTIX_IMPL_PAYLOAD(10)
OPTIX_IMPL_PAYLOAD(11)
OPTIX_IMPL_PAYLOAD(12)
OPTIX_IMPL_PAYLOAD(13)
OPTIX_IMPL_PAYLOAD(14)
OPTIX_IMPL_PAYLOAD(15)
OPTIX_IMPL_PAYLOAD(16)
OPTIX_IMPL_PAYLOAD(17)
OPTIX_IMPL_PAYLOAD(18)
OPTIX_IMPL_PAYLOAD(19)
OPTIX_IMPL_PAYLOAD(20)
OPTIX_IMPL_PAYLOAD(21)
OPTIX_IMPL_PAYLOAD(22)
OPTIX_IMPL_PAYLOAD(23)
OPTIX_IMPL_PAYLOAD(24)
OPTIX_IMPL_PAYLOAD(25)
OPTIX_IMPL_PAYLOAD(26)
OPTIX_IMPL_PAYLOAD(27)
OPTIX_IMPL_PAYLOAD(28)
OPTIX_IMPL_PAYLOAD(29)
OPTIX_IMPL_PAYLOAD(30)
OPTIX_IMPL_PAYLOAD(31)
#undef OPTIX_IMPL_PAYLOAD

static __forceinline__ __device__ void optixSetPayloadTypes(unsigned int typeMask) {
    asm volatile("call _optix_set_payload_types, (%0);" : : "r"(typeMask) :);
}

OPTIX_IMPL_GETTER(unsigned int, "=r", optixUndefinedValue, "_optix_undef_value")

/* ---- Hits ---- */

/* PARAMETERS and OPERANDS each start with a comma unless they are empty. */
#define OPTIX_IMPL_REPORT(count, slots, parameters, operands)                                      \
    static __forceinline__ __device__ bool optixReportIntersection(                                \
        float hitT, unsigned int hitKind OPTIX_IMPL_LIST parameters) {                             \
        unsigned int accepted;                                                                     \
        asm volatile("call (%0), _optix_report_intersection_" #count ", (%1, %2" slots ");"        \
                     : "=r"(accepted)                                                              \
                     : "f"(hitT), "r"(hitKind)OPTIX_IMPL_LIST operands                             \
                     : "memory");                                                                  \
        return accepted != 0;                                                                      \
    }
#define OPTIX_IMPL_LIST(...) __VA_ARGS__

OPTIX_IMPL_REPORT(0, "", (), ())
OPTIX_IMPL_REPORT(1, ", %3", (, unsigned int a0), (, "r"(a0)))
OPTIX_IMPL_REPORT(2, ", %3, %4", (, unsigned int a0, unsigned int a1), (, "r"(a0), "r"(a1)))
OPTIX_IMPL_REPORT(3, ", %3, %4, %5", (, unsigned int a0, unsigned int a1, unsigned int a2),
                  (, "r"(a0), "r"(a1), "r"(a2)))
OPTIX_IMPL_REPORT(4, ", %3, %4, %5, %6",
                  (, unsigned int a0, unsigned int a1, unsigned int a2, unsigned int a3),
                  (, "r"(a0), "r"(a1), "r"(a2), "r"(a3)))
OPTIX_IMPL_REPORT(5, ", %3, %4, %5, %6, %7",
                  (, unsigned int a0, unsigned int a1, unsigned int a2, unsigned int a3,
                   unsigned int a4),
                  (, "r"(a0), "r"(a1), "r"(a2), "r"(a3), "r"(a4)))
OPTIX_IMPL_REPORT(6, ", %3, %4, %5, %6, %7, %8",
                  (, unsigned int a0, unsigned int a1, unsigned int a2, unsigned int a3,
                   unsigned int a4, unsigned int a5),
                  (, "r"(a0), "r"(a1), "r"(a2), "r"(a3), "r"(a4), "r"(a5)))
OPTIX_IMPL_REPORT(7, ", %3, %4, %5, %6, %7, %8, %9",
                  (, unsigned int a0, unsigned int a1, unsigned int a2, unsigned int a3,
                   unsigned int a4, unsigned int a5, unsigned int a6),
                  (, "r"(a0), "r"(a1), "r"(a2), "r"(a3), "r"(a4), "r"(a5), "r"(a6)))
OPTIX_IMPL_REPORT(8, ", %3, %4, %5, %6, %7, %8, %9, %10",
                  (, unsigned int a0, unsigned int a1, unsigned int a2, unsigned int a3,
                   unsigned int a4, unsigned int a5, unsigned int a6, unsigned int a7),
                  (, "r"(a0), "r"(a1), "r"(a2), "r"(a3), "r"(a4), "r"(a5), "r"(a6), "r"(a7)))
#undef OPTIX_IMPL_REPORT

#define OPTIX_DEFINE_optixGetAttribute_BODY(which)                                                 \
    unsigned int value;                                                                            \
    asm("call (%0), _optix_get_attribute_" #which ", ();" : "=r"(value) :);                        \
    return value;

static __forceinline__ __device__ unsigned int optixGetAttribute_0() {
    OPTIX_DEFINE_optixGetAttribute_BODY(0);
}
static __forceinline__ __device__ unsigned int optixGetAttribute_1() {
    OPTIX_DEFINE_optixGetAttribute_BODY(1);
}
static __forceinline__ __device__ unsigned int optixGetAttribute_2() {
    OPTIX_DEFINE_optixGetAttribute_BODY(2);
}
static __forceinline__ __device__ unsigned int optixGetAttribute_3() {
    OPTIX_DEFINE_optixGetAttribute_BODY(3);
}
static __forceinline__ __device__ unsigned int optixGetAttribute_4() {
    OPTIX_DEFINE_optixGetAttribute_BODY(4);
}
static __forceinline__ __device__ unsigned int optixGetAttribute_5() {
    OPTIX_DEFINE_optixGetAttribute_BODY(5);
}
static __forceinline__ __device__ unsigned int optixGetAttribute_6() {
    OPTIX_DEFINE_optixGetAttribute_BODY(6);
}
static __forceinline__ __device__ unsigned int optixGetAttribute_7() {
    OPTIX_DEFINE_optixGetAttribute_BODY(7);
}

static __forceinline__ __device__ void optixTerminateRay() {
    asm volatile("call _optix_terminate_ray, ();" : : : "memory");
}

static __forceinline__ __device__ void optixIgnoreIntersection() {
    asm volatile("call _optix_ignore_intersection, ();" : : : "memory");
}

OPTIX_IMPL_GETTER(unsigned int, "=r", optixGetPrimitiveIndex, "_optix_read_primitive_idx")
OPTIX_IMPL_GETTER(unsigned int, "=r", optixGetSbtGASIndex, "_optix_read_sbt_gas_idx")
OPTIX_IMPL_GETTER(unsigned int, "=r", optixGetInstanceId, "_optix_read_instance_id")
OPTIX_IMPL_GETTER(unsigned int, "=r", optixGetInstanceIndex, "_optix_read_instance_idx")
OPTIX_IMPL_GETTER(unsigned int, "=r", optixGetHitKind, "_optix_get_hit_kind")

static __forceinline__ __device__ OptixPrimitiveType optixGetPrimitiveType(unsigned int hitKind) {
    unsigned int type;
    asm("call (%0), _optix_get_primitive_type_from_hit_kind, (%1);" : "=r"(type) : "r"(hitKind) :);
    return (OptixPrimitiveType)type;
}

static __forceinline__ __device__ bool optixIsBackFaceHit(unsigned int hitKind) {
    unsigned int back;
    asm("call (%0), _optix_get_backface_from_hit_kind, (%1);" : "=r"(back) : "r"(hitKind) :);
    return back != 0;
}

static __forceinline__ __device__ bool optixIsFrontFaceHit(unsigned int hitKind) {
    return !optixIsBackFaceHit(hitKind);
}

static __forceinline__ __device__ OptixPrimitiveType optixGetPrimitiveType() {
    return optixGetPrimitiveType(optixGetHitKind());
}

static __forceinline__ __device__ bool optixIsFrontFaceHit() {
    return optixIsFrontFaceHit(optixGetHitKind());
}

static __forceinline__ __device__ bool optixIsBackFaceHit() {
    return optixIsBackFaceHit(optixGetHitKind());
}

static __forceinline__ __device__ bool optixIsTriangleFrontFaceHit() {
    return optixGetHitKind() == OPTIX_HIT_KIND_TRIANGLE_FRONT_FACE;
}

static __forceinline__ __device__ bool optixIsTriangleBackFaceHit() {
    return optixGetHitKind() == OPTIX_HIT_KIND_TRIANGLE_BACK_FACE;
}

static __forceinline__ __device__ bool optixIsTriangleHit() {
    return optixIsTriangleFrontFaceHit() || optixIsTriangleBackFaceHit();
}

static __forceinline__ __device__ float2 optixGetTriangleBarycentrics() {
    float u, v;
    asm("call (%0, %1), _optix_get_triangle_barycentrics, ();" : "=f"(u), "=f"(v) :);
    return make_float2(u, v);
}

static __forceinline__ __device__ float optixGetCurveParameter() {
    return optix_impl::optixBitsFloat(optixGetAttribute_0());
}

/* ---- Acceleration structures ---- */

static __forceinline__ __device__ OptixTraversableHandle
optixGetInstanceTraversableFromIAS(OptixTraversableHandle ias, unsigned int instIdx) {
    OptixTraversableHandle handle;
    asm("call (%0), _optix_get_instance_traversable_from_ias, (%1, %2);"
        : "=l"(handle)
        : "l"(ias), "r"(instIdx)
        :);
    return handle;
}

static __forceinline__ __device__ void optixGetTriangleVertexData(OptixTraversableHandle gas,
                                                                  unsigned int primIdx,
                                                                  unsigned int sbtGASIndex,
                                                                  float time, float3 data[3]) {
    asm("call (%0, %1, %2, %3, %4, %5, %6, %7, %8), _optix_get_triangle_vertex_data, (%9, %10, "
        "%11, %12);"
        : "=f"(data[0].x), "=f"(data[0].y), "=f"(data[0].z), "=f"(data[1].x), "=f"(data[1].y),
          "=f"(data[1].z), "=f"(data[2].x), "=f"(data[2].y), "=f"(data[2].z)
        : "l"(gas), "r"(primIdx), "r"(sbtGASIndex), "f"(time)
        :);
}

static __forceinline__ __device__ void optixGetLinearCurveVertexData(OptixTraversableHandle gas,
                                                                     unsigned int primIdx,
                                                                     unsigned int sbtGASIndex,
                                                                     float time, float4 data[2]) {
    asm("call (%0, %1, %2, %3, %4, %5, %6, %7), _optix_get_linear_curve_vertex_data, (%8, %9, %10, "
        "%11);"
        : "=f"(data[0].x), "=f"(data[0].y), "=f"(data[0].z), "=f"(data[0].w), "=f"(data[1].x),
          "=f"(data[1].y), "=f"(data[1].z), "=f"(data[1].w)
        : "l"(gas), "r"(primIdx), "r"(sbtGASIndex), "f"(time)
        :);
}

static __forceinline__ __device__ void
optixGetQuadraticBSplineVertexData(OptixTraversableHandle gas, unsigned int primIdx,
                                   unsigned int sbtGASIndex, float time, float4 data[3]) {
    asm("call (%0, %1, %2, %3, %4, %5, %6, %7, %8, %9, %10, %11), "
        "_optix_get_quadratic_bspline_vertex_data, (%12, %13, %14, %15);"
        : "=f"(data[0].x), "=f"(data[0].y), "=f"(data[0].z), "=f"(data[0].w), "=f"(data[1].x),
          "=f"(data[1].y), "=f"(data[1].z), "=f"(data[1].w), "=f"(data[2].x), "=f"(data[2].y),
          "=f"(data[2].z), "=f"(data[2].w)
        : "l"(gas), "r"(primIdx), "r"(sbtGASIndex), "f"(time)
        :);
}

static __forceinline__ __device__ void optixGetCubicBSplineVertexData(OptixTraversableHandle gas,
                                                                      unsigned int primIdx,
                                                                      unsigned int sbtGASIndex,
                                                                      float time, float4 data[4]) {
    asm("call (%0, %1, %2, %3, %4, %5, %6, %7, %8, %9, %10, %11, %12, %13, %14, %15), "
        "_optix_get_cubic_bspline_vertex_data, (%16, %17, %18, %19);"
        : "=f"(data[0].x), "=f"(data[0].y), "=f"(data[0].z), "=f"(data[0].w), "=f"(data[1].x),
          "=f"(data[1].y), "=f"(data[1].z), "=f"(data[1].w), "=f"(data[2].x), "=f"(data[2].y),
          "=f"(data[2].z), "=f"(data[2].w), "=f"(data[3].x), "=f"(data[3].y), "=f"(data[3].z),
          "=f"(data[3].w)
        : "l"(gas), "r"(primIdx), "r"(sbtGASIndex), "f"(time)
        :);
}

static __forceinline__ __device__ void optixGetCatmullRomVertexData(OptixTraversableHandle gas,
                                                                    unsigned int primIdx,
                                                                    unsigned int sbtGASIndex,
                                                                    float time, float4 data[4]) {
    asm("call (%0, %1, %2, %3, %4, %5, %6, %7, %8, %9, %10, %11, %12, %13, %14, %15), "
        "_optix_get_catmullrom_vertex_data, (%16, %17, %18, %19);"
        : "=f"(data[0].x), "=f"(data[0].y), "=f"(data[0].z), "=f"(data[0].w), "=f"(data[1].x),
          "=f"(data[1].y), "=f"(data[1].z), "=f"(data[1].w), "=f"(data[2].x), "=f"(data[2].y),
          "=f"(data[2].z), "=f"(data[2].w), "=f"(data[3].x), "=f"(data[3].y), "=f"(data[3].z),
          "=f"(data[3].w)
        : "l"(gas), "r"(primIdx), "r"(sbtGASIndex), "f"(time)
        :);
}

#if SUNSTONE_OPTIX_API >= 70600
static __forceinline__ __device__ void optixGetSphereData(OptixTraversableHandle gas,
                                                          unsigned int primIdx,
                                                          unsigned int sbtGASIndex, float time,
                                                          float4 data[1]) {
    asm("call (%0, %1, %2, %3), _optix_get_sphere_data, (%4, %5, %6, %7);"
        : "=f"(data[0].x), "=f"(data[0].y), "=f"(data[0].z), "=f"(data[0].w)
        : "l"(gas), "r"(primIdx), "r"(sbtGASIndex), "f"(time)
        :);
}
#endif

OPTIX_IMPL_GETTER(OptixTraversableHandle, "=l", optixGetGASTraversableHandle,
                  "_optix_get_gas_traversable_handle")
OPTIX_IMPL_FROM_HANDLE(float, "=f", optixGetGASMotionTimeBegin, "_optix_get_gas_motion_time_begin")
OPTIX_IMPL_FROM_HANDLE(float, "=f", optixGetGASMotionTimeEnd, "_optix_get_gas_motion_time_end")
OPTIX_IMPL_FROM_HANDLE(unsigned int, "=r", optixGetGASMotionStepCount,
                       "_optix_get_gas_motion_step_count")

/* ---- Transforms ---- */

OPTIX_IMPL_GETTER(unsigned int, "=r", optixGetTransformListSize, "_optix_get_transform_list_size")

static __forceinline__ __device__ OptixTraversableHandle
optixGetTransformListHandle(unsigned int index) {
    OptixTraversableHandle handle;
    asm("call (%0), _optix_get_transform_list_handle, (%1);" : "=l"(handle) : "r"(index) :);
    return handle;
}

static __forceinline__ __device__ OptixTransformType
optixGetTransformTypeFromHandle(OptixTraversableHandle handle) {
    unsigned int type;
    asm("call (%0), _optix_get_transform_type_from_handle, (%1);" : "=r"(type) : "l"(handle) :);
    return (OptixTransformType)type;
}

OPTIX_IMPL_FROM_HANDLE(const OptixStaticTransform*, "=l", optixGetStaticTransformFromHandle,
                       "_optix_get_static_transform_from_handle")
OPTIX_IMPL_FROM_HANDLE(const OptixSRTMotionTransform*, "=l", optixGetSRTMotionTransformFromHandle,
                       "_optix_get_srt_motion_transform_from_handle")
OPTIX_IMPL_FROM_HANDLE(const OptixMatrixMotionTransform*, "=l",
                       optixGetMatrixMotionTransformFromHandle,
                       "_optix_get_matrix_motion_transform_from_handle")
OPTIX_IMPL_FROM_HANDLE(unsigned int, "=r", optixGetInstanceIdFromHandle,
                       "_optix_get_instance_id_from_handle")
OPTIX_IMPL_FROM_HANDLE(OptixTraversableHandle, "=l", optixGetInstanceChildFromHandle,
                       "_optix_get_instance_child_from_handle")
OPTIX_IMPL_FROM_HANDLE(const float4*, "=l", optixGetInstanceTransformFromHandle,
                       "_optix_get_instance_transform_from_handle")
OPTIX_IMPL_FROM_HANDLE(const float4*, "=l", optixGetInstanceInverseTransformFromHandle,
                       "_optix_get_instance_inverse_transform_from_handle")

#include "internal/optix_7_device_impl_transformations.h"

#define OPTIX_IMPL_MATRIX(from, to)                                                                \
    static __forceinline__ __device__ void optixGet##from##To##to##TransformMatrix(float m[12]) {  \
        float4 m0, m1, m2;                                                                         \
        optix_impl::optixGet##from##To##to##TransformMatrix(m0, m1, m2);                           \
        m[0] = m0.x, m[1] = m0.y, m[2] = m0.z, m[3] = m0.w;                                        \
        m[4] = m1.x, m[5] = m1.y, m[6] = m1.z, m[7] = m1.w;                                        \
        m[8] = m2.x, m[9] = m2.y, m[10] = m2.z, m[11] = m2.w;                                      \
    }                                                                                              \
    static __forceinline__ __device__ float3 optixTransformPointFrom##from##To##to##Space(         \
        float3 point) {                                                                            \
        float4 m0, m1, m2;                                                                         \
        if (optixGetTransformListSize() == 0)                                                      \
            return point;                                                                          \
        optix_impl::optixGet##from##To##to##TransformMatrix(m0, m1, m2);                           \
        return optix_impl::optixTransformPoint(m0, m1, m2, point);                                 \
    }                                                                                              \
    static __forceinline__ __device__ float3 optixTransformVectorFrom##from##To##to##Space(        \
        float3 vec) {                                                                              \
        float4 m0, m1, m2;                                                                         \
        if (optixGetTransformListSize() == 0)                                                      \
            return vec;                                                                            \
        optix_impl::optixGet##from##To##to##TransformMatrix(m0, m1, m2);                           \
        return optix_impl::optixTransformVector(m0, m1, m2, vec);                                  \
    }                                                                                              \
    /* the matrix of the other direction is the inverse */                                         \
    static __forceinline__ __device__ float3 optixTransformNormalFrom##from##To##to##Space(        \
        float3 normal) {                                                                           \
        float4 m0, m1, m2;                                                                         \
        if (optixGetTransformListSize() == 0)                                                      \
            return normal;                                                                         \
        optix_impl::optixGet##to##To##from##TransformMatrix(m0, m1, m2);                           \
        return optix_impl::optixTransformNormal(m0, m1, m2, normal);                               \
    }

OPTIX_IMPL_MATRIX(World, Object)
OPTIX_IMPL_MATRIX(Object, World)
#undef OPTIX_IMPL_MATRIX

/* ---- Launch and shader binding table ---- */

OPTIX_IMPL_VECTOR(uint3, unsigned int, "=r", optixGetLaunchIndex, "_optix_get_launch_index")
OPTIX_IMPL_VECTOR(uint3, unsigned int, "=r", optixGetLaunchDimensions,
                  "_optix_get_launch_dimension")
OPTIX_IMPL_GETTER(CUdeviceptr, "=l", optixGetSbtDataPointer, "_optix_get_sbt_data_ptr_64")

/* ---- Callables ---- */

/* The intrinsic looks up the record and returns the code address; the call is an ordinary indirect
   one. The intrinsic also prepares the callee's record, so each call needs its own. */
template <typename ReturnT, typename... ArgTypes>
static __forceinline__ __device__ ReturnT optixDirectCall(unsigned int sbtIndex, ArgTypes... args) {
    unsigned long long address;
    asm volatile("call (%0), _optix_call_direct_callable, (%1);"
                 : "=l"(address)
                 : "r"(sbtIndex)
                 : "memory");
    typedef ReturnT (*Callable)(ArgTypes...);
    return ((Callable)address)(args...);
}

template <typename ReturnT, typename... ArgTypes>
static __forceinline__ __device__ ReturnT optixContinuationCall(unsigned int sbtIndex,
                                                                ArgTypes... args) {
    unsigned long long address;
    asm volatile("call (%0), _optix_call_continuation_callable, (%1);"
                 : "=l"(address)
                 : "r"(sbtIndex)
                 : "memory");
    typedef ReturnT (*Callable)(ArgTypes...);
    return ((Callable)address)(args...);
}

/* ---- Exceptions ---- */

#define OPTIX_IMPL_THROW(count, slots, parameters, operands)                                       \
    static __forceinline__ __device__ void optixThrowException(                                    \
        int exceptionCode OPTIX_IMPL_LIST parameters) {                                            \
        asm volatile("call _optix_throw_exception_" #count ", (%0" slots ");"                      \
                     :                                                                             \
                     : "r"(exceptionCode)OPTIX_IMPL_LIST operands                                  \
                     : "memory");                                                                  \
    }

OPTIX_IMPL_THROW(0, "", (), ())
OPTIX_IMPL_THROW(1, ", %1", (, unsigned int d0), (, "r"(d0)))
OPTIX_IMPL_THROW(2, ", %1, %2", (, unsigned int d0, unsigned int d1), (, "r"(d0), "r"(d1)))
OPTIX_IMPL_THROW(3, ", %1, %2, %3", (, unsigned int d0, unsigned int d1, unsigned int d2),
                 (, "r"(d0), "r"(d1), "r"(d2)))
OPTIX_IMPL_THROW(4, ", %1, %2, %3, %4",
                 (, unsigned int d0, unsigned int d1, unsigned int d2, unsigned int d3),
                 (, "r"(d0), "r"(d1), "r"(d2), "r"(d3)))
OPTIX_IMPL_THROW(5, ", %1, %2, %3, %4, %5",
                 (, unsigned int d0, unsigned int d1, unsigned int d2, unsigned int d3,
                  unsigned int d4),
                 (, "r"(d0), "r"(d1), "r"(d2), "r"(d3), "r"(d4)))
OPTIX_IMPL_THROW(6, ", %1, %2, %3, %4, %5, %6",
                 (, unsigned int d0, unsigned int d1, unsigned int d2, unsigned int d3,
                  unsigned int d4, unsigned int d5),
                 (, "r"(d0), "r"(d1), "r"(d2), "r"(d3), "r"(d4), "r"(d5)))
OPTIX_IMPL_THROW(7, ", %1, %2, %3, %4, %5, %6, %7",
                 (, unsigned int d0, unsigned int d1, unsigned int d2, unsigned int d3,
                  unsigned int d4, unsigned int d5, unsigned int d6),
                 (, "r"(d0), "r"(d1), "r"(d2), "r"(d3), "r"(d4), "r"(d5), "r"(d6)))
OPTIX_IMPL_THROW(8, ", %1, %2, %3, %4, %5, %6, %7, %8",
                 (, unsigned int d0, unsigned int d1, unsigned int d2, unsigned int d3,
                  unsigned int d4, unsigned int d5, unsigned int d6, unsigned int d7),
                 (, "r"(d0), "r"(d1), "r"(d2), "r"(d3), "r"(d4), "r"(d5), "r"(d6), "r"(d7)))
#undef OPTIX_IMPL_THROW
#undef OPTIX_IMPL_LIST

OPTIX_IMPL_GETTER(int, "=r", optixGetExceptionCode, "_optix_get_exception_code")

#define OPTIX_DEFINE_optixGetExceptionDetail_BODY(which)                                           \
    unsigned int value;                                                                            \
    asm("call (%0), _optix_get_exception_detail_" #which ", ();" : "=r"(value) :);                 \
    return value;

static __forceinline__ __device__ unsigned int optixGetExceptionDetail_0() {
    OPTIX_DEFINE_optixGetExceptionDetail_BODY(0);
}
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_1() {
    OPTIX_DEFINE_optixGetExceptionDetail_BODY(1);
}
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_2() {
    OPTIX_DEFINE_optixGetExceptionDetail_BODY(2);
}
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_3() {
    OPTIX_DEFINE_optixGetExceptionDetail_BODY(3);
}
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_4() {
    OPTIX_DEFINE_optixGetExceptionDetail_BODY(4);
}
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_5() {
    OPTIX_DEFINE_optixGetExceptionDetail_BODY(5);
}
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_6() {
    OPTIX_DEFINE_optixGetExceptionDetail_BODY(6);
}
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_7() {
    OPTIX_DEFINE_optixGetExceptionDetail_BODY(7);
}

OPTIX_IMPL_GETTER(OptixTraversableHandle, "=l", optixGetExceptionInvalidTraversable,
                  "_optix_get_exception_invalid_traversable")
OPTIX_IMPL_GETTER(int, "=r", optixGetExceptionInvalidSbtOffset,
                  "_optix_get_exception_invalid_sbt_offset")
OPTIX_IMPL_GETTER(char*, "=l", optixGetExceptionLineInfo, "_optix_get_exception_line_info")

static __forceinline__ __device__ OptixInvalidRayExceptionDetails optixGetExceptionInvalidRay() {
    OptixInvalidRayExceptionDetails ray;
    asm("call (%0, %1, %2, %3, %4, %5, %6, %7, %8), _optix_get_exception_invalid_ray, ();"
        : "=f"(ray.origin.x), "=f"(ray.origin.y), "=f"(ray.origin.z), "=f"(ray.direction.x),
          "=f"(ray.direction.y), "=f"(ray.direction.z), "=f"(ray.tmin), "=f"(ray.tmax),
          "=f"(ray.time)
        :);
    return ray;
}

static __forceinline__ __device__ OptixParameterMismatchExceptionDetails
optixGetExceptionParameterMismatch() {
    OptixParameterMismatchExceptionDetails call;
    asm("call (%0, %1, %2, %3), _optix_get_exception_parameter_mismatch, ();"
        : "=r"(call.expectedParameterCount), "=r"(call.passedArgumentCount), "=r"(call.sbtIndex),
          "=l"(call.callableName)
        :);
    return call;
}

#include "internal/optix_7_device_impl_exception.h"

/* ---- Texture footprints ---- */
/* The intrinsics write both results to memory. */

static __forceinline__ __device__ uint4 optixTexFootprint2D(unsigned long long tex,
                                                            unsigned int texInfo, float x, float y,
                                                            unsigned int* singleMipLevel) {
    uint4 result;
    asm volatile("call _optix_tex_footprint_2d_v2, (%0, %1, %2, %3, %4, %5);"
                 :
                 : "l"(tex), "r"(texInfo), "r"(optix_impl::optixFloatBits(x)),
                   "r"(optix_impl::optixFloatBits(y)), "l"(singleMipLevel), "l"(&result)
                 : "memory");
    return result;
}

static __forceinline__ __device__ uint4 optixTexFootprint2DGrad(
    unsigned long long tex, unsigned int texInfo, float x, float y, float dPdx_x, float dPdx_y,
    float dPdy_x, float dPdy_y, bool coarse, unsigned int* singleMipLevel) {
    uint4 result;
    asm volatile("call _optix_tex_footprint_2d_grad_v2, "
                 "(%0, %1, %2, %3, %4, %5, %6, %7, %8, %9, %10);"
                 :
                 : "l"(tex), "r"(texInfo), "r"(optix_impl::optixFloatBits(x)),
                   "r"(optix_impl::optixFloatBits(y)), "r"(optix_impl::optixFloatBits(dPdx_x)),
                   "r"(optix_impl::optixFloatBits(dPdx_y)), "r"(optix_impl::optixFloatBits(dPdy_x)),
                   "r"(optix_impl::optixFloatBits(dPdy_y)), "r"((unsigned int)coarse),
                   "l"(singleMipLevel), "l"(&result)
                 : "memory");
    return result;
}

static __forceinline__ __device__ uint4 optixTexFootprint2DLod(unsigned long long tex,
                                                               unsigned int texInfo, float x,
                                                               float y, float level, bool coarse,
                                                               unsigned int* singleMipLevel) {
    uint4 result;
    asm volatile("call _optix_tex_footprint_2d_lod_v2, (%0, %1, %2, %3, %4, %5, %6, %7);"
                 :
                 : "l"(tex), "r"(texInfo), "r"(optix_impl::optixFloatBits(x)),
                   "r"(optix_impl::optixFloatBits(y)), "r"(optix_impl::optixFloatBits(level)),
                   "r"((unsigned int)coarse), "l"(singleMipLevel), "l"(&result)
                 : "memory");
    return result;
}

#undef OPTIX_IMPL_GETTER
#undef OPTIX_IMPL_FROM_HANDLE
#undef OPTIX_IMPL_VECTOR

#endif
