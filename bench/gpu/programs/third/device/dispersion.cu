// SPDX-License-Identifier: Apache-2.0
// A spectral renderer: each ray has one wavelength. Gems reflect or refract by chance, floors trace
// a shadow ray through gems. Payload of light rays: wavelength, depth, random state, radiance; of
// shadow rays: share that arrives, wavelength.
#include "dispersion.h"
#include "tools.h"

extern "C" {
__constant__ DispersionParams params;
}

constexpr OptixPayloadTypeID kLight = OPTIX_PAYLOAD_TYPE_ID_0, kShadow = OPTIX_PAYLOAD_TYPE_ID_1;

DEVICE const GemRecord& gem() {
    return *reinterpret_cast<const GemRecord*>(optixGetSbtDataPointer());
}
DEVICE float3 worldNormal() {
    const float3 local = gem().mesh.normal(optixGetPrimitiveIndex());
    return normalize(optixTransformNormalFromObjectToWorldSpace(local));
}

// A colour of three channels as a smooth spectrum.
DEVICE float spectrumOf(float3 color, float wavelength) {
    const float t = clamp01((wavelength - 430.0f) / 220.0f) * 2.0f;
    return t < 1.0f ? color.z + (color.y - color.z) * t
                    : color.y + (color.x - color.y) * (t - 1.0f);
}
DEVICE float skyAt(float3 direction, float wavelength) {
    const float window =
        direction.y > 0.35f && sinf(7.0f * direction.x) * sinf(7.0f * direction.z) > 0.2f;
    const float glare = powf(fmaxf(dot(direction, params.sun), 0.0f), 400.0f) * 60.0f;
    return spectrumOf(blueSky(direction), wavelength) * (0.35f + 1.6f * window) + glare;
}
DEVICE float bell(float x, float middle, float left, float right) {
    const float d = (x - middle) * (x < middle ? left : right);
    return expf(-0.5f * d * d);
}
// Linear sRGB of a wavelength (Wyman 2013).
DEVICE float3 colorOf(float w) {
    const float x = 0.362f * bell(w, 442.0f, 0.0624f, 0.0374f) +
                    1.056f * bell(w, 599.8f, 0.0264f, 0.0323f) -
                    0.065f * bell(w, 501.1f, 0.049f, 0.0382f);
    const float y =
        0.821f * bell(w, 568.8f, 0.0213f, 0.0247f) + 0.286f * bell(w, 530.9f, 0.0613f, 0.0322f);
    const float z =
        1.217f * bell(w, 437.0f, 0.0845f, 0.0278f) + 0.681f * bell(w, 459.0f, 0.0385f, 0.0725f);
    return vec(3.24f * x - 1.54f * y - 0.5f * z, -0.97f * x + 1.88f * y + 0.04f * z,
               0.06f * x - 0.2f * y + 1.06f * z);
}

DEVICE float traceLight(float3 origin, float3 direction, float wavelength, unsigned depth,
                        unsigned& random) {
    unsigned w = __float_as_uint(wavelength), radiance;
    optixTrace(kLight, params.scene, origin, direction, 1e-4f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 2, 0, w, depth, random,
               radiance);
    return __uint_as_float(radiance);
}

// The share of unpolarised light that a boundary reflects; `sine2`: squared sine of the other side.
DEVICE float fresnel(float cosine, float ratio, float sine2) {
    if (sine2 >= 1.0f)
        return 1.0f;
    const float other = sqrtf(1.0f - sine2);
    const float s = (ratio * cosine - other) / (ratio * cosine + other);
    const float p = (ratio * other - cosine) / (ratio * other + cosine);
    return 0.5f * (s * s + p * p);
}

