// SPDX-License-Identifier: Apache-2.0
// Prints exceptions and transforms from device code, for debugging. Part of optix_7_device.h. An
// exception program may call optix_impl::optixDumpExceptionDetails().
// Source: OptiX API reference 7.4, sections 4.1, 6.4.
#if !defined(SUNSTONE_OPTIX7_OPTIX_7_DEVICE_IMPL_H)
#include "optix_7_device.h" /* included by itself: comes back here in the right order */
#elif !defined(SUNSTONE_OPTIX7_OPTIX_7_DEVICE_IMPL_EXCEPTION_H)
#define SUNSTONE_OPTIX7_OPTIX_7_DEVICE_IMPL_EXCEPTION_H

#if !defined(__CUDACC_RTC__) && !defined(__clang__)
#include <stdio.h> /* printf */
#endif

/* clang knows printf on the device by this name, with or without a header. */
#if defined(__clang__)
#define OPTIX_IMPL_PRINTF __builtin_printf
#else
#define OPTIX_IMPL_PRINTF printf
#endif

namespace optix_impl {

static __forceinline__ __device__ void optixDumpMatrix(const char* title, const float* m) {
    OPTIX_IMPL_PRINTF("      %s\n", title);
    for (int row = 0; row < 3; ++row)
        OPTIX_IMPL_PRINTF("        %g %g %g %g\n", (double)m[4 * row], (double)m[4 * row + 1],
                          (double)m[4 * row + 2], (double)m[4 * row + 3]);
}

static __forceinline__ __device__ void optixDumpMotion(const OptixMotionOptions& options) {
    OPTIX_IMPL_PRINTF("      %u keys from %g to %g, flags 0x%x\n", (unsigned int)options.numKeys,
                      (double)options.timeBegin, (double)options.timeEnd,
                      (unsigned int)options.flags);
}

static __forceinline__ __device__ void
optixDumpStaticTransformFromHandle(OptixTraversableHandle handle) {
    const OptixStaticTransform* transform = optixGetStaticTransformFromHandle(handle);
    if (!transform)
        return;
    OPTIX_IMPL_PRINTF("    static transform, child 0x%llx\n", transform->child);
    optixDumpMatrix("object to world", transform->transform);
    optixDumpMatrix("world to object", transform->invTransform);
}

static __forceinline__ __device__ void
optixDumpMotionMatrixTransformFromHandle(OptixTraversableHandle handle) {
    const OptixMatrixMotionTransform* transform = optixGetMatrixMotionTransformFromHandle(handle);
    if (!transform)
        return;
    OPTIX_IMPL_PRINTF("    matrix motion transform, child 0x%llx\n", transform->child);
    optixDumpMotion(transform->motionOptions);
    for (int key = 0; key < (int)transform->motionOptions.numKeys; ++key)
        optixDumpMatrix("key", &transform->transform[0][0] + 12 * key);
}

static __forceinline__ __device__ void
optixDumpSrtMatrixTransformFromHandle(OptixTraversableHandle handle) {
    const OptixSRTMotionTransform* transform = optixGetSRTMotionTransformFromHandle(handle);
    if (!transform)
        return;
    OPTIX_IMPL_PRINTF("    SRT motion transform, child 0x%llx\n", transform->child);
    optixDumpMotion(transform->motionOptions);
    for (int i = 0; i < (int)transform->motionOptions.numKeys; ++i) {
        const OptixSRTData& key = *((const OptixSRTData*)transform->srtData + i);
        OPTIX_IMPL_PRINTF("      scale %g %g %g  shear %g %g %g  pivot %g %g %g\n", (double)key.sx,
                          (double)key.sy, (double)key.sz, (double)key.a, (double)key.b,
                          (double)key.c, (double)key.pvx, (double)key.pvy, (double)key.pvz);
        OPTIX_IMPL_PRINTF("      quaternion %g %g %g %g  translation %g %g %g\n", (double)key.qx,
                          (double)key.qy, (double)key.qz, (double)key.qw, (double)key.tx,
                          (double)key.ty, (double)key.tz);
    }
}

static __forceinline__ __device__ void optixDumpInstanceFromHandle(OptixTraversableHandle handle) {
    if (optixGetTransformTypeFromHandle(handle) != OPTIX_TRANSFORM_TYPE_INSTANCE)
        return;
    OPTIX_IMPL_PRINTF("    instance %u, child 0x%llx\n", optixGetInstanceIdFromHandle(handle),
                      optixGetInstanceChildFromHandle(handle));
    optixDumpMatrix("object to world", (const float*)optixGetInstanceTransformFromHandle(handle));
    optixDumpMatrix("world to object",
                    (const float*)optixGetInstanceInverseTransformFromHandle(handle));
}

static __forceinline__ __device__ void optixDumpTransform(OptixTraversableHandle handle) {
    switch (optixGetTransformTypeFromHandle(handle)) {
    case OPTIX_TRANSFORM_TYPE_STATIC_TRANSFORM:
        optixDumpStaticTransformFromHandle(handle);
        break;
    case OPTIX_TRANSFORM_TYPE_MATRIX_MOTION_TRANSFORM:
        optixDumpMotionMatrixTransformFromHandle(handle);
        break;
    case OPTIX_TRANSFORM_TYPE_SRT_MOTION_TRANSFORM:
        optixDumpSrtMatrixTransformFromHandle(handle);
        break;
    case OPTIX_TRANSFORM_TYPE_INSTANCE:
        optixDumpInstanceFromHandle(handle);
        break;
    default:
        OPTIX_IMPL_PRINTF("    no transform\n");
        break;
    }
}

static __forceinline__ __device__ void optixDumpTransformList() {
    const unsigned int size = optixGetTransformListSize();
    OPTIX_IMPL_PRINTF("  %u transforms, root first\n", size);
    for (unsigned int i = 0; i < size; ++i)
        optixDumpTransform(optixGetTransformListHandle(i));
}

static __forceinline__ __device__ void optixDumpInvalidRay() {
    const OptixInvalidRayExceptionDetails ray = optixGetExceptionInvalidRay();
    OPTIX_IMPL_PRINTF("  origin %g %g %g  direction %g %g %g\n", (double)ray.origin.x,
                      (double)ray.origin.y, (double)ray.origin.z, (double)ray.direction.x,
                      (double)ray.direction.y, (double)ray.direction.z);
    OPTIX_IMPL_PRINTF("  tmin %g  tmax %g  time %g\n", (double)ray.tmin, (double)ray.tmax,
                      (double)ray.time);
}

static __forceinline__ __device__ void optixDumpParameterMismatch() {
    const OptixParameterMismatchExceptionDetails call = optixGetExceptionParameterMismatch();
    OPTIX_IMPL_PRINTF("  callable %s of SBT record %u takes %u words, %u were passed\n",
                      call.callableName ? call.callableName : "?", call.sbtIndex,
                      call.expectedParameterCount, call.passedArgumentCount);
}

/** Prints the details of the current exception. EX. */
static __forceinline__ __device__ void optixDumpExceptionDetails() {
    const int code = optixGetExceptionCode();
    const char* line = optixGetExceptionLineInfo();
    OPTIX_IMPL_PRINTF("OptiX exception %d%s\n", code, code >= 0 ? " (user exception)" : "");
    switch (code) {
    case OPTIX_EXCEPTION_CODE_STACK_OVERFLOW:
        OPTIX_IMPL_PRINTF("  continuation stack overflow\n");
        break;
    case OPTIX_EXCEPTION_CODE_TRACE_DEPTH_EXCEEDED:
        OPTIX_IMPL_PRINTF("  trace depth exceeded\n");
        break;
    case OPTIX_EXCEPTION_CODE_TRAVERSAL_DEPTH_EXCEEDED:
        OPTIX_IMPL_PRINTF("  traversal depth exceeded\n");
        optixDumpTransformList();
        break;
    case OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_TRAVERSABLE:
    case OPTIX_EXCEPTION_CODE_UNSUPPORTED_SINGLE_LEVEL_GAS:
        OPTIX_IMPL_PRINTF("  traversable 0x%llx cannot be traversed here\n",
                          optixGetExceptionInvalidTraversable());
        optixDumpTransformList();
        break;
    case OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_MISS_SBT:
    case OPTIX_EXCEPTION_CODE_CALLABLE_INVALID_SBT:
    case OPTIX_EXCEPTION_CODE_CALLABLE_NO_DC_SBT_RECORD:
    case OPTIX_EXCEPTION_CODE_CALLABLE_NO_CC_SBT_RECORD:
        OPTIX_IMPL_PRINTF("  bad SBT record index %d\n", optixGetExceptionInvalidSbtOffset());
        break;
    case OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_HIT_SBT:
        OPTIX_IMPL_PRINTF("  bad hit record index %d, GAS record %u\n",
                          optixGetExceptionInvalidSbtOffset(), optixGetSbtGASIndex());
        optixDumpTransformList();
        break;
    case OPTIX_EXCEPTION_CODE_INVALID_RAY:
        OPTIX_IMPL_PRINTF("  ray with infinite or NaN values\n");
        optixDumpInvalidRay();
        break;
    case OPTIX_EXCEPTION_CODE_CALLABLE_PARAMETER_MISMATCH:
        optixDumpParameterMismatch();
        break;
    case OPTIX_EXCEPTION_CODE_UNSUPPORTED_PRIMITIVE_TYPE:
        OPTIX_IMPL_PRINTF("  primitive type is not enabled in the pipeline\n");
        break;
    case OPTIX_EXCEPTION_CODE_BUILTIN_IS_MISMATCH:
        OPTIX_IMPL_PRINTF("  built-in intersection program does not fit the structure\n");
        break;
    case OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_0:
    case OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_1:
    case OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_2:
        OPTIX_IMPL_PRINTF("  argument %d out of range\n",
                          OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_0 - code);
        break;
    case OPTIX_EXCEPTION_CODE_UNSUPPORTED_DATA_ACCESS:
        OPTIX_IMPL_PRINTF("  structure was built without random access\n");
        break;
    case OPTIX_EXCEPTION_CODE_PAYLOAD_TYPE_MISMATCH:
        OPTIX_IMPL_PRINTF("  payload type of the program is not that of the trace\n");
        break;
    default:
        break;
    }
    if (line)
        OPTIX_IMPL_PRINTF("  at %s\n", line);
}

} // namespace optix_impl

#undef OPTIX_IMPL_PRINTF

#endif
