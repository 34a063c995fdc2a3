// SPDX-License-Identifier: Apache-2.0
// The device half of the classic API: declarations of programs and variables, functions of
// programs, buffers, callable programs, textures, printing. Source: OptiX 6.0 API reference,
// sections 5.22 to 5.26, 7.5 to 7.13, 8.15.
#ifndef SUNSTONE_OPTIX6_DEVICE_H
#define SUNSTONE_OPTIX6_DEVICE_H

#if !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
#error "optix_device.h is for device compilers"
#endif

#if !defined(__CUDACC_RTC__)
#include <stdio.h> /* printf */
#endif

#include "internal/optix_datatypes.h"
#include "internal/optix_declarations.h"
#include "internal/optix_defines.h"
#include "internal/optix_internal.h"
#include "internal/optix_sizet.h"

// ---- Programs and variables -------------------------------------------------------------------

#define RT_PROGRAM __global__
#define RT_CALLABLE_PROGRAM __device__ __noinline__

// A variable, followed by the information that the library needs about it.
#define rtDeclareVariable(type, name, semantic, annotation)                                        \
    namespace rti_internal_typeinfo {                                                              \
    __device__ ::rti_internal_typeinfo::rti_typeinfo name = {                                      \
        ::rti_internal_typeinfo::_OPTIX_VARIABLE, sizeof(type)};                                   \
    }                                                                                              \
    namespace rti_internal_typename {                                                              \
    __device__ char name[] = #type;                                                                \
    }                                                                                              \
    namespace rti_internal_typeenum {                                                              \
    __device__ int name = ::rti_internal_typeinfo::rti_typeenum<type>::m_typeenum;                 \
    }                                                                                              \
    namespace rti_internal_semantic {                                                              \
    __device__ char name[] = #semantic;                                                            \
    }                                                                                              \
    namespace rti_internal_annotation {                                                            \
    __device__ char name[] = #annotation;                                                          \
    }                                                                                              \
    __device__ type name

#define rtDeclareAnnotation(variable, annotation)                                                  \
    namespace rti_internal_annotation {                                                            \
    __device__ char variable[] = #annotation;                                                      \
    }

// A node of the scene, set with rtVariableSetObject.
struct rtObject {
    // For the functions below.
    __device__ __forceinline__ unsigned int sunstoneHandle() const { return handle; }

protected:
    unsigned int handle;
};

// ---- Buffers ----------------------------------------------------------------------------------

#define rtBuffer __device__ optix::buffer
#define rtBufferId optix::bufferId

namespace optix {

template <typename T, int Dim>
struct VectorTypes;
template <>
struct VectorTypes<int, 1> {
    typedef int Type;
};
template <>
struct VectorTypes<int, 2> {
    typedef int2 Type;
};
template <>
struct VectorTypes<int, 3> {
    typedef int3 Type;
};
template <>
struct VectorTypes<int, 4> {
    typedef int4 Type;
};
template <>
struct VectorTypes<unsigned int, 1> {
    typedef unsigned int Type;
};
template <>
struct VectorTypes<unsigned int, 2> {
    typedef uint2 Type;
};
template <>
struct VectorTypes<unsigned int, 3> {
    typedef uint3 Type;
};
template <>
struct VectorTypes<unsigned int, 4> {
    typedef uint4 Type;
};
template <>
struct VectorTypes<float, 1> {
    typedef float Type;
};
template <>
struct VectorTypes<float, 2> {
    typedef float2 Type;
};
template <>
struct VectorTypes<float, 3> {
    typedef float3 Type;
};
template <>
struct VectorTypes<float, 4> {
    typedef float4 Type;
};
template <>
struct VectorTypes<optix_size_t, 1> {
    typedef optix_size_t Type;
};
template <>
struct VectorTypes<optix_size_t, 2> {
    typedef size_t2 Type;
};
template <>
struct VectorTypes<optix_size_t, 3> {
    typedef size_t3 Type;
};
template <>
struct VectorTypes<optix_size_t, 4> {
    typedef size_t4 Type;
};

namespace sunstone {

// Parts of an index, and indices from the sizes of all dimensions.
__device__ __forceinline__ size_t4 spread(optix_size_t i) {
    return size_t4(i, 0, 0, 0);
}
__device__ __forceinline__ size_t4 spread(size_t2 i) {
    return size_t4(i.x, i.y, 0, 0);
}
__device__ __forceinline__ size_t4 spread(size_t3 i) {
    return size_t4(i.x, i.y, i.z, 0);
}
__device__ __forceinline__ size_t4 spread(size_t4 i) {
    return i;
}
template <int Dim>
struct First;
template <>
struct First<1> {
    static __device__ __forceinline__ optix_size_t of(size_t4 v) { return v.x; }
};
template <>
struct First<2> {
    static __device__ __forceinline__ size_t2 of(size_t4 v) { return size_t2(v.x, v.y); }
};
template <>
struct First<3> {
    static __device__ __forceinline__ size_t3 of(size_t4 v) { return size_t3(v.x, v.y, v.z); }
};
template <>
struct First<4> {
    static __device__ __forceinline__ size_t4 of(size_t4 v) { return v; }
};

} // namespace sunstone

// A buffer that the host gives an id.
template <typename T, int Dim = 1>
struct bufferId {
    typedef typename VectorTypes<optix_size_t, Dim>::Type WrapperType;
    typedef WrapperType IndexType;

