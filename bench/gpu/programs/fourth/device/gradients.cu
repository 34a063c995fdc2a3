// SPDX-License-Identifier: Apache-2.0
// A renderer that returns light with its derivatives by the unknowns of the scene, for inverse
// problems. Closest-hit programs compute with dual numbers and trace further rays. Payload: three
// dual numbers in 21 words, depth, random state.
#include "gradients.h"
#include "tools.h"

extern "C" {
__constant__ GradientParams params;
}

constexpr unsigned kWords = 1 + kUnknowns;

// A number with its derivatives by all unknowns.
struct Dual {
    float value, slopes[kUnknowns];
};
struct Dual3 {
    Dual x, y, z;
};

DEVICE Dual constantOf(float value) {
    return {value, {}};
}
DEVICE Dual unknownOf(unsigned i) {
    Dual d = constantOf(params.unknowns[i]);
    d.slopes[i] = 1.0f;
    return d;
}
// A function of `a` with this value and derivative by it.
DEVICE Dual chain(const Dual& a, float value, float derivative) {
    Dual r = constantOf(value);
    for (unsigned i = 0; i < kUnknowns; ++i)
        r.slopes[i] = derivative * a.slopes[i];
    return r;
}
DEVICE Dual operator+(const Dual& a, const Dual& b) {
    Dual r = constantOf(a.value + b.value);
    for (unsigned i = 0; i < kUnknowns; ++i)
        r.slopes[i] = a.slopes[i] + b.slopes[i];
    return r;
}
DEVICE Dual operator*(const Dual& a, const Dual& b) {
    Dual r = constantOf(a.value * b.value);
    for (unsigned i = 0; i < kUnknowns; ++i)
        r.slopes[i] = a.value * b.slopes[i] + b.value * a.slopes[i];
    return r;
}
DEVICE Dual operator*(const Dual& a, float b) {
    return chain(a, a.value * b, b);
}
DEVICE Dual3 operator+(const Dual3& a, const Dual3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
DEVICE Dual3 operator*(const Dual3& a, const Dual& b) {
    return {a.x * b, a.y * b, a.z * b};
}
DEVICE Dual3 scaled(const Dual3& a, float3 b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

DEVICE void put(unsigned (&words)[3 * kWords], unsigned at, const Dual& d) {
    words[at] = __float_as_uint(d.value);
    for (unsigned i = 0; i < kUnknowns; ++i)
        words[at + 1 + i] = __float_as_uint(d.slopes[i]);
}
DEVICE Dual get(const unsigned (&words)[3 * kWords], unsigned at) {
    Dual d = constantOf(__uint_as_float(words[at]));
    for (unsigned i = 0; i < kUnknowns; ++i)
        d.slopes[i] = __uint_as_float(words[at + 1 + i]);
    return d;
}
DEVICE void answer(const Dual3& light, unsigned random) {
    unsigned w[3 * kWords];
    put(w, 0, light.x);
    put(w, kWords, light.y);
    put(w, 2 * kWords, light.z);
    optixSetPayload_0(w[0]);
    optixSetPayload_1(w[1]);
    optixSetPayload_2(w[2]);
    optixSetPayload_3(w[3]);
    optixSetPayload_4(w[4]);
    optixSetPayload_5(w[5]);
    optixSetPayload_6(w[6]);
    optixSetPayload_7(w[7]);
    optixSetPayload_8(w[8]);
    optixSetPayload_9(w[9]);
    optixSetPayload_10(w[10]);
    optixSetPayload_11(w[11]);
    optixSetPayload_12(w[12]);
    optixSetPayload_13(w[13]);
    optixSetPayload_14(w[14]);
    optixSetPayload_15(w[15]);
    optixSetPayload_16(w[16]);
    optixSetPayload_17(w[17]);
    optixSetPayload_18(w[18]);
    optixSetPayload_19(w[19]);
    optixSetPayload_20(w[20]);
    optixSetPayload_22(random);
}

DEVICE Dual3 lightFrom(float3 from, float3 direction, unsigned depth, unsigned& random) {
    unsigned w[3 * kWords];
    optixTrace(params.room, from, direction, 1e-4f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, w[0], w[1], w[2], w[3], w[4], w[5], w[6],
               w[7], w[8], w[9], w[10], w[11], w[12], w[13], w[14], w[15], w[16], w[17], w[18],
               w[19], w[20], depth, random);
    return {get(w, 0), get(w, kWords), get(w, 2 * kWords)};
}
// Whether the lamp is visible; the picture of its derivatives leaves out edges of shadows.
DEVICE bool seesLamp(float3 from, float3 towards) {
    unsigned open = 0;
    optixTrace(params.room, from, towards, 1e-4f, 0.999f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, open);
    return open != 0;
}

// Light of the lamp that arrives at a point: power cos / (4 pi distance squared).
DEVICE Dual lampLight(float3 point, float3 normal) {
    const Dual3 to = {unknownOf(kLampX) + constantOf(-point.x),
                      unknownOf(kLampY) + constantOf(-point.y),
                      unknownOf(kLampZ) + constantOf(-point.z)};
    const Dual cosine = to.x * normal.x + to.y * normal.y + to.z * normal.z;
    if (cosine.value <= 0.0f || !seesLamp(point, vec(to.x.value, to.y.value, to.z.value)))
        return constantOf(0.0f);
    const Dual squared = to.x * to.x + to.y * to.y + to.z * to.z;
    const float s = squared.value, root = sqrtf(s);
    const Dual falloff = chain(squared, 1.0f / (s * root), -1.5f / (s * s * root));
    return unknownOf(kLampPower) * cosine * falloff * (0.25f / kPi);
}

extern "C" __global__ void __closesthit__wall() {
    const auto* r = reinterpret_cast<const GradientRecord*>(optixGetSbtDataPointer());
    const unsigned depth = optixGetPayload_21();
    unsigned random = optixGetPayload_22();
    const float3 direction = optixGetWorldRayDirection();
    const float3 normal = towardsRay(normalize(r->mesh.normal(optixGetPrimitiveIndex())));
    const float3 point = rayPoint() + normal * 1e-4f;
    const Dual direct = lampLight(point, normal);
    Dual3 light = {direct, direct, direct};
    if (depth < params.maxDepth) {
        const float u = nextFloat(random), v = nextFloat(random);
        light = light + lightFrom(point, cosineDirection(normal, u, v), depth + 1, random);
    }
    light = scaled(light * unknownOf(kScatter), r->albedo);
    if (r->mirror > 0.0f && depth < 2) {
        const Dual3 mirrored = lightFrom(point, reflect(direction, normal), depth + 1, random);
        light = scaled(light, vec(1.0f - r->mirror)) +
                scaled(mirrored * unknownOf(kReflect), vec(r->mirror));
    }
    answer(light, random);
}
extern "C" __global__ void __miss__dark() {
    const Dual none = constantOf(0.0f);
    answer({none, none, none}, optixGetPayload_22());
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

// Positive derivatives are orange, negative ones blue.
DEVICE float3 signedColor(const Dual3& light, unsigned unknown) {
    const float slope = 0.3f * light.x.slopes[unknown] + 0.6f * light.y.slopes[unknown] +
                        0.1f * light.z.slopes[unknown];
    const float size = fabsf(slope) / (0.3f + fabsf(slope));
    return lerp(vec(0.08f), slope > 0.0f ? vec(1.0f, 0.55f, 0.15f) : vec(0.15f, 0.5f, 1.0f), size);
}

// Four pictures: light, and its derivatives by the lamp's place, scattering and reflection.
extern "C" __global__ void __raygen__gradients() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x, halfX = (size.x + 1) / 2,
                   halfY = (size.y + 1) / 2;
    const unsigned quarter = (index.x >= halfX ? 1 : 0) + (index.y >= halfY ? 2 : 0);
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x % halfX + nextFloat(random)) / halfX;
        const float y = (index.y % halfY + nextFloat(random)) / halfY;
        const Dual3 light =
            lightFrom(params.camera.eye, cameraDirection(params.camera, x, y), 0, random);
        sum += quarter == 0   ? vec(light.x.value, light.y.value, light.z.value)
               : quarter == 1 ? signedColor(light, kLampX)
               : quarter == 2 ? signedColor(light, kScatter)
                              : signedColor(light, kReflect);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
