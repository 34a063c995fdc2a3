// SPDX-License-Identifier: Apache-2.0
// OptiX device functions, for programs compiled to PTX. Each is one call of an `_optix_*`
// intrinsic, which the library's compiler replaces, or arithmetic on such calls. Read next:
// internal/optix_7_device_impl.h. Source: OptiX API reference 7.4, sections 3.1, 6.2. ../optix76
// includes this file as OptiX 7.6, with the additions between SUNSTONE_OPTIX_API lines.
//
// Program types: RG ray generation, IS intersection, AH any-hit, CH closest-hit, MS miss, EX
// exception, DC direct callable, CC continuation callable. Each function lists the types that may
// call it; a call from another type makes optixModuleCreateFromPTX fail with
// OPTIX_ERROR_INVALID_FUNCTION_USE. GAS: geometry acceleration structure; IAS: instance
// acceleration structure. Matrices are 3x4 and row-major. A payload word has 32 bits.
#ifndef SUNSTONE_OPTIX7_OPTIX_7_DEVICE_H
#define SUNSTONE_OPTIX7_OPTIX_7_DEVICE_H

#if !defined(__CUDACC__) && !defined(__CUDA__)
#error "optix_device.h is for device compilers; host code includes optix_host.h or optix_stubs.h"
#endif
#if !defined(__cplusplus) || (__cplusplus < 201103L && !defined(_MSC_VER))
#error "optix_device.h needs C++11 or later"
#endif

#include "optix_7_types.h"

/* ---- Rays ---- */

/** Traces a ray: finds the closest hit in a traversable and runs its CH program, or the MS program.
    RG CH MS CC.
    handle: root; 0 always misses. rayOrigin, rayDirection: world space, any length but 0, the unit
    of tmin and tmax; a hit at t counts if tmin <= t <= tmax. rayTime: for motion. visibilityMask:
    low 8 bits. rayFlags: OptixRayFlags. SBToffset, SBTstride: the hit record is instance offset +
    GAS record index * SBTstride + SBToffset. missSBTIndex: miss record. payload: 0 to 32 variables
    of type unsigned int, passed in and changed by the programs.
    OptixPipelineLinkOptions::maxTraceDepth limits the number of nested traces.
    [3.1.2.163 to 3.1.2.195] */
template <typename... Payload>
static __forceinline__ __device__ void
optixTrace(OptixTraversableHandle handle, float3 rayOrigin, float3 rayDirection, float tmin,
           float tmax, float rayTime, OptixVisibilityMask visibilityMask, unsigned int rayFlags,
           unsigned int SBToffset, unsigned int SBTstride, unsigned int missSBTIndex,
           Payload&... payload);
/** The same with one of the module's payload types; type must be a constant.
    [3.1.2.196 to 3.1.2.228] */
template <typename... Payload>
static __forceinline__ __device__ void
optixTrace(OptixPayloadTypeID type, OptixTraversableHandle handle, float3 rayOrigin,
           float3 rayDirection, float tmin, float tmax, float rayTime,
           OptixVisibilityMask visibilityMask, unsigned int rayFlags, unsigned int SBToffset,
           unsigned int SBTstride, unsigned int missSBTIndex, Payload&... payload);

/** Origin of the ray as given to optixTrace. IS AH CH MS; in IS and AH object space is cheaper.
 * [3.1.2.98] */
static __forceinline__ __device__ float3 optixGetWorldRayOrigin();
/** Direction of the ray as given to optixTrace. IS AH CH MS. [3.1.2.97] */
static __forceinline__ __device__ float3 optixGetWorldRayDirection();
/** Origin of the ray in the space of the current primitive. IS AH. [3.1.2.45] */
static __forceinline__ __device__ float3 optixGetObjectRayOrigin();
/** Direction of the ray in that space, not normalised: t equals that in world space. IS AH.
    [3.1.2.44] */
static __forceinline__ __device__ float3 optixGetObjectRayDirection();
/** tmin of the ray. IS AH CH MS. [3.1.2.86] */
static __forceinline__ __device__ float optixGetRayTmin();
/** IS, CH: t of the closest accepted hit, or tmax of the ray before the first one. AH: t of the
    current hit. MS: tmax of the ray. [3.1.2.85] */