extern "C" __global__ void __closesthit__gem() {
    optixSetPayloadTypes(kLight);
    const float wavelength = __uint_as_float(optixGetPayload_0());
    const unsigned depth = optixGetPayload_1();
    unsigned random = optixGetPayload_2();
    const float3 direction = optixGetWorldRayDirection();
    const bool isInside = optixIsTriangleBackFaceHit();
    const float3 normal = isInside ? -worldNormal() : worldNormal();
    const float micrometres = wavelength * 1e-3f;
    const float index = gem().index + gem().dispersion / (micrometres * micrometres);
    const float ratio = isInside ? index : 1.0f / index, cosine = -dot(direction, normal);
    const float sine2 = ratio * ratio * (1.0f - cosine * cosine);
    const float mirrored = fresnel(cosine, ratio, sine2);
    float3 onward = reflect(direction, normal);
    if (nextFloat(random) >= mirrored)
        onward = normalize(direction * ratio + normal * (ratio * cosine - sqrtf(1.0f - sine2)));
    const float3 point = rayPoint();
    float radiance = depth < params.maxDepth
                         ? traceLight(point, onward, wavelength, depth + 1, random)
                         : 0.2f * skyAt(onward, wavelength);
    if (isInside)
        radiance *= expf(-spectrumOf(gem().absorption, wavelength) * optixGetRayTmax());
    optixSetPayload_2(random);
    optixSetPayload_3(__float_as_uint(radiance));
}

extern "C" __global__ void __anyhit__caustic() {
    optixSetPayloadTypes(kShadow);
    const float cosine = fabsf(dot(worldNormal(), optixGetWorldRayDirection()));
    const float absorbed = spectrumOf(gem().absorption, __uint_as_float(optixGetPayload_1()));
    const float share = (0.4f + 0.6f * cosine * cosine) * (1.0f - 0.5f * absorbed);
    optixSetPayload_0(__float_as_uint(__uint_as_float(optixGetPayload_0()) * share));
    optixIgnoreIntersection();
}
extern "C" __global__ void __anyhit__block() {
    optixSetPayloadTypes(kShadow);
    optixSetPayload_0(0);
    optixTerminateRay();
}

extern "C" __global__ void __closesthit__floor() {
    optixSetPayloadTypes(kLight);
    const float wavelength = __uint_as_float(optixGetPayload_0());
    const float3 point = rayPoint(), normal = towardsRay(worldNormal());
    const int tile = static_cast<int>(floorf(point.x)) + static_cast<int>(floorf(point.z));
    const float3 paint = tile & 1 ? vec(0.75f, 0.7f, 0.6f) : vec(0.12f, 0.15f, 0.25f);
    unsigned share = __float_as_uint(1.0f), w = optixGetPayload_0();
    optixTrace(kShadow, params.scene, point + normal * 1e-3f, params.sun, 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 1, 2, 1, share, w);
    const float light =
        0.25f + 1.3f * __uint_as_float(share) * fmaxf(dot(normal, params.sun), 0.0f);
    optixSetPayload_2(hashPcg(optixGetPayload_2()));
    optixSetPayload_3(__float_as_uint(spectrumOf(paint, wavelength) * light));
}
extern "C" __global__ void __miss__sky() {
    optixSetPayloadTypes(kLight);
    const float wavelength = __uint_as_float(optixGetPayload_0());
    optixSetPayload_2(hashPcg(optixGetPayload_2()));
    optixSetPayload_3(__float_as_uint(skyAt(optixGetWorldRayDirection(), wavelength)));
}

extern "C" __global__ void __raygen__spectrum() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    const float first = nextFloat(random);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.wavelengths; ++i) {
        const float share = (i + first) / params.wavelengths;
        const float wavelength = 400.0f + 300.0f * share;
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        const float radiance = traceLight(params.camera.eye, cameraDirection(params.camera, x, y),
                                          wavelength, 0, random);
        sum += colorOf(wavelength) * radiance;
    }
    const float scale = 300.0f / 106.857f / params.wavelengths; // over the integral of y
    params.image[pixel] = withWeight(sum * scale, 1.0f);
}
