// SPDX-License-Identifier: Apache-2.0
// A path tracer whose loop in ray generation samples materials and the surroundings, and weights
// both by multiple importance sampling. Closest-hit programs read textures and fill a struct.
#include "interior.h"
#include "principled.h"

extern "C" {
__constant__ InteriorParams params;
}

// The axes of a texture on a plane that faces along the largest component of the normal.
DEVICE void textureAxes(float3 normal, float3& s, float3& t) {
    const float x = fabsf(normal.x), y = fabsf(normal.y), z = fabsf(normal.z);
    s = x > y && x > z ? vec(0.0f, 0.0f, 1.0f) : vec(1.0f, 0.0f, 0.0f);
    t = y > x && y > z ? vec(0.0f, 0.0f, 1.0f) : vec(0.0f, 1.0f, 0.0f);
}

extern "C" __global__ void __closesthit__surface() {
    InteriorHit* const hit = reinterpret_cast<InteriorHit*>(
        static_cast<unsigned long long>(optixGetPayload_1()) << 32 | optixGetPayload_0());
    const auto* r = reinterpret_cast<const InteriorRecord*>(optixGetSbtDataPointer());
    hit->distance = optixGetRayTmax();
    hit->flat = hit->normal = towardsRay(normalize(r->mesh.normal(optixGetPrimitiveIndex())));
    hit->material = r->material;
    float3 s, t;
    textureAxes(hit->flat, s, t);
    const float3 at = rayPoint() * r->texturesPerUnit;
    if (r->albedo) {
        const float4 texel = tex2D<float4>(r->albedo, dot(at, s), dot(at, t));
        hit->material.base *= vec(texel.x, texel.y, texel.z);
        hit->material.roughness *= 0.6f + 0.4f * texel.w;
    }
    if (r->bumps) {
        const float4 bump = tex2D<float4>(r->bumps, dot(at, s), dot(at, t));
        hit->normal = normalize(hit->flat + s * (bump.x - 0.5f) + t * (bump.y - 0.5f));
    }
}
extern "C" __global__ void __miss__outside() {
    reinterpret_cast<InteriorHit*>(static_cast<unsigned long long>(optixGetPayload_1()) << 32 |
                                   optixGetPayload_0())
        ->distance = -1.0f;
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

// The place in a cumulative distribution of `count` texels, in [0, 1), and the remainder.
DEVICE float searchTexels(cudaTextureObject_t texture, unsigned count, float row, float x) {
    unsigned first = 0, last = count - 1;
    while (first < last) {
        const unsigned middle = (first + last) / 2;
        if (tex2D<float>(texture, (middle + 0.5f) / count, row) <= x)
            first = middle + 1;
        else
            last = middle;
    }
    const float below = first ? tex2D<float>(texture, (first - 0.5f) / count, row) : 0.0f;
    const float above = tex2D<float>(texture, (first + 0.5f) / count, row);
    return (first + clamp01((x - below) / fmaxf(above - below, 1e-12f)) * 0.999f) / count;
}

// Light from a place of the surroundings, and its density over directions.
DEVICE float3 outsideAt(float u, float v, float& density) {
    const Surroundings& o = params.outside;
    // The density is that of a texel; light has no filter, so that both agree.
    const float x = (floorf(u * o.width) + 0.5f) / o.width;
    const float y = (floorf(v * o.height) + 0.5f) / o.height;
    const float4 texel = tex2D<float4>(o.radiance, x, y);
    density = texel.w / (2.0f * kPi * kPi * fmaxf(sinf(kPi * v), 1e-3f));
    return vec(texel.x, texel.y, texel.z);
}
DEVICE float3 outsideTowards(float3 direction, float& density) {
    const float u = atan2f(direction.z, direction.x) * (0.5f / kPi);
    const float v = acosf(fmaxf(-1.0f, fminf(1.0f, direction.y))) / kPi;
    return outsideAt(u < 0.0f ? u + 1.0f : u, fminf(v, 0.99999f), density);
}

DEVICE bool isOpen(float3 from, float3 direction) {
    unsigned open = 0, unused = 0;
    optixTrace(params.room, from, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, open, unused);
    return open != 0;
}

// Light that a sample of the surroundings sends along `-direction`.
DEVICE float3 sampleOutside(const InteriorHit& hit, const Lobes& lobes, float3 point, float3 x,
                            float3 y, float3 v, unsigned& random) {
    const Surroundings& o = params.outside;
    const float first = nextFloat(random), second = nextFloat(random);
    const float row = searchTexels(o.rows, o.height, 0.5f, first);
    const float rowCenter = (floorf(row * o.height) + 0.5f) / o.height;
    const float column = searchTexels(o.columns, o.width, rowCenter, second);
    float outside, inside;
    const float3 light = outsideAt(column, row, outside);
    const float2 around = circlePoint(column);
    const float level = sinf(kPi * row);
    const float3 direction = vec(level * around.x, cosf(kPi * row), level * around.y);
    const float3 l = vec(dot(direction, x), dot(direction, y), dot(direction, hit.normal));
    const float3 share = lobes.evaluate(v, l, inside);
    if (inside <= 0.0f || outside <= 0.0f || dot(direction, hit.flat) <= 0.0f ||
        !isOpen(point, direction))
        return vec(0.0f);
    return light * share * (outside / (outside * outside + inside * inside));
}

DEVICE float3 tracePath(float3 origin, float3 direction, unsigned& random) {
    float3 sum = vec(0.0f), weight = vec(1.0f);
    float density = -1.0f; // of the last direction; negative: of the camera
    for (unsigned bounce = 0;; ++bounce) {
        InteriorHit hit;
        const auto address = reinterpret_cast<unsigned long long>(&hit);
        unsigned low = static_cast<unsigned>(address), high = static_cast<unsigned>(address >> 32);
        optixTrace(params.room, origin, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, low, high);
        if (hit.distance < 0.0f) {
            float outside;
            const float3 light = outsideTowards(direction, outside);
            const float squared = density * density;
            return sum + weight * light *
                             (density < 0.0f ? 1.0f : squared / (squared + outside * outside));
        }
        if (bounce == params.maxBounces)
            return sum;
        float3 x, y;
        makeBasis(hit.normal, x, y);
        const float3 v =
            vec(-dot(direction, x), -dot(direction, y), fmaxf(0.02f, -dot(direction, hit.normal)));
        const Lobes lobes(hit.material);
        origin = origin + direction * hit.distance + hit.flat * 1e-4f;
        sum += weight * sampleOutside(hit, lobes, origin, x, y, v, random);
        const float3 l = lobes.sample(normalize(v), random);
        const float3 share = lobes.evaluate(v, l, density);
        direction = fromBasis(x, y, hit.normal, l);
        if (density <= 1e-6f || dot(direction, hit.flat) <= 0.0f)
            return sum;
        weight *= share / density;
        const float survival = fminf(0.95f, maxComponent(weight));
        if (bounce > 1 && nextFloat(random) >= survival)
            return sum;
        if (bounce > 1)
            weight = weight / survival;
    }
}

extern "C" __global__ void __raygen__interior() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        const float3 light =
            tracePath(params.camera.eye, cameraDirection(params.camera, x, y), random);
        sum += vec(fminf(light.x, 20.0f), fminf(light.y, 20.0f), fminf(light.z, 20.0f));
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
