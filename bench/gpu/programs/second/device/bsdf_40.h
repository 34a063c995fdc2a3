// SPDX-License-Identifier: Apache-2.0
// The materials of materials_40.cu: blends of a diffuse and a glossy lobe, of five kinds, with
// constants that follow from the material's number. A material reads one to five textures.
#pragma once

#include "materials_40.h"
#include "tools.h"

struct Interaction {
    float3 point, normal, x, y, outgoing;
    float2 uv;
    const SurfaceMaterial* material;
};
struct MaterialSample {
    float3 direction, weight;
    float pdf;
};

struct Lobes {
    float3 diffuse, gloss;     // colours; the second at normal incidence
    float alpha, sheen, share; // share: probability of the glossy lobe
};

template <unsigned N>
DEVICE Lobes readLobes(const Interaction& at) {
    constexpr unsigned kKind = N % 5, kReads = 1 + N / 5 % 5;
    constexpr float kOwn = float((N * 2654435761u) >> 20 & 255u) / 255.0f;
    const SurfaceMaterial& m = *at.material;
    const float scale = 0.5f + 1.5f * kOwn;
    float4 t[kReads];
    for (unsigned i = 0; i < kReads; ++i)
        t[i] = tex2D<float4>(m.textures[i], at.uv.x * scale, at.uv.y * scale);
    const float3 color = vec(t[0].x, t[0].y, t[0].z) * m.base;
    Lobes l;
    float rough = m.roughness;
    if (kReads > 1)
        rough *= 0.5f + t[1 % kReads].x;
    l.alpha = fmaxf(rough * rough, 0.003f);
    l.sheen = kReads > 2 ? 0.5f * t[2 % kReads].y : 0.0f;
    const float metal = kKind == 3 ? 1.0f : kReads > 3 ? 0.5f * t[3 % kReads].z : 0.0f;
    l.diffuse = color * (1.0f - metal);
    l.gloss = lerp(vec(0.04f), color, metal);
    if (kReads > 4)
        l.gloss = l.gloss * (0.6f + 0.8f * t[4 % kReads].x);
    l.share = kKind == 3 ? 1.0f : kKind == 0 ? 0.0f : 0.25f + 0.5f * kOwn;
    return l;
}

DEVICE float ggx(float alpha, float cosine) {
    const float square = alpha * alpha, d = cosine * cosine * (square - 1.0f) + 1.0f;
    return square / (kPi * d * d);
}
DEVICE float shadowing(float alpha, float cosine) {
    const float square = alpha * alpha;
    return 2.0f * cosine / (cosine + sqrtf(square + (1.0f - square) * cosine * cosine));
}
DEVICE float power5(float x) {
    return x * x * x * x * x;
}

template <unsigned N>
DEVICE float3 diffusePart(const Lobes& l, float in, float out, float between) {
    constexpr unsigned kKind = N % 5;
    float3 f = l.diffuse * (1.0f / kPi);
    if (kKind == 1) { // darker edges: a rough surface
        const float edge = 0.5f + 2.0f * between * between * l.alpha;
        f = f * ((1.0f + (edge - 1.0f) * power5(1.0f - in)) *
                 (1.0f + (edge - 1.0f) * power5(1.0f - out)));
    }
    if (kKind == 2) // fibres
        f += vec(l.sheen * power5(1.0f - between));
    return f;
}
template <unsigned N>
DEVICE float3 glossPart(const Lobes& l, float in, float out, float half, float between) {
    constexpr unsigned kKind = N % 5;
    float3 fresnel = lerp(l.gloss, vec(1.0f), power5(1.0f - between));
    if (kKind == 4) { // a thin film
        const float path = 2.0f + 3.0f * between;
        fresnel = fresnel * vec(0.6f + 0.4f * cosf(path * 2.1f), 0.6f + 0.4f * cosf(path * 2.6f),
                                0.6f + 0.4f * cosf(path * 3.2f));
    }
    const float s = ggx(l.alpha, half) * shadowing(l.alpha, in) * shadowing(l.alpha, out);
    float3 f = fresnel * (s / fmaxf(4.0f * in * out, 1e-4f));
    if (kKind == 4) // a coat above
        f += vec(0.25f * ggx(0.02f, half) * (0.04f + 0.96f * power5(1.0f - between)));
    return f;
}

// The reflected share times the cosine, and the density.
template <unsigned N>
DEVICE float4 evaluateLobes(const Lobes& l, const Interaction& at, float3 direction) {
    constexpr unsigned kKind = N % 5;
    const float in = dot(direction, at.normal), out = fmaxf(dot(at.outgoing, at.normal), 1e-3f);
    if (in <= 0.0f)
        return make_float4(0.0f, 0.0f, 0.0f, 0.0f);
    const float3 middle = normalize(direction + at.outgoing);
    const float half = fmaxf(dot(middle, at.normal), 0.0f);
    const float between = fmaxf(dot(middle, direction), 1e-3f);
    float3 f = vec(0.0f);
    float pdf = 0.0f;
    if (kKind != 3) {
        f += diffusePart<N>(l, in, out, between);
        pdf += (1.0f - l.share) * in / kPi;
    }
    if (kKind != 0) {
        f += glossPart<N>(l, in, out, half, between);
        pdf += l.share * ggx(l.alpha, half) * half / (4.0f * between);
    }
    return make_float4(f.x * in, f.y * in, f.z * in, pdf);
}

template <unsigned N>
DEVICE float4 evaluateMaterial(const Interaction& at, float3 direction) {
    return evaluateLobes<N>(readLobes<N>(at), at, direction);
}

template <unsigned N>
DEVICE MaterialSample sampleMaterial(const Interaction& at, float u, float v, float w) {
    const Lobes l = readLobes<N>(at);
    MaterialSample s;
    if (w < l.share) {
        const float cosine = sqrtf((1.0f - u) / (1.0f + (l.alpha * l.alpha - 1.0f) * u));
        const float sine = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f));
        const float2 c = circlePoint(v);
        const float3 middle = fromBasis(at.x, at.y, at.normal, vec(sine * c.x, sine * c.y, cosine));
        s.direction = reflect(-at.outgoing, middle);
    } else {
        s.direction = cosineDirection(at.normal, u, v);
    }
    const float4 f = evaluateLobes<N>(l, at, s.direction);
    s.pdf = f.w;
    s.weight = f.w > 0.0f ? vec(f.x, f.y, f.z) / f.w : vec(0.0f);
    return s;
}