static __forceinline__ __device__ float optixGetRayTmax();
/** Time of the ray; 0 without motion. IS AH CH MS. [3.1.2.84] */
static __forceinline__ __device__ float optixGetRayTime();
/** OptixRayFlags of the ray. IS AH CH MS. [3.1.2.83] */
static __forceinline__ __device__ unsigned int optixGetRayFlags();
/** Visibility mask of the ray. IS AH CH MS. [3.1.2.87] */
static __forceinline__ __device__ unsigned int optixGetRayVisibilityMask();

/* ---- Payload ---- */

/** Writes a payload word of the current ray; the slot must be below the configured number. IS AH CH
 * MS. [3.1.2.117 to 3.1.2.148] */
static __forceinline__ __device__ void optixSetPayload_0(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_1(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_2(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_3(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_4(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_5(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_6(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_7(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_8(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_9(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_10(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_11(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_12(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_13(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_14(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_15(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_16(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_17(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_18(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_19(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_20(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_21(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_22(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_23(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_24(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_25(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_26(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_27(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_28(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_29(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_30(unsigned int p);
static __forceinline__ __device__ void optixSetPayload_31(unsigned int p);
/** Reads a payload word of the current ray. IS AH CH MS. [3.1.2.47 to 3.1.2.78] */
static __forceinline__ __device__ unsigned int optixGetPayload_0();
static __forceinline__ __device__ unsigned int optixGetPayload_1();
static __forceinline__ __device__ unsigned int optixGetPayload_2();
static __forceinline__ __device__ unsigned int optixGetPayload_3();
static __forceinline__ __device__ unsigned int optixGetPayload_4();
static __forceinline__ __device__ unsigned int optixGetPayload_5();
static __forceinline__ __device__ unsigned int optixGetPayload_6();
static __forceinline__ __device__ unsigned int optixGetPayload_7();
static __forceinline__ __device__ unsigned int optixGetPayload_8();
static __forceinline__ __device__ unsigned int optixGetPayload_9();
static __forceinline__ __device__ unsigned int optixGetPayload_10();
static __forceinline__ __device__ unsigned int optixGetPayload_11();
static __forceinline__ __device__ unsigned int optixGetPayload_12();
static __forceinline__ __device__ unsigned int optixGetPayload_13();
static __forceinline__ __device__ unsigned int optixGetPayload_14();
static __forceinline__ __device__ unsigned int optixGetPayload_15();
static __forceinline__ __device__ unsigned int optixGetPayload_16();
static __forceinline__ __device__ unsigned int optixGetPayload_17();
static __forceinline__ __device__ unsigned int optixGetPayload_18();
static __forceinline__ __device__ unsigned int optixGetPayload_19();
static __forceinline__ __device__ unsigned int optixGetPayload_20();
static __forceinline__ __device__ unsigned int optixGetPayload_21();
static __forceinline__ __device__ unsigned int optixGetPayload_22();
static __forceinline__ __device__ unsigned int optixGetPayload_23();
static __forceinline__ __device__ unsigned int optixGetPayload_24();
static __forceinline__ __device__ unsigned int optixGetPayload_25();
static __forceinline__ __device__ unsigned int optixGetPayload_26();
static __forceinline__ __device__ unsigned int optixGetPayload_27();
static __forceinline__ __device__ unsigned int optixGetPayload_28();
static __forceinline__ __device__ unsigned int optixGetPayload_29();
static __forceinline__ __device__ unsigned int optixGetPayload_30();
static __forceinline__ __device__ unsigned int optixGetPayload_31();
/** Declares the payload types (OptixPayloadTypeID, or-ed) that the program supports; 0 or no call:
    all. At most one call, first and unconditional, with a constant. IS AH CH MS. [3.1.2.149] */
static __forceinline__ __device__ void optixSetPayloadTypes(unsigned int typeMask);
/** An arbitrary value that costs no computation. Any program. [3.1.2.235] */
static __forceinline__ __device__ unsigned int optixUndefinedValue();

/* ---- Hits ---- */

/** Reports a hit of the current custom primitive with 0 to 8 attribute words. False: hitT is
    outside optixGetRayTmin to optixGetRayTmax, or AH ignored the hit; true: accepted. Does not
    return if AH ended the ray. hitKind: 0 to 127. IS. [3.1.2.108 to 3.1.2.116] */
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind);
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind,
                                                               unsigned int a0);
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind,
                                                               unsigned int a0, unsigned int a1);
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind,
                                                               unsigned int a0, unsigned int a1,
                                                               unsigned int a2);
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind,
                                                               unsigned int a0, unsigned int a1,
                                                               unsigned int a2, unsigned int a3);
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind,
                                                               unsigned int a0, unsigned int a1,
                                                               unsigned int a2, unsigned int a3,
                                                               unsigned int a4);
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind,
                                                               unsigned int a0, unsigned int a1,
                                                               unsigned int a2, unsigned int a3,
                                                               unsigned int a4, unsigned int a5);
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind,
                                                               unsigned int a0, unsigned int a1,
                                                               unsigned int a2, unsigned int a3,
                                                               unsigned int a4, unsigned int a5,
                                                               unsigned int a6);
static __forceinline__ __device__ bool optixReportIntersection(float hitT, unsigned int hitKind,
                                                               unsigned int a0, unsigned int a1,
                                                               unsigned int a2, unsigned int a3,
                                                               unsigned int a4, unsigned int a5,
                                                               unsigned int a6, unsigned int a7);
/** Attribute words of the hit. AH CH. [3.1.2.3 to 3.1.2.10] */
static __forceinline__ __device__ unsigned int optixGetAttribute_0();
static __forceinline__ __device__ unsigned int optixGetAttribute_1();
static __forceinline__ __device__ unsigned int optixGetAttribute_2();
static __forceinline__ __device__ unsigned int optixGetAttribute_3();
static __forceinline__ __device__ unsigned int optixGetAttribute_4();
static __forceinline__ __device__ unsigned int optixGetAttribute_5();
static __forceinline__ __device__ unsigned int optixGetAttribute_6();
static __forceinline__ __device__ unsigned int optixGetAttribute_7();
/** Accepts the hit and ends traversal; CH follows. Does not return. AH. [3.1.2.150] */
static __forceinline__ __device__ void optixTerminateRay();
/** Rejects the hit; traversal continues. Does not return. AH. [3.1.2.100] */
static __forceinline__ __device__ void optixIgnoreIntersection();
/** Index of the primitive in its build input, plus primitiveIndexOffset. IS AH CH. [3.1.2.79] */
static __forceinline__ __device__ unsigned int optixGetPrimitiveIndex();
/** SBT record index of the primitive in its GAS. IS AH CH; EX for an invalid hit SBT index.
 * [3.1.2.89] */
static __forceinline__ __device__ unsigned int optixGetSbtGASIndex();
/** OptixInstance::instanceId of the innermost instance; ~0u without one. IS AH CH. [3.1.2.34] */
static __forceinline__ __device__ unsigned int optixGetInstanceId();
/** Index of the innermost instance in its IAS; 0 without one. IS AH CH. [3.1.2.36] */
static __forceinline__ __device__ unsigned int optixGetInstanceIndex();
/** Hit kind, 8 bits: below 128 as reported by IS, else a built-in primitive, for
 * optixGetPrimitiveType to decode. AH CH. [3.1.2.32] */
static __forceinline__ __device__ unsigned int optixGetHitKind();
/** Primitive type of a hit kind. Any program. [3.1.2.80] */
static __forceinline__ __device__ OptixPrimitiveType optixGetPrimitiveType(unsigned int hitKind);
/** Whether a hit kind stands for a front face. Any program. [3.1.2.103] */
static __forceinline__ __device__ bool optixIsFrontFaceHit(unsigned int hitKind);
/** Whether a hit kind stands for a back face. Any program. [3.1.2.101] */
static __forceinline__ __device__ bool optixIsBackFaceHit(unsigned int hitKind);
/** The same for the current hit. AH CH. [3.1.2.81, 3.1.2.104, 3.1.2.102] */
static __forceinline__ __device__ OptixPrimitiveType optixGetPrimitiveType();
static __forceinline__ __device__ bool optixIsFrontFaceHit();
static __forceinline__ __device__ bool optixIsBackFaceHit();
/** Whether the current hit is on a triangle, on its front side, on its back side. AH CH.
    [3.1.2.105 to 3.1.2.107] */
static __forceinline__ __device__ bool optixIsTriangleHit();
static __forceinline__ __device__ bool optixIsTriangleFrontFaceHit();
static __forceinline__ __device__ bool optixIsTriangleBackFaceHit();
/** Barycentric coordinates of a triangle hit: weights of vertices 1 and 2. AH CH. [3.1.2.95] */
static __forceinline__ __device__ float2 optixGetTriangleBarycentrics();
/** Parameter of a curve hit along its segment, 0 to 1. AH CH. [3.1.2.13] */
static __forceinline__ __device__ float optixGetCurveParameter();

/* ---- Acceleration structures ---- */

/** Handle of an instance, for the FromHandle functions; the IAS must allow random instance access.
 * Any program. [3.1.2.39] */
static __forceinline__ __device__ OptixTraversableHandle
optixGetInstanceTraversableFromIAS(OptixTraversableHandle ias, unsigned int instIdx);
/** Vertices of a triangle in object space at a time (ignored without motion). The GAS must allow
 * random vertex access. primIdx includes the offset. Any program. [3.1.2.96] */
static __forceinline__ __device__ void optixGetTriangleVertexData(OptixTraversableHandle gas,
                                                                  unsigned int primIdx,
                                                                  unsigned int sbtGASIndex,
                                                                  float time, float3 data[3]);
/** Control points of a linear curve segment: position in xyz, radius in w; else as for triangles.
 * [3.1.2.42] */
static __forceinline__ __device__ void optixGetLinearCurveVertexData(OptixTraversableHandle gas,
                                                                     unsigned int primIdx,
                                                                     unsigned int sbtGASIndex,
                                                                     float time, float4 data[2]);
/** Control points of a quadratic B-spline segment: position in xyz, radius in w; else as for
 * triangles. [3.1.2.82] */
static __forceinline__ __device__ void
optixGetQuadraticBSplineVertexData(OptixTraversableHandle gas, unsigned int primIdx,
                                   unsigned int sbtGASIndex, float time, float4 data[3]);
/** Control points of a cubic B-spline segment: position in xyz, radius in w; else as for triangles.
 * [3.1.2.12] */
static __forceinline__ __device__ void optixGetCubicBSplineVertexData(OptixTraversableHandle gas,
                                                                      unsigned int primIdx,
                                                                      unsigned int sbtGASIndex,
                                                                      float time, float4 data[4]);
/** Control points of a Catmull-Rom spline segment: position in xyz, radius in w; else as for
 * triangles. [3.1.2.11] */
static __forceinline__ __device__ void optixGetCatmullRomVertexData(OptixTraversableHandle gas,
                                                                    unsigned int primIdx,
                                                                    unsigned int sbtGASIndex,
                                                                    float time, float4 data[4]);
#if SUNSTONE_OPTIX_API >= 70600
/** Centre in xyz and radius in w of a sphere; else as for triangles. [7.5] */
static __forceinline__ __device__ void optixGetSphereData(OptixTraversableHandle gas,
                                                          unsigned int primIdx,
                                                          unsigned int sbtGASIndex, float time,
                                                          float4 data[1]);
#endif
/** The GAS of the current hit. IS AH CH. [3.1.2.31] */
static __forceinline__ __device__ OptixTraversableHandle optixGetGASTraversableHandle();
/** Motion range and number of keys of a GAS, as built. Any program. [3.1.2.28 to 3.1.2.30] */
static __forceinline__ __device__ float optixGetGASMotionTimeBegin(OptixTraversableHandle gas);
static __forceinline__ __device__ float optixGetGASMotionTimeEnd(OptixTraversableHandle gas);
static __forceinline__ __device__ unsigned int
optixGetGASMotionStepCount(OptixTraversableHandle gas);

/* ---- Transforms ---- */

/** Matrix of all transforms of the current hit at ray time; identity without transforms. The cost
    grows with the list. IS AH CH. [3.1.2.99, 3.1.2.46] */
static __forceinline__ __device__ void optixGetWorldToObjectTransformMatrix(float m[12]);
static __forceinline__ __device__ void optixGetObjectToWorldTransformMatrix(float m[12]);
/** Apply these matrices: to points with, to vectors without translation, to normals by the
    transpose of the inverse; results are not normalised. IS AH CH. [3.1.2.229 to 3.1.2.234] */
static __forceinline__ __device__ float3 optixTransformPointFromWorldToObjectSpace(float3 point);
static __forceinline__ __device__ float3 optixTransformVectorFromWorldToObjectSpace(float3 vec);
static __forceinline__ __device__ float3 optixTransformNormalFromWorldToObjectSpace(float3 normal);
static __forceinline__ __device__ float3 optixTransformPointFromObjectToWorldSpace(float3 point);
static __forceinline__ __device__ float3 optixTransformVectorFromObjectToWorldSpace(float3 vec);
static __forceinline__ __device__ float3 optixTransformNormalFromObjectToWorldSpace(float3 normal);
/** Length of the list of instances and transforms above the current hit. IS AH CH EX. [3.1.2.93] */
static __forceinline__ __device__ unsigned int optixGetTransformListSize();
/** An entry of the list, root first. IS AH CH EX. [3.1.2.92] */
static __forceinline__ __device__ OptixTraversableHandle
optixGetTransformListHandle(unsigned int index);
/** The kind of a handle in the list. Any program. [3.1.2.94] */
static __forceinline__ __device__ OptixTransformType
optixGetTransformTypeFromHandle(OptixTraversableHandle handle);
/** The application's transform behind a handle; null for a handle of another type. Any program.
    [3.1.2.91, 3.1.2.90, 3.1.2.43] */
static __forceinline__ __device__ const OptixStaticTransform*
optixGetStaticTransformFromHandle(OptixTraversableHandle handle);
static __forceinline__ __device__ const OptixSRTMotionTransform*
optixGetSRTMotionTransformFromHandle(OptixTraversableHandle handle);
static __forceinline__ __device__ const OptixMatrixMotionTransform*
optixGetMatrixMotionTransformFromHandle(OptixTraversableHandle handle);
/** instanceId and traversable of an instance handle; 0 for other handles. Any program.
 * [3.1.2.35, 3.1.2.33] */
static __forceinline__ __device__ unsigned int
optixGetInstanceIdFromHandle(OptixTraversableHandle handle);
static __forceinline__ __device__ OptixTraversableHandle
optixGetInstanceChildFromHandle(OptixTraversableHandle handle);
/** The three rows of the object-to-world and world-to-object matrix of an instance handle, 16-byte
 * aligned in global memory; null for other handles. Any program. [3.1.2.38, 3.1.2.37] */
static __forceinline__ __device__ const float4*
optixGetInstanceTransformFromHandle(OptixTraversableHandle handle);
static __forceinline__ __device__ const float4*
optixGetInstanceInverseTransformFromHandle(OptixTraversableHandle handle);

/* ---- Launch and shader binding table ---- */

/** The program's index in the launch, and the size of the launch. Any program.
    [3.1.2.41, 3.1.2.40] */
static __forceinline__ __device__ uint3 optixGetLaunchIndex();
static __forceinline__ __device__ uint3 optixGetLaunchDimensions();
/** Generic address of the data after the header of the running program's record. Any program.
 * [3.1.2.88] */
static __forceinline__ __device__ CUdeviceptr optixGetSbtDataPointer();

/* ---- Callables ---- */

/** Calls the DC program of a callable record. The types must be those of the program; if
    conversions are needed, name the types: optixDirectCall<float, int>(index, x). RG IS AH CH MS DC
    CC. [3.1.2.2] */
template <typename ReturnT, typename... ArgTypes>
static __forceinline__ __device__ ReturnT optixDirectCall(unsigned int sbtIndex, ArgTypes... args);
/** Calls the CC program of a callable record, which may trace rays. RG CH MS CC. [3.1.2.1] */
template <typename ReturnT, typename... ArgTypes>
static __forceinline__ __device__ ReturnT optixContinuationCall(unsigned int sbtIndex,
                                                                ArgTypes... args);

/* ---- Exceptions ---- */

/** Ends the launch index with a user exception: a code from 0 to 2^30 - 1 and up to 8 details,
 * which must not be addresses on the stack. Does not return. Needs OPTIX_EXCEPTION_FLAG_USER. All
 * but EX. [3.1.2.154 to 3.1.2.162] */
static __forceinline__ __device__ void optixThrowException(int exceptionCode);
static __forceinline__ __device__ void optixThrowException(int exceptionCode,
                                                           unsigned int exceptionDetail0);
static __forceinline__ __device__ void optixThrowException(int exceptionCode,
                                                           unsigned int exceptionDetail0,
                                                           unsigned int exceptionDetail1);
static __forceinline__ __device__ void optixThrowException(int exceptionCode,
                                                           unsigned int exceptionDetail0,
                                                           unsigned int exceptionDetail1,
                                                           unsigned int exceptionDetail2);
static __forceinline__ __device__ void
optixThrowException(int exceptionCode, unsigned int exceptionDetail0, unsigned int exceptionDetail1,
                    unsigned int exceptionDetail2, unsigned int exceptionDetail3);
static __forceinline__ __device__ void
optixThrowException(int exceptionCode, unsigned int exceptionDetail0, unsigned int exceptionDetail1,
                    unsigned int exceptionDetail2, unsigned int exceptionDetail3,
                    unsigned int exceptionDetail4);
static __forceinline__ __device__ void
optixThrowException(int exceptionCode, unsigned int exceptionDetail0, unsigned int exceptionDetail1,
                    unsigned int exceptionDetail2, unsigned int exceptionDetail3,
                    unsigned int exceptionDetail4, unsigned int exceptionDetail5);
static __forceinline__ __device__ void
optixThrowException(int exceptionCode, unsigned int exceptionDetail0, unsigned int exceptionDetail1,
                    unsigned int exceptionDetail2, unsigned int exceptionDetail3,
                    unsigned int exceptionDetail4, unsigned int exceptionDetail5,
                    unsigned int exceptionDetail6);
static __forceinline__ __device__ void
optixThrowException(int exceptionCode, unsigned int exceptionDetail0, unsigned int exceptionDetail1,
                    unsigned int exceptionDetail2, unsigned int exceptionDetail3,
                    unsigned int exceptionDetail4, unsigned int exceptionDetail5,
                    unsigned int exceptionDetail6, unsigned int exceptionDetail7);
/** The exception: OptixExceptionCodes, or the code of a user exception. EX. [3.1.2.14] */
static __forceinline__ __device__ int optixGetExceptionCode();
/** Details of a user exception; undefined if it has fewer. EX. [3.1.2.15 to 3.1.2.22] */
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_0();
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_1();
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_2();
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_3();
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_4();
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_5();
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_6();
static __forceinline__ __device__ unsigned int optixGetExceptionDetail_7();
/** Details of the exceptions that name these functions in OptixExceptionCodes; 0 for others. EX.
 * [3.1.2.23 to 3.1.2.27] */
static __forceinline__ __device__ OptixTraversableHandle optixGetExceptionInvalidTraversable();
static __forceinline__ __device__ int optixGetExceptionInvalidSbtOffset();
static __forceinline__ __device__ OptixInvalidRayExceptionDetails optixGetExceptionInvalidRay();
static __forceinline__ __device__ OptixParameterMismatchExceptionDetails
optixGetExceptionParameterMismatch();
/** Source line of the exception as a string, if the PTX has line information and debugLevel is not
 * NONE; else null. EX. [3.1.2.26] */
static __forceinline__ __device__ char* optixGetExceptionLineInfo();

/* ---- Texture footprints ---- */

/** Texels that a lookup of a 2D texture reads, as a bit mask of texel groups; any program.
    tex: texture object. texInfo: bits 28-24 mip levels, 23-20 and 19-16 log2 of tile width and
    height, 9-8 and 7-6 horizontal and vertical address mode, 5 mip filter mode, 4-0 largest
    anisotropy. x, y: texture coordinates. singleMipLevel: set to whether one level holds it all.
    Result: 64 bits of mask (x, y), bit 0 for the group at (8 * tileX, 8 * tileY); z: tileY in bits
    0-11, dx 16-18, dy 19-21, granularity 24-27 (0: as requested); w: tileX in bits 0-11, level
    12-15. The last dx columns and dy rows of the mask stand for groups 8 lower. [3.1.2.151] */
static __forceinline__ __device__ uint4 optixTexFootprint2D(unsigned long long tex,
                                                            unsigned int texInfo, float x, float y,
                                                            unsigned int* singleMipLevel);
/** The same with gradients; coarse: the coarser of two mip levels. [3.1.2.152] */
static __forceinline__ __device__ uint4 optixTexFootprint2DGrad(
    unsigned long long tex, unsigned int texInfo, float x, float y, float dPdx_x, float dPdx_y,
    float dPdy_x, float dPdy_y, bool coarse, unsigned int* singleMipLevel);
/** The same with a level of detail. [3.1.2.153] */
static __forceinline__ __device__ uint4 optixTexFootprint2DLod(unsigned long long tex,
                                                               unsigned int texInfo, float x,
                                                               float y, float level, bool coarse,
                                                               unsigned int* singleMipLevel);

#include "internal/optix_7_device_impl.h"

#endif
