// SPDX-License-Identifier: Apache-2.0
// A path tracer over moving bodies. Closest-hit programs do the whole bounce: the record names a
// callable that scatters, and a shadow ray finds the sun. The payload is the address of the path.
#include "rigid_bodies.h"
#include "tools.h"

extern "C" {
__constant__ BodyParams params;
}

DEVICE BodyPath* path() {
    return reinterpret_cast<BodyPath*>(static_cast<unsigned long long>(optixGetPayload_1()) << 32 |
                                       optixGetPayload_0());
}
DEVICE bool sunReaches(float3 from) {
    unsigned lit = 0, unused = 0;
    optixTrace(params.world, from, params.sun, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(1),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, lit, unused);
    return lit != 0;
}

// Each scatters `p` at a surface with the normal and record of the hit; the result is the share of
// the sun's light that goes towards the eye.
extern "C" __device__ float3 __direct_callable__matt(BodyPath& p, float3 normal,
                                                     const BodyRecord& r) {
    const float u = nextFloat(p.random), v = nextFloat(p.random);
    p.direction = cosineDirection(normal, u, v);
    p.weight *= r.color;
    return r.color * fmaxf(dot(normal, params.sun), 0.0f);
}
extern "C" __device__ float3 __direct_callable__metal(BodyPath& p, float3 normal,
                                                      const BodyRecord& r) {
    const float u = nextFloat(p.random), v = nextFloat(p.random);
    const float3 mirrored = reflect(p.direction, normal);
    const float glint =
        powf(fmaxf(dot(mirrored, params.sun), 0.0f), 2.0f / (r.roughness * r.roughness));
    p.direction = normalize(mirrored + cosineDirection(normal, u, v) * r.roughness);
    p.weight *= r.color;
    return r.color * (glint / r.roughness);
}
extern "C" __device__ float3 __direct_callable__plastic(BodyPath& p, float3 normal,
                                                        const BodyRecord& r) {
    const float edge = 1.0f + dot(p.direction, normal), squared = edge * edge;
    const float share = 0.04f + 0.96f * squared * squared * edge;
    if (nextFloat(p.random) < share) {
        p.direction = reflect(p.direction, normal);
        return vec(0.0f);
    }
    const float u = nextFloat(p.random), v = nextFloat(p.random);
    p.direction = cosineDirection(normal, u, v);
    p.weight *= r.color;
    return r.color * fmaxf(dot(normal, params.sun), 0.0f);
}
extern "C" __device__ float3 __direct_callable__glass(BodyPath& p, float3 normal,
                                                      const BodyRecord& r) {
    const float ratio = p.isEntry ? 1.0f / 1.45f : 1.45f;
    const float cosine = -dot(p.direction, normal);
    const float squared = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
    const float edge = 1.0f - cosine, share = 0.035f + 0.965f * edge * edge * edge * edge * edge;
    if (squared <= 0.0f || nextFloat(p.random) < share) {
        p.direction = reflect(p.direction, normal);
    } else {
        p.direction = normalize(p.direction * ratio + normal * (ratio * cosine - sqrtf(squared)));
        p.weight *= r.color;
    }
    return vec(0.0f);
}

extern "C" __global__ void __closesthit__bounce() {
    const auto* r = reinterpret_cast<const BodyRecord*>(optixGetSbtDataPointer());
    BodyPath* const p = path();
    const float3 local = r->mesh.normal(optixGetPrimitiveIndex());
    const float3 normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    p->origin = rayPoint();
    p->isEntry = optixIsTriangleFrontFaceHit();
    const float3 before = p->weight;
    const float3 share =
        optixDirectCall<float3, BodyPath&, float3, const BodyRecord&>(r->material, *p, normal, *r);
    if (maxComponent(share) > 0.0f && sunReaches(p->origin))
        p->light += before * share * vec(2.3f, 2.1f, 1.7f);
}
extern "C" __global__ void __miss__sky() {
    BodyPath* const p = path();
    p->light += p->weight * blueSky(optixGetWorldRayDirection()) * 0.8f;
    p->isOver = 1;
}
extern "C" __global__ void __miss__lit() {
    optixSetPayload_0(1);
}

extern "C" __global__ void __raygen__bodies() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    BodyPath p;
    p.random = hashPcg(pixel);
    p.light = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(p.random)) / size.x;
        const float y = (index.y + nextFloat(p.random)) / size.y;
        p.origin = params.camera.eye;
        p.direction = cameraDirection(params.camera, x, y);
        p.weight = vec(1.0f);
        p.isOver = 0;
        for (unsigned bounce = 0; bounce <= params.bounces && !p.isOver; ++bounce) {
            const auto address = reinterpret_cast<unsigned long long>(&p);
            unsigned low = static_cast<unsigned>(address),
                     high = static_cast<unsigned>(address >> 32);
            optixTrace(params.world, p.origin, p.direction, 1e-3f, 1e16f, 0.0f,
                       OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, low, high);
        }
    }
    params.image[pixel] = withWeight(p.light / float(params.samples), 1.0f);
}