    __device__ __forceinline__ bufferId() {}
    __device__ __forceinline__ bufferId(RTbufferidnull nullid) : m_id((int)nullid) {}
    __device__ __forceinline__ explicit bufferId(int id) : m_id(id) {}
    __device__ __forceinline__ bufferId& operator=(RTbufferidnull nullid) {
        m_id = nullid;
        return *this;
    }
    __device__ __forceinline__ T& operator[](IndexType i) const {
        const size_t4 c = sunstone::spread(i);
        return *(T*)rt_buffer_get_id(m_id, Dim, sizeof(T), c.x, c.y, c.z, c.w);
    }
    __device__ __forceinline__ IndexType size() const {
        return sunstone::First<Dim>::of(rt_buffer_get_size_id(m_id, Dim, sizeof(T)));
    }
    __device__ __forceinline__ int getId() const { return m_id; }
    __device__ __forceinline__ operator bool() const { return m_id != RT_BUFFER_ID_NULL; }

private:
    int m_id;
};

// A buffer that the host binds to a variable. Without members: the library recognises its size.
template <typename T, int Dim = 1>
struct buffer {
    typedef typename VectorTypes<optix_size_t, Dim>::Type WrapperType;
    typedef WrapperType IndexType;
    template <typename T2>
    struct type {
        typedef T2 Type;
    };

    __device__ __forceinline__ T& operator[](IndexType i) {
        const size_t4 c = sunstone::spread(i);
        return *(T*)rt_buffer_get(this, Dim, sizeof(T), c.x, c.y, c.z, c.w);
    }
    __device__ __forceinline__ IndexType size() const {
        return sunstone::First<Dim>::of(rt_buffer_get_size(this, Dim, sizeof(T)));
    }
};

} // namespace optix

// ---- Callable programs ------------------------------------------------------------------------

template <typename T>
struct rtCallableProgramSizeofWrapper {
    static const optix::optix_size_t value = sizeof(T);
};
template <>
struct rtCallableProgramSizeofWrapper<void> {
    static const optix::optix_size_t value = 0;
};

