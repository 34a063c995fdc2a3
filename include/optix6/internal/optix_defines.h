// SPDX-License-Identifier: Apache-2.0
// Numbers that device headers and the library agree on. Source: OptiX 6.0 API reference,
// section 8.14.
#ifndef SUNSTONE_OPTIX6_DEFINES_H
#define SUNSTONE_OPTIX6_DEFINES_H

#if defined(__x86_64__) || defined(__LP64__) || defined(_WIN64)
#define OPTIX_ASM_PTR "l"
#define OPTIX_ASM_SIZE_T "l"
#define OPTIX_ASM_PTR_SIZE_STR "64"
#define OPTIX_BITNESS_SUFFIX "_64"
#else
#define OPTIX_ASM_PTR "r"
#define OPTIX_ASM_SIZE_T "r"
#define OPTIX_ASM_PTR_SIZE_STR "32"
#define OPTIX_BITNESS_SUFFIX ""
#endif

// Direction of rtTransformPoint and similar functions.
enum RTtransformkind { RT_WORLD_TO_OBJECT = 0xf00, RT_OBJECT_TO_WORLD };

enum RTtransformflags { RT_INTERNAL_INVERSE_TRANSPOSE = 0x1000 };

#ifdef __cplusplus

// Type information that rtDeclareVariable defines for a variable.
namespace rti_internal_typeinfo {

enum rtiTypeKind { _OPTIX_VARIABLE = 0x796152 };

enum rtiTypeEnum {
    _OPTIX_TYPE_ENUM_UNKNOWN = 0x1337,
    _OPTIX_TYPE_ENUM_PROGRAM_ID,
    _OPTIX_TYPE_ENUM_PROGRAM_AS_ID
};

struct rti_typeinfo {
    unsigned int kind;
    unsigned int size;
};

template <typename T>
struct rti_typeenum {
    static const int m_typeenum = _OPTIX_TYPE_ENUM_UNKNOWN;
};

} // namespace rti_internal_typeinfo

namespace optix {

#if defined(__CUDACC_RTC__)
typedef unsigned long long optix_size_t;
#else
typedef __SIZE_TYPE__ optix_size_t;
#endif

enum rtiTexLookupKind {
    TEX_LOOKUP_1D = 1,
    TEX_LOOKUP_2D = 2,
    TEX_LOOKUP_3D = 3,
    TEX_LOOKUP_A1 = 4,
    TEX_LOOKUP_A2 = 5,
    TEX_LOOKUP_CUBE = 6,
    TEX_LOOKUP_ACUBE = 7
};

} // namespace optix

#endif

#endif
