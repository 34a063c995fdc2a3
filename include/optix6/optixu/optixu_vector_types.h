// SPDX-License-Identifier: Apache-2.0
// CUDA's vector types as members of namespace optix. They are the types of the global namespace:
// optix::float3 and ::float3 are one type. Source: OptiX API reference 6.0, sections 8.25, 8.40.
#ifndef SUNSTONE_OPTIXU_VECTOR_TYPES_H
#define SUNSTONE_OPTIXU_VECTOR_TYPES_H

// NVRTC has the types built in.
#ifndef __CUDACC_RTC__
#include <vector_types.h>
#endif

// Toolkits since CUDA 13 deprecate the four-component types of 64-bit components, which are part of
// this API: naming them in this API's headers gives no warning.
#if defined(__GNUC__)
#define SUNSTONE_DEPRECATED_TYPES_BEGIN_HOST                                                       \
    _Pragma("GCC diagnostic push") _Pragma("GCC diagnostic ignored \"-Wdeprecated-declarations\"")
#define SUNSTONE_DEPRECATED_TYPES_END_HOST _Pragma("GCC diagnostic pop")
#else
#define SUNSTONE_DEPRECATED_TYPES_BEGIN_HOST
#define SUNSTONE_DEPRECATED_TYPES_END_HOST
#endif
#if defined(__NVCC__) || defined(__CUDACC_RTC__)
#define SUNSTONE_DEPRECATED_TYPES_BEGIN                                                            \
    _Pragma("nv_diagnostic push") _Pragma("nv_diag_suppress 1444")                                 \
        SUNSTONE_DEPRECATED_TYPES_BEGIN_HOST
#define SUNSTONE_DEPRECATED_TYPES_END                                                              \
    SUNSTONE_DEPRECATED_TYPES_END_HOST _Pragma("nv_diagnostic pop")
#else
#define SUNSTONE_DEPRECATED_TYPES_BEGIN SUNSTONE_DEPRECATED_TYPES_BEGIN_HOST
#define SUNSTONE_DEPRECATED_TYPES_END SUNSTONE_DEPRECATED_TYPES_END_HOST
#endif

namespace optix {

SUNSTONE_DEPRECATED_TYPES_BEGIN
#define SUNSTONE_VECTOR(name)                                                                      \
    using ::name##1;                                                                               \
    using ::name##2;                                                                               \
    using ::name##3;                                                                               \
    using ::name##4;
SUNSTONE_VECTOR(char)
SUNSTONE_VECTOR(uchar)
SUNSTONE_VECTOR(short)
SUNSTONE_VECTOR(ushort)
SUNSTONE_VECTOR(int)
SUNSTONE_VECTOR(uint)
SUNSTONE_VECTOR(long)
SUNSTONE_VECTOR(ulong)
SUNSTONE_VECTOR(longlong)
SUNSTONE_VECTOR(ulonglong)
SUNSTONE_VECTOR(float)
SUNSTONE_VECTOR(double)
#undef SUNSTONE_VECTOR
SUNSTONE_DEPRECATED_TYPES_END

} // namespace optix

#endif