namespace optix {

template <typename T>
class callableProgramId;
template <typename T>
class boundCallableProgramId;
template <typename T>
class markedCallableProgramId;

// Calls a program by its id; at most ten parameters.
template <typename ReturnT, typename... Args>
class callableProgramId<ReturnT(Args...)> {
    static_assert(sizeof...(Args) <= 10, "callable programs have at most ten parameters");

public:
    __device__ __forceinline__ callableProgramId() {}
    __device__ __forceinline__ callableProgramId(RTprogramidnull nullid) : m_id((int)nullid) {}
    __device__ __forceinline__ explicit callableProgramId(int id) : m_id(id) {}
    __device__ __forceinline__ callableProgramId& operator=(RTprogramidnull nullid) {
        m_id = nullid;
        return *this;
    }
    __device__ __forceinline__ int getId() const { return m_id; }
    __device__ __forceinline__ operator bool() const { return m_id != RT_PROGRAM_ID_NULL; }
    __device__ __forceinline__ ReturnT operator()(Args... args) const {
        typedef ReturnT (*Function)(Args...);
        return ((Function)rt_callable_program_from_id(m_id))(args...);
    }

private:
    int m_id;
};

// A program that the host binds with rtVariableSetObject.
template <typename ReturnT, typename... Args>
class boundCallableProgramId<ReturnT(Args...)> {
    static_assert(sizeof...(Args) <= 10, "callable programs have at most ten parameters");

public:
    __device__ __forceinline__ boundCallableProgramId() {}
    __device__ __forceinline__ ReturnT operator()(Args... args) const {
        typedef ReturnT (*Function)(Args...);
        return ((Function)rt_callable_program_from_id(m_id))(args...);
    }

private:
    __device__ boundCallableProgramId(const boundCallableProgramId&);
    __device__ boundCallableProgramId& operator=(const boundCallableProgramId&);
    int m_id;
};

// A call site with a name, for rtProgramCallsiteSetPotentialCallees.
template <typename ReturnT, typename... Args>
class markedCallableProgramId<ReturnT(Args...)> {
    static_assert(sizeof...(Args) <= 10, "callable programs have at most ten parameters");

public:
    __device__ __forceinline__ explicit markedCallableProgramId(int id, const char* callSiteName)
        : m_id(id), m_callSiteName(callSiteName) {}
    __device__ __forceinline__ explicit markedCallableProgramId(
        callableProgramId<ReturnT(Args...)> callable, const char* callSiteName)
        : m_id(callable.getId()), m_callSiteName(callSiteName) {}
    __device__ __forceinline__ int getId() const { return m_id; }
    __device__ __forceinline__ operator bool() const { return m_id != RT_PROGRAM_ID_NULL; }
    __device__ __forceinline__ ReturnT operator()(Args... args) const {
        typedef ReturnT (*Function)(Args...);
        return ((Function)rt_callable_program_from_id(m_id, m_callSiteName))(args...);
    }

private:
    int m_id;
    const char* m_callSiteName;
};

} // namespace optix

namespace rti_internal_typeinfo {

template <typename T>
struct rti_typeenum<optix::callableProgramId<T>> {
    static const int m_typeenum = _OPTIX_TYPE_ENUM_PROGRAM_ID;
};
template <typename T>
struct rti_typeenum<optix::boundCallableProgramId<T>> {
    static const int m_typeenum = _OPTIX_TYPE_ENUM_PROGRAM_AS_ID;
};

} // namespace rti_internal_typeinfo

#define rtCallableProgramId optix::callableProgramId
#define rtMarkedCallableProgramId optix::markedCallableProgramId
#define rtCallableProgramX optix::boundCallableProgramId
#ifdef RT_USE_TEMPLATED_RTCALLABLEPROGRAM
#define rtCallableProgram optix::boundCallableProgramId
#else
#define rtCallableProgram(return_type, function_name, parameter_list)                              \
    rtDeclareVariable(optix::boundCallableProgramId<return_type parameter_list>, function_name, , )
#endif

// ---- Functions of programs --------------------------------------------------------------------

#define SUNSTONE_OPTIX_DEVICE static __forceinline__ __device__

template <class T>
SUNSTONE_OPTIX_DEVICE void rtTrace(rtObject topNode, optix::Ray ray, T& prd,
                                   RTvisibilitymask mask = RT_VISIBILITY_ALL,
                                   RTrayflags flags = RT_RAY_FLAG_NONE) {
    optix::rt_trace(topNode.sunstoneHandle(), ray.origin, ray.direction, ray.ray_type, ray.tmin,
                    ray.tmax, mask, flags, &prd, sizeof(T));
}

template <class T>
SUNSTONE_OPTIX_DEVICE void rtTrace(rtObject topNode, optix::Ray ray, float time, T& prd,
                                   RTvisibilitymask mask = RT_VISIBILITY_ALL,
                                   RTrayflags flags = RT_RAY_FLAG_NONE) {
    optix::rt_trace_with_time(topNode.sunstoneHandle(), ray.origin, ray.direction, ray.ray_type,
                              ray.tmin, ray.tmax, time, mask, flags, &prd, sizeof(T));
}

