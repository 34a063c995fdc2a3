// SPDX-License-Identifier: Apache-2.0
// A principled material after Burley 2012: diffuse light with retroreflection, sheen, a GGX lobe
// and a coat. Directions are in a basis whose z axis is the normal.
#pragma once

#include "interior.h"
#include "tools.h"

DEVICE float weightOf(float cosine) {
    const float edge = clamp01(1.0f - cosine), squared = edge * edge;
    return squared * squared * edge;
}
DEVICE float ggx(float cosine, float alpha) {
    const float squared = alpha * alpha, t = 1.0f + (squared - 1.0f) * cosine * cosine;
    return squared / (kPi * t * t);
}
DEVICE float coatLobe(float cosine, float alpha) {
    const float squared = alpha * alpha, t = 1.0f + (squared - 1.0f) * cosine * cosine;
    return (squared - 1.0f) / (kPi * logf(squared) * t);
}
DEVICE float shadowing(float cosine, float alpha) {
    const float a = alpha * alpha, b = cosine * cosine;
    return 1.0f / (cosine + sqrtf(a + b - a * b));
}

struct Lobes {
    Principled m;
    float alpha, coatAlpha;
    float diffuse, mirror; // probabilities; the rest is the coat's

    __forceinline__ __device__ Lobes(const Principled& material) : m(material) {
        alpha = fmaxf(1e-3f, m.roughness * m.roughness);
        coatAlpha = 0.1f + (1e-3f - 0.1f) * m.coatGloss;
        const float total = 2.0f + 0.25f * m.coat;
        diffuse = (1.0f - m.metallic) / total;
        mirror = (1.0f + m.metallic) / total;
    }
    // The scattered share of light times the cosine, and the density of the direction `l`.
    __forceinline__ __device__ float3 evaluate(float3 v, float3 l, float& density) const {
        density = 0.0f;
        if (l.z <= 1e-4f || v.z <= 1e-4f)
            return vec(0.0f);
        const float3 half = normalize(v + l);
        const float cosine = dot(l, half), edge = weightOf(cosine);
        const float ground = 0.5f + 2.0f * cosine * cosine * m.roughness;
        const float back =
            (1.0f + (ground - 1.0f) * weightOf(l.z)) * (1.0f + (ground - 1.0f) * weightOf(v.z));
        const float3 matt = (m.base * (back / kPi) + vec(m.sheen * edge)) * (1.0f - m.metallic);
        const float3 tint = lerp(vec(0.08f * m.specular), m.base, m.metallic);
        const float peak = ggx(half.z, alpha);
        const float3 metal =
            lerp(tint, vec(1.0f), edge) * (peak * shadowing(l.z, alpha) * shadowing(v.z, alpha));
        const float coatPeak = coatLobe(half.z, coatAlpha);
        const float coat = 0.25f * m.coat * (0.04f + 0.96f * edge) * coatPeak *
                           shadowing(l.z, 0.25f) * shadowing(v.z, 0.25f);
        const float perHalf = half.z / (4.0f * cosine);
        density = diffuse * l.z / kPi + mirror * peak * perHalf +
                  (1.0f - diffuse - mirror) * coatPeak * perHalf;
        return (matt + metal + vec(coat)) * l.z;
    }
    __forceinline__ __device__ float3 sample(float3 v, unsigned& random) const {
        const float choice = nextFloat(random), x = nextFloat(random), y = nextFloat(random);
        if (choice < diffuse)
            return cosineDirection(vec(0.0f, 0.0f, 1.0f), x, y);
        float squared = (1.0f - x) / (1.0f + (alpha * alpha - 1.0f) * x);
        if (choice >= diffuse + mirror) {
            const float a = coatAlpha * coatAlpha;
            squared = (1.0f - powf(a, 1.0f - x)) / (1.0f - a);
        }
        const float level = sqrtf(fmaxf(0.0f, 1.0f - squared));
        const float2 c = circlePoint(y);
        return -reflect(v, vec(level * c.x, level * c.y, sqrtf(squared)));
    }
};
