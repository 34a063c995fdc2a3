// SPDX-License-Identifier: Apache-2.0
// One ray for each launch index through moving objects; hit programs store all values they can
// query.
#include "motion.h"

#include "optix.h"

extern "C" __constant__ MotionParams params;

static __forceinline__ __device__ MotionSeen& seen() {
    return params.seen[optixGetLaunchIndex().x];
}

static __forceinline__ __device__ void put(float* to, float3 v) {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

extern "C" __global__ void __raygen__motion() {
    const MotionRay& ray = params.rays[optixGetLaunchIndex().x];
    unsigned hit = 2;
    optixTrace(params.handle, make_float3(ray.origin[0], ray.origin[1], ray.origin[2]),
               make_float3(ray.direction[0], ray.direction[1], ray.direction[2]), 0.0f, 1e16f,
               ray.time, OptixVisibilityMask(255), ray.rayFlags, params.sbtIndex, 0, 0, hit);
    seen().hit = hit;
}

extern "C" __global__ void __miss__motion() {
    optixSetPayload_0(0);
    seen().rayTime = optixGetRayTime();
}

extern "C" __global__ void __anyhit__motion() {
    MotionSeen& s = seen();
    ++s.anyHits;
    put(s.object, optixGetObjectRayOrigin());
    put(s.object + 3, optixGetObjectRayDirection());
    s.rayTime = optixGetRayTime();
}

static __forceinline__ __device__ void describeTransforms(MotionSeen& s) {
    s.transforms = optixGetTransformListSize();
    s.motionChild = 0;
    for (unsigned i = 0; i < s.transforms && i < 8; ++i) {
        const OptixTraversableHandle handle = optixGetTransformListHandle(i);
        s.types[i] = optixGetTransformTypeFromHandle(handle);
        if (const OptixMatrixMotionTransform* m = optixGetMatrixMotionTransformFromHandle(handle)) {
            s.motionChild = m->child;
            s.motionKeys = m->motionOptions.numKeys;
            if (params.dump)
                optix_impl::optixDumpMotionMatrixTransformFromHandle(handle);
        }
        if (const OptixSRTMotionTransform* m = optixGetSRTMotionTransformFromHandle(handle)) {
            s.motionChild = m->child;
            s.motionKeys = m->motionOptions.numKeys;
            if (params.dump)
                optix_impl::optixDumpSrtMatrixTransformFromHandle(handle);
        }
    }
}

extern "C" __global__ void __closesthit__motion() {
    MotionSeen& s = seen();
    optixSetPayload_0(1);
    s.primitive = optixGetPrimitiveIndex();
    s.instanceId = optixGetInstanceId();
    s.t = optixGetRayTmax();
    s.hitTime = optixGetRayTime();
    describeTransforms(s);
    const float3 origin = optixTransformPointFromWorldToObjectSpace(optixGetWorldRayOrigin());
    put(s.computed, origin);
    put(s.computed + 3, optixTransformVectorFromWorldToObjectSpace(optixGetWorldRayDirection()));
    put(s.back, optixTransformPointFromObjectToWorldSpace(origin));
    put(s.normal, optixTransformNormalFromObjectToWorldSpace(make_float3(0, 0, 1)));
    optixGetObjectToWorldTransformMatrix(s.toWorld);
    optixGetWorldToObjectTransformMatrix(s.toObject);
    s.gas = optixGetGASTraversableHandle();
    s.begin = optixGetGASMotionTimeBegin(s.gas);
    s.end = optixGetGASMotionTimeEnd(s.gas);
    s.steps = optixGetGASMotionStepCount(s.gas);
    float3 corners[3];
    optixGetTriangleVertexData(s.gas, s.primitive, optixGetSbtGASIndex(),
                               params.rays[optixGetLaunchIndex().x].time, corners);
    for (int i = 0; i < 3; ++i)
        put(s.vertices + 3 * i, corners[i]);
}

// The box of the primitive at the ray's time, met where the ray enters it.
extern "C" __global__ void __intersection__motion() {
    const unsigned primitive = optixGetPrimitiveIndex();
    const float last = float(params.boxKeys - 1);
    float place = (optixGetRayTime() - params.boxBegin) * last / (params.boxEnd - params.boxBegin);
    place = fminf(fmaxf(place, 0.0f), last);
    const unsigned key = place < last ? unsigned(place) : params.boxKeys - 2;
    const float* a = params.boxes + 6 * (key * params.boxCount + primitive);
    const float* b = a + 6 * params.boxCount;
    const float3 o = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    const float org[3] = {o.x, o.y, o.z}, dir[3] = {d.x, d.y, d.z};
    float enter = optixGetRayTmin(), leave = optixGetRayTmax();
    for (int i = 0; i < 3; ++i) {
        const float f = place - float(key);
        const float low = a[i] * (1.0f - f) + b[i] * f, high = a[3 + i] * (1.0f - f) + b[3 + i] * f;
        const float t0 = (low - org[i]) / dir[i], t1 = (high - org[i]) / dir[i];
        enter = fmaxf(enter, fminf(t0, t1));
        leave = fminf(leave, fmaxf(t0, t1));
    }
    ++seen().anyHits;
    if (enter <= leave)
        optixReportIntersection(enter, 0);
}
