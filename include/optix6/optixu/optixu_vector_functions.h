// SPDX-License-Identifier: Apache-2.0
// CUDA's make_<vector type> functions as members of namespace optix. optixu_math_namespace.h
// overloads them. Source: OptiX API reference 6.0, section 8.39.
#ifndef SUNSTONE_OPTIXU_VECTOR_FUNCTIONS_H
#define SUNSTONE_OPTIXU_VECTOR_FUNCTIONS_H

#include "optixu_vector_types.h"

#ifndef __CUDACC_RTC__
#include <vector_functions.h>
#endif

namespace optix {

SUNSTONE_DEPRECATED_TYPES_BEGIN
#define SUNSTONE_MAKERS(name)                                                                      \
    using ::make_##name##1;                                                                        \
    using ::make_##name##2;                                                                        \
    using ::make_##name##3;                                                                        \
    using ::make_##name##4;
SUNSTONE_MAKERS(char)
SUNSTONE_MAKERS(uchar)
SUNSTONE_MAKERS(short)
SUNSTONE_MAKERS(ushort)
SUNSTONE_MAKERS(int)
SUNSTONE_MAKERS(uint)
SUNSTONE_MAKERS(long)
SUNSTONE_MAKERS(ulong)
SUNSTONE_MAKERS(longlong)
SUNSTONE_MAKERS(ulonglong)
SUNSTONE_MAKERS(float)
SUNSTONE_MAKERS(double)
#undef SUNSTONE_MAKERS
SUNSTONE_DEPRECATED_TYPES_END

} // namespace optix

#endif
