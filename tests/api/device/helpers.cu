// SPDX-License-Identifier: Apache-2.0
// The helper functions that the public headers define above the intrinsics: transforms of points,
// vectors and normals, matrices, and the functions that print transforms.
#include <optix.h>

#include "helpers.h"

extern "C" {
__constant__ HelperParams params;
}

static __forceinline__ __device__ void store(float* to, float3 value) {
    to[0] = value.x;
    to[1] = value.y;
    to[2] = value.z;
}
static __forceinline__ __device__ void store(float* to, float4 value) {
    to[0] = value.x;
    to[1] = value.y;
    to[2] = value.z;
    to[3] = value.w;
}

extern "C" __global__ void __raygen__helpers() {
    // From behind: the triangle faces the other way.
    optixTrace(params.handle, make_float3(0.0f, 0.0f, -9.0f), make_float3(0.0f, 0.0f, 1.0f), 0.0f,
               100.0f, 0.0f, 255, 0, 0, 0, 0);
}

extern "C" __global__ void __miss__helpers() {}

extern "C" __global__ void __closesthit__helpers() {
    HelperResult& out = *params.results;
    ++out.hits;
    out.hitKind = optixGetHitKind();
    out.typeOfNothing = unsigned(optixGetTransformTypeFromHandle(0));
    const float3 point = make_float3(1.0f, 2.0f, 3.0f);
    store(out.point, optixTransformPointFromObjectToWorldSpace(point));
    store(out.vector, optixTransformVectorFromObjectToWorldSpace(point));
    const float3 normal = optixTransformNormalFromObjectToWorldSpace(point);
    store(out.normal, normal);
    store(out.back, optixTransformNormalFromWorldToObjectSpace(normal));

    float4 m0, m1, m2;
    optix_impl::optixGetObjectToWorldTransformMatrix(m0, m1, m2);
    store(out.byMatrix, optix_impl::optixTransformPoint(m0, m1, m2, point));
    store(out.byMatrix + 3, optix_impl::optixTransformVector(m0, m1, m2, point));
    optix_impl::optixGetWorldToObjectTransformMatrix(m0, m1, m2);
    store(out.byMatrix + 6, optix_impl::optixTransformNormal(m0, m1, m2, point));
    optix_impl::optixInvertMatrix(m0, m1, m2);
    store(out.inverse, m0);
    store(out.inverse + 4, m1);
    store(out.inverse + 8, m2);
    const float4 row = make_float4(1.0f, 2.0f, 3.0f, 4.0f);
    store(out.product, optix_impl::optixMultiplyRowMatrix(row, m0, m1, m2));
    store(out.sum, optix_impl::optixAddFloat4(optix_impl::optixMulFloat4(row, 2.0f), row));
    const uint4 words = optix_impl::optixLdg(reinterpret_cast<unsigned long long>(params.aligned));
    out.ldg[0] = words.x;
    out.ldg[1] = words.y;
    out.ldg[2] = words.z;
    out.ldg[3] = words.w;
    // Any value, but the call must work.
    out.undefined = optixUndefinedValue() & 1u;

    for (unsigned i = 0; i < optixGetTransformListSize(); ++i) {
        const OptixTraversableHandle handle = optixGetTransformListHandle(i);
        if (const OptixStaticTransform* transform = optixGetStaticTransformFromHandle(handle))
            if (optixGetTransformTypeFromHandle(handle) == OPTIX_TRANSFORM_TYPE_STATIC_TRANSFORM)
                out.staticChild = transform->pad[0];
    }
    if (params.dump)
        optix_impl::optixDumpTransformList();
}