SUNSTONE_OPTIX_DEVICE bool rtPotentialIntersection(float tmin) {
    return optix::rt_potential_intersection(tmin);
}
SUNSTONE_OPTIX_DEVICE bool rtReportIntersection(unsigned int material) {
    return optix::rt_report_intersection(material);
}
SUNSTONE_OPTIX_DEVICE void rtIgnoreIntersection() {
    optix::rt_ignore_intersection();
}
SUNSTONE_OPTIX_DEVICE void rtTerminateRay() {
    optix::rt_terminate_ray();
}
SUNSTONE_OPTIX_DEVICE void rtIntersectChild(unsigned int index) {
    optix::rt_intersect_child(index);
}
SUNSTONE_OPTIX_DEVICE float3 rtTransformPoint(RTtransformkind kind, const float3& p) {
    return optix::rt_transform_point(kind, p);
}
SUNSTONE_OPTIX_DEVICE float3 rtTransformVector(RTtransformkind kind, const float3& v) {
    return optix::rt_transform_vector(kind, v);
}
SUNSTONE_OPTIX_DEVICE float3 rtTransformNormal(RTtransformkind kind, const float3& n) {
    return optix::rt_transform_normal(kind, n);
}
SUNSTONE_OPTIX_DEVICE void rtGetTransform(RTtransformkind kind, float matrix[16]) {
    optix::rt_get_transform(kind, matrix);
}
SUNSTONE_OPTIX_DEVICE unsigned int rtGetPrimitiveIndex() {
    return optix::rt_get_primitive_index();
}
SUNSTONE_OPTIX_DEVICE bool rtIsTriangleHit() {
    return optix::rt_is_triangle_hit();
}
SUNSTONE_OPTIX_DEVICE bool rtIsTriangleHitBackFace() {
    return optix::rt_is_triangle_hit_back_face();
}
SUNSTONE_OPTIX_DEVICE bool rtIsTriangleHitFrontFace() {
    return optix::rt_is_triangle_hit_front_face();
}
SUNSTONE_OPTIX_DEVICE float2 rtGetTriangleBarycentrics() {
    return optix::rt_get_triangle_barycentrics();
}
SUNSTONE_OPTIX_DEVICE void rtThrow(unsigned int code) {
    optix::rt_throw(code);
}
SUNSTONE_OPTIX_DEVICE unsigned int rtGetExceptionCode() {
    return optix::rt_get_exception_code();
}

// ---- Printing ---------------------------------------------------------------------------------

SUNSTONE_OPTIX_DEVICE void rtPrintf(const char* fmt) {
    _RT_PRINT_ACTIVE()
    printf(fmt, 0); // an extra argument, because the caller provides the format
}
template <typename T1, typename... Rest>
SUNSTONE_OPTIX_DEVICE void rtPrintf(const char* fmt, T1 arg1, Rest... rest) {
    static_assert(sizeof...(Rest) <= 12, "rtPrintf takes at most thirteen arguments");
    _RT_PRINT_ACTIVE()
    printf(fmt, arg1, rest...);
}

SUNSTONE_OPTIX_DEVICE void rtPrintExceptionDetails() {
    const unsigned int code = rtGetExceptionCode();
    switch (code) {
#define SUNSTONE_CAUGHT(name)                                                                      \
    case name:                                                                                     \
        return rtPrintf("Caught " #name "\n");
        SUNSTONE_CAUGHT(RT_EXCEPTION_PAYLOAD_ACCESS_OUT_OF_BOUNDS)
        SUNSTONE_CAUGHT(RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS)
        SUNSTONE_CAUGHT(RT_EXCEPTION_TRACE_DEPTH_EXCEEDED)
        SUNSTONE_CAUGHT(RT_EXCEPTION_PROGRAM_ID_INVALID)
        SUNSTONE_CAUGHT(RT_EXCEPTION_TEXTURE_ID_INVALID)
        SUNSTONE_CAUGHT(RT_EXCEPTION_BUFFER_ID_INVALID)
        SUNSTONE_CAUGHT(RT_EXCEPTION_INDEX_OUT_OF_BOUNDS)
        SUNSTONE_CAUGHT(RT_EXCEPTION_STACK_OVERFLOW)
        SUNSTONE_CAUGHT(RT_EXCEPTION_BUFFER_INDEX_OUT_OF_BOUNDS)
        SUNSTONE_CAUGHT(RT_EXCEPTION_INVALID_RAY)
        SUNSTONE_CAUGHT(RT_EXCEPTION_INTERNAL_ERROR)
#undef SUNSTONE_CAUGHT
    default:
        rtPrintf("Caught RT_EXCEPTION_USER + %u\n", code - RT_EXCEPTION_USER);
    }
}

#include "internal/optix_device_textures.h"
#include "internal/optix_texture_references.h"

#undef SUNSTONE_OPTIX_DEVICE

#endif
