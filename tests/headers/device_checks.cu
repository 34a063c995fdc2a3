// SPDX-License-Identifier: Apache-2.0
// Compiles if the device headers match the table of facts, and contains one kernel for each device
// function, whose PTX check_calls.cpp compares with optix7_intrinsics.tsv.
#include <optix.h>

template <typename A, typename B>
struct SameType {
    static const bool value = false;
};
template <typename A>
struct SameType<A, A> {
    static const bool value = true;
};
// NVRTC cannot take offsets in constant expressions; there the sizes of structs and the types of their
// fields have to do.
#if defined(__CUDACC_RTC__)
#define CHECK_OFFSET(type, member, offset)
#else
#define CHECK_OFFSET(type, member, offset)                                                         \
    static_assert(__builtin_offsetof(type, member) == offset, "offset of " #type "::" #member);
#endif

// The host's part of the table is not visible here.
#include "device_checks.inc"

#include "device_calls.inc"

extern "C" __global__ void call_optixDirectCall__0(float* out, unsigned int index,
                                                   float3 argument) {
    *out = optixDirectCall<float>(index, 3, argument);
}

extern "C" __global__ void call_optixContinuationCall__0(unsigned int index) {
    optixContinuationCall<void>(index);
}

// Forms of calls that programs use beside the plain ones: payload in members and arrays.
struct Payload {
    unsigned int words[2];
    unsigned int more;
};
extern "C" __global__ void call_optixTrace__3_members(Payload* p, OptixTraversableHandle handle) {
    Payload local = *p;
    optixTrace(handle, make_float3(0.0f, 0.0f, 0.0f), make_float3(0.0f, 0.0f, 1.0f), 0.0f, 1.0f,
               0.0f, OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0,
               local.words[0], local.words[1], local.more);
    *p = local;
}
