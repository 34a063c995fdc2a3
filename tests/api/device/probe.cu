// SPDX-License-Identifier: Apache-2.0
// Programs of every kind that store the values they can query. See probe.h.
#include <optix.h>

#include "probe.h"

extern "C" {
__constant__ ProbeParams params;
}

static __forceinline__ __device__ void put(float* to, float3 v) {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

static __forceinline__ __device__ const ProbeData& data() {
    return *reinterpret_cast<const ProbeData*>(optixGetSbtDataPointer());
}

static __forceinline__ __device__ ProbeResult& result() {
    return params.results[optixGetLaunchIndex().x];
}

// For intersection, any-hit, closest-hit and miss programs.
static __forceinline__ __device__ void seeRay(ProbeSeen& s) {
    s.tmin = optixGetRayTmin();
    s.tmax = optixGetRayTmax();
    s.time = optixGetRayTime();
    s.rayFlags = optixGetRayFlags();
    s.mask = optixGetRayVisibilityMask();
    put(s.worldOrigin, optixGetWorldRayOrigin());
    put(s.worldDirection, optixGetWorldRayDirection());
    s.sbtValue = data().value;
    s.launchIndex = optixGetLaunchIndex().x;
}

// For intersection, any-hit and closest-hit programs.
static __forceinline__ __device__ void seePrimitive(ProbeSeen& s) {
    s.primitive = optixGetPrimitiveIndex();
    s.sbtGasIndex = optixGetSbtGASIndex();
    s.instanceId = optixGetInstanceId();
    s.instanceIndex = optixGetInstanceIndex();
    s.gas = optixGetGASTraversableHandle();
    s.transformCount = optixGetTransformListSize();
    optixGetObjectToWorldTransformMatrix(s.objectToWorld);
    optixGetWorldToObjectTransformMatrix(s.worldToObject);
    const float3 p = make_float3(1.0f, 2.0f, 3.0f);
    put(s.worldPoint, optixTransformPointFromObjectToWorldSpace(p));
    put(s.worldVector, optixTransformVectorFromObjectToWorldSpace(p));
    put(s.worldNormal, optixTransformNormalFromObjectToWorldSpace(p));
    put(s.objectPoint, optixTransformPointFromWorldToObjectSpace(p));
    if (s.transformCount == 0)
        return;
    const OptixTraversableHandle first = optixGetTransformListHandle(0);
    s.transformType = optixGetTransformTypeFromHandle(first);
    s.transformId = optixGetInstanceIdFromHandle(first);
    s.transformChild = optixGetInstanceChildFromHandle(first);
    const float4* matrix = optixGetInstanceTransformFromHandle(first);
    const float4* inverse = optixGetInstanceInverseTransformFromHandle(first);
    for (int i = 0; i < 3; ++i) {
        s.instanceMatrix[i * 4 + 0] = matrix[i].x;
        s.instanceMatrix[i * 4 + 1] = matrix[i].y;
        s.instanceMatrix[i * 4 + 2] = matrix[i].z;
        s.instanceMatrix[i * 4 + 3] = matrix[i].w;
        s.instanceInverse[i * 4 + 0] = inverse[i].x;
        s.instanceInverse[i * 4 + 1] = inverse[i].y;
        s.instanceInverse[i * 4 + 2] = inverse[i].z;
        s.instanceInverse[i * 4 + 3] = inverse[i].w;
    }
}

// For intersection and any-hit programs.
static __forceinline__ __device__ void seeObjectRay(ProbeSeen& s) {
    put(s.objectOrigin, optixGetObjectRayOrigin());
    put(s.objectDirection, optixGetObjectRayDirection());
}

// For any-hit and closest-hit programs.
static __forceinline__ __device__ void seeHit(ProbeSeen& s) {
    s.hitKind = optixGetHitKind();
    s.primitiveType = optixGetPrimitiveType();
    s.isTriangle = optixIsTriangleHit();
    s.isFront = optixIsFrontFaceHit();
    s.isBack = optixIsBackFaceHit();
    s.isTriangleFront = optixIsTriangleFrontFaceHit();
    s.isTriangleBack = optixIsTriangleBackFaceHit();
    s.attributes[0] = optixGetAttribute_0();
    s.attributes[1] = optixGetAttribute_1();
    if (s.isTriangle) {
        const float2 b = optixGetTriangleBarycentrics();
        s.barycentrics[0] = b.x;
        s.barycentrics[1] = b.y;
    }
}

extern "C" __global__ void __raygen__probe() {
    const unsigned i = optixGetLaunchIndex().x;
    const ProbeRay& ray = params.rays[i];
    unsigned p0 = 100 + i, p1 = 200, p2 = 300, p3 = 400;
    optixTrace(ray.handle, make_float3(ray.origin[0], ray.origin[1], ray.origin[2]),
               make_float3(ray.direction[0], ray.direction[1], ray.direction[2]), ray.tmin, ray.tmax,
               ray.time, ray.mask, ray.flags, ray.sbtOffset, ray.sbtStride, ray.missIndex, p0, p1,
               p2, p3);
    ProbeResult& r = params.results[i];
    r.payload[0] = p0;
    r.payload[1] = p1;
    r.payload[2] = p2;
    r.payload[3] = p3;
}

extern "C" __global__ void __miss__probe() {
    ProbeResult& r = result();
    ++r.misses;
    seeRay(r.miss);
    optixSetPayload_3(optixGetPayload_3() + 1);
}

extern "C" __global__ void __closesthit__probe() {
    ProbeResult& r = result();
    ++r.closestHits;
    seeRay(r.closestHit);
    seePrimitive(r.closestHit);
    seeHit(r.closestHit);
    optixSetPayload_2(optixGetPayload_2() + 1);
}

extern "C" __global__ void __anyhit__probe() {
    ProbeResult& r = result();
    const unsigned run = r.anyHits++;
    optixSetPayload_1(optixGetPayload_1() + 1);
    if (run < kProbeRuns) {
        ProbeSeen& s = r.anyHit[run];
        seeRay(s);
        seePrimitive(s);
        seeObjectRay(s);
        seeHit(s);
    }
    const unsigned rule = data().rule;
    if (rule == kProbeIgnore || (rule == kProbeIgnoreOdd && (optixGetPrimitiveIndex() & 1) != 0))
        optixIgnoreIntersection();
    if (rule == kProbeTerminate)
        optixTerminateRay();
}

// A sphere in object space; hit kind 1 where the ray enters, 2 where it leaves.
extern "C" __global__ void __intersection__probe() {
    ProbeResult& r = result();
    const unsigned run = r.intersections++;
    if (run < kProbeRuns) {
        ProbeSeen& s = r.intersection[run];
        seeRay(s);
        seePrimitive(s);
        seeObjectRay(s);
    }
    const ProbeData& d = data();
    const float* sphere = d.spheres + 4 * (optixGetPrimitiveIndex() - d.primitiveOffset);
    const float3 o = optixGetObjectRayOrigin();
    const float3 dir = optixGetObjectRayDirection();
    const float x = o.x - sphere[0], y = o.y - sphere[1], z = o.z - sphere[2];
    const float a = dir.x * dir.x + dir.y * dir.y + dir.z * dir.z;
    const float b = x * dir.x + y * dir.y + z * dir.z;
    const float c = x * x + y * y + z * z - sphere[3] * sphere[3];
    const float root = b * b - a * c;
    if (root < 0.0f)
        return;
    const float h = sqrtf(root);
    ++r.reports;
    if (optixReportIntersection((-b - h) / a, 1, 11, 12)) {
        ++r.accepted;
        if (run < kProbeRuns)
            r.intersection[run].tmax = optixGetRayTmax(); // now the accepted distance
    }
    if (d.reportBoth) {
        ++r.reports;
        if (optixReportIntersection((-b + h) / a, 2, 21, 22))
            ++r.accepted;
    }
    optixSetPayload_0(optixGetPayload_0() + 1000);
}
