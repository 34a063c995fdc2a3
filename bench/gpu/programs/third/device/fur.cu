// SPDX-License-Identifier: Apache-2.0
// Camera rays and skin; fur_strands.cu has hits of hair, fur_lobes.cu its scattering. Payload: the
// colour; for shadow rays the share that arrives.
#include "fur.h"

extern "C" __global__ void __closesthit__skin() {
    const FurRecord* r = reinterpret_cast<const FurRecord*>(optixGetSbtDataPointer());
    const float3 local = r->mesh.normal(optixGetPrimitiveIndex());
    const float3 normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    float3 light = vec(0.12f);
    for (const FurLight& lamp : params.lights) {
        const float cosine = dot(normal, lamp.direction);
        if (cosine > 0.0f)
            light += lamp.power * (cosine * veilTowards(rayPoint(), lamp.direction) / kPi);
    }
    setFurColor(r->color * light);
}
extern "C" __global__ void __anyhit__solid() {
    optixSetPayload_0(0);
    optixTerminateRay();
}
extern "C" __global__ void __miss__backdrop() {
    const float height = optixGetWorldRayDirection().y;
    setFurColor(lerp(vec(0.25f, 0.27f, 0.3f), vec(0.5f, 0.52f, 0.55f), clamp01(0.5f + height)));
}

extern "C" __global__ void __raygen__groom() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        unsigned r, g, b;
        optixTrace(params.world, params.camera.eye, cameraDirection(params.camera, x, y), 0.0f,
                   1e16f, 0.0f, OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 2, 0, r,
                   g, b);
        sum += vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
