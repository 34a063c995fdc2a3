// SPDX-License-Identifier: Apache-2.0
// Device programs of the differential suite: trace the ray of the launch index and store its hit.
// With DIFFERENTIAL_CURVES or DIFFERENTIAL_SPHERES also programs for these.
#include "programs.h"

#include "optix76/optix.h"

using namespace differential;

extern "C" {
__constant__ Params params;
}

#define DEVICE static __forceinline__ __device__

DEVICE Seen& seen() {
    return params.seen[optixGetLaunchIndex().x];
}
DEVICE const RecordData& record() {
    return *reinterpret_cast<const RecordData*>(optixGetSbtDataPointer());
}
DEVICE void put(float* to, float3 v) {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

DEVICE void traceRay(const TestRay& r, unsigned& p0, unsigned& p1) {
    optixTrace(r.handle, make_float3(r.origin[0], r.origin[1], r.origin[2]),
               make_float3(r.direction[0], r.direction[1], r.direction[2]), r.tmin, r.tmax, r.time,
               r.mask, r.flags, r.sbtOffset, r.sbtStride, r.missIndex, p0, p1);
}

extern "C" __global__ void __raygen__trace() {
    const unsigned i = optixGetLaunchIndex().x;
    unsigned p0 = i, p1 = 7;
    traceRay(params.rays[i], p0, p1);
    seen().payload[0] = p0;
    seen().payload[1] = p1;
}

// Traces and then throws; the flags of the rays decide in which program.
extern "C" __global__ void __raygen__throw() {
    const unsigned i = optixGetLaunchIndex().x;
    unsigned p0 = i, p1 = 7;
    traceRay(params.rays[i], p0, p1);
    // Codes have to be constants.
    if (i % 3 == 0)
        optixThrowException(123, 11 + i, 22 + i);
    if (i % 7 == 0)
        optixThrowException(0, i);
    seen().payload[0] = p0;
    seen().payload[1] = p1;
}

extern "C" __global__ void __raygen__callables() {
    const unsigned i = optixGetLaunchIndex().x;
    Seen& s = seen();
    s.outcome = kHit;
    s.payload[0] = optixDirectCall<unsigned, unsigned, float>(i % 2, i, 0.5f * float(i));
    s.payload[1] = optixContinuationCall<unsigned, unsigned, float>(i % 2, i, 0.25f * float(i));
}
extern "C" __device__ unsigned __direct_callable__first(unsigned a, float b) {
    return a * 3 + unsigned(b) + record().value;
}
extern "C" __device__ unsigned __direct_callable__second(unsigned a, float b) {
    return a * 5 + __float_as_uint(b) + record().value;
}
extern "C" __device__ unsigned __continuation_callable__first(unsigned a, float b) {
    return a * 7 + unsigned(b) + record().value;
}
extern "C" __device__ unsigned __continuation_callable__second(unsigned a, float b) {
    return a * 11 + __float_as_uint(b) + record().value;
}

extern "C" __global__ void __exception__seen() {
    Seen& s = seen();
    s.outcome = kException;
    s.exception = optixGetExceptionCode();
    if (s.exception >= 0) {
        s.exceptionDetails[0] = optixGetExceptionDetail_0();
        s.exceptionDetails[1] = optixGetExceptionDetail_1();
    }
}

extern "C" __global__ void __miss__seen() {
    Seen& s = seen();
    s.outcome = kMiss;
    s.t = optixGetRayTmax();
    s.value = record().value;
    s.rayFlags = optixGetRayFlags();
    s.mask = optixGetRayVisibilityMask();
    s.time = optixGetRayTime();
    optixSetPayload_1(optixGetPayload_1() + 1);
}

DEVICE void lookAround(Seen& s) {
    s.outcome = kHit;
    s.t = optixGetRayTmax();
    s.value = record().value;
    s.primitive = optixGetPrimitiveIndex();
    s.sbtGasIndex = optixGetSbtGASIndex();
    s.instanceIndex = optixGetInstanceIndex();
    s.instanceId = optixGetInstanceId();
    s.hitKind = optixGetHitKind();
    s.primitiveType = optixGetPrimitiveType();
    s.sides = unsigned(optixIsFrontFaceHit()) | unsigned(optixIsBackFaceHit()) << 1 |
              unsigned(optixIsTriangleHit()) << 2 | unsigned(optixIsTriangleFrontFaceHit()) << 3 |
              unsigned(optixIsTriangleBackFaceHit()) << 4;
    s.rayFlags = optixGetRayFlags();
    s.mask = optixGetRayVisibilityMask();
    s.time = optixGetRayTime();
    const unsigned count = optixGetTransformListSize();
    s.transforms = count;
    for (unsigned i = 0; i < count && i < 6; ++i)
        s.transforms |= unsigned(optixGetTransformTypeFromHandle(optixGetTransformListHandle(i)))
                        << (4 + 4 * i);
    optixGetObjectToWorldTransformMatrix(s.objectToWorld);
    optixGetWorldToObjectTransformMatrix(s.worldToObject);
    const float3 p = make_float3(1.0f, 2.0f, 3.0f);
    put(s.worldPoint, optixTransformPointFromObjectToWorldSpace(p));
    put(s.worldNormal, optixTransformNormalFromObjectToWorldSpace(p));
}

DEVICE void keepAttributes(Seen& s) {
    s.attributes[0] = optixGetAttribute_0();
    s.attributes[1] = optixGetAttribute_1();
}

extern "C" __global__ void __closesthit__seen() {
    Seen& s = seen();
    lookAround(s);
    keepAttributes(s);
    optixSetPayload_0(optixGetPayload_0() + 1000);
}

extern "C" __global__ void __closesthit__triangle() {
    Seen& s = seen();
    lookAround(s);
    keepAttributes(s);
    float3 vertices[3];
    optixGetTriangleVertexData(optixGetGASTraversableHandle(), s.primitive, s.sbtGasIndex, s.time,
                               vertices);
    for (int i = 0; i < 3; ++i)
        put(s.geometry + 3 * i, vertices[i]);
    optixSetPayload_0(optixGetPayload_0() + 1000);
}

// Traces the same ray again, for ever: the trace depth ends it.
extern "C" __global__ void __closesthit__again() {
    unsigned p0 = 0, p1 = 0;
    traceRay(params.rays[optixGetLaunchIndex().x], p0, p1);
    optixSetPayload_0(optixGetPayload_0() + 1);
}

extern "C" __global__ void __closesthit__throw() {
    optixThrowException(1073741823, optixGetPrimitiveIndex()); // the largest
}

extern "C" __global__ void __anyhit__rule() {
    const unsigned rule = record().rule;
    if (rule == kIgnoreAll || (rule == kIgnoreOdd && optixGetPrimitiveIndex() % 2 == 1))
        optixIgnoreIntersection();
    if (rule == kIgnorePattern) {
        const float2 b = optixGetTriangleBarycentrics();
        if ((int(b.x * 8.0f) + int(b.y * 8.0f)) % 2 == 1)
            optixIgnoreIntersection();
    }
    if (rule == kTerminate)
        optixTerminateRay();
}

// A sphere, both crossings; the hit kind distinguishes them.
extern "C" __global__ void __intersection__sphere() {
    const float* sphere = record().spheres + 4 * optixGetPrimitiveIndex();
    const float3 o = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    const float x = o.x - sphere[0], y = o.y - sphere[1], z = o.z - sphere[2];
    const float a = d.x * d.x + d.y * d.y + d.z * d.z, b = x * d.x + y * d.y + z * d.z;
    const float c = x * x + y * y + z * z - sphere[3] * sphere[3];
    const float root = b * b - a * c;
    if (root < 0.0f)
        return;
    const float h = sqrtf(root);
    if (!optixReportIntersection((-b - h) / a, 5, 50, __float_as_uint(d.x)))
        optixReportIntersection((-b + h) / a, 6, 60, __float_as_uint(d.y));
}

#if defined(DIFFERENTIAL_CURVES) || defined(DIFFERENTIAL_SPHERES)
template <int kCount>
DEVICE void keep(Seen& s, const float4 (&points)[kCount]) {
    for (int i = 0; i < kCount; ++i) {
        s.geometry[4 * i] = points[i].x;
        s.geometry[4 * i + 1] = points[i].y;
        s.geometry[4 * i + 2] = points[i].z;
        s.geometry[4 * i + 3] = points[i].w;
    }
    optixSetPayload_0(optixGetPayload_0() + 1000);
}
#define SHAPE_ATTRIBUTES
#define SHAPE_PROGRAM(name, getter, count)                                                         \
    extern "C" __global__ void __closesthit__##name() {                                            \
        Seen& s = seen();                                                                          \
        lookAround(s);                                                                             \
        SHAPE_ATTRIBUTES                                                                           \
        float4 points[count];                                                                      \
        getter(optixGetGASTraversableHandle(), s.primitive, s.sbtGasIndex, s.time, points);        \
        keep(s, points);                                                                           \
    }
// For built-in shapes the manual documents only the curve parameter as an attribute.
#ifdef DIFFERENTIAL_CURVES
#undef SHAPE_ATTRIBUTES
#define SHAPE_ATTRIBUTES s.attributes[0] = __float_as_uint(optixGetCurveParameter());
SHAPE_PROGRAM(linear, optixGetLinearCurveVertexData, 2)
SHAPE_PROGRAM(quadratic, optixGetQuadraticBSplineVertexData, 3)
SHAPE_PROGRAM(cubic, optixGetCubicBSplineVertexData, 4)
SHAPE_PROGRAM(catmull_rom, optixGetCatmullRomVertexData, 4)
#else
SHAPE_PROGRAM(sphere, optixGetSphereData, 1)
#endif
#endif
