// SPDX-License-Identifier: Apache-2.0
// Callable programs: skies, patterns, scattering, lights. The API searches their variables in the
// program itself, and for bound programs then in the scopes of the caller.
#include "bsdf.h"

using namespace optix;

// ---- Skies -------------------------------------------------------------------------------------

rtDeclareVariable(float3, horizon, , );
rtDeclareVariable(float3, zenith, , );
RT_CALLABLE_PROGRAM float3 sky_gradient(float3 direction) {
    return lerp(horizon, zenith, clamp(direction.y * 1.5f, 0.0f, 1.0f));
}

// ---- Patterns ----------------------------------------------------------------------------------

rtDeclareVariable(float3, color, , );
rtDeclareVariable(float3, color2, , );
rtDeclareVariable(float2, repeat, , );

RT_CALLABLE_PROGRAM float3 pattern_plain(float3) {
    return color;
}
RT_CALLABLE_PROGRAM float3 pattern_checks(float3 place) {
    const int parity = int(floorf(place.x * repeat.x) + floorf(place.y * repeat.y)) & 1;
    return parity ? color2 : color;
}
RT_CALLABLE_PROGRAM float3 pattern_stripes(float3 place) {
    const float part = place.x * repeat.x + place.y * repeat.y;
    return lerp(color, color2, smoothstep(0.4f, 0.6f, fabsf(part - floorf(part) - 0.5f) * 2.0f));
}

// ---- Scattering --------------------------------------------------------------------------------

RT_CALLABLE_PROGRAM BsdfSample bsdf_diffuse(float3, float3 albedo, float2 u) {
    BsdfSample result;
    cosine_sample_hemisphere(u.x, u.y, result.direction);
    result.weight = albedo;
    result.diffuse = 1.0f / M_PIf;
    return result;
}

rtDeclareVariable(float, roughness, , );
// A power cosine lobe around the mirrored direction.
RT_CALLABLE_PROGRAM BsdfSample bsdf_metal(float3 to_eye, float3 albedo, float2 u) {
    const float3 mirrored = make_float3(-to_eye.x, -to_eye.y, to_eye.z);
    const float height = powf(u.x, roughness * roughness);
    const float radius = sqrtf(fmaxf(0.0f, 1.0f - height * height)), turn = 2.0f * M_PIf * u.y;
    float3 lobe = make_float3(radius * cosf(turn), radius * sinf(turn), height);
    Onb(mirrored).inverse_transform(lobe);
    lobe.z = fabsf(lobe.z);
    BsdfSample result;
    result.direction = lobe;
    result.weight = fresnel_schlick(to_eye.z, 5.0f, albedo, make_float3(1.0f));
    result.diffuse = 0.0f;
    return result;
}

// A clear coat over a base that another callable program scatters.
rtDeclareVariable(rtCallableProgramX<BsdfSample(float3, float3, float2)>, base, , );
RT_CALLABLE_PROGRAM BsdfSample bsdf_coated(float3 to_eye, float3 albedo, float2 u) {
    const float coat = fresnel_schlick(to_eye.z, 5.0f, 0.04f, 1.0f);
    BsdfSample result;
    if (u.x < coat) {
        result.direction = make_float3(-to_eye.x, -to_eye.y, to_eye.z);
        result.weight = make_float3(1.0f);
        result.diffuse = 0.0f;
        return result;
    }
    return base(to_eye, albedo, make_float2((u.x - coat) / (1.0f - coat), u.y));
}

// ---- Lights ------------------------------------------------------------------------------------

rtDeclareVariable(float3, place, , );
rtDeclareVariable(float3, power, , );
rtDeclareVariable(float, size, , );

RT_CALLABLE_PROGRAM LightSample light_sphere(float3 point, float2 u) {
    const float z = 1.0f - 2.0f * u.x, r = sqrtf(fmaxf(0.0f, 1.0f - z * z));
    const float turn = 2.0f * M_PIf * u.y;
    const float3 way = place + size * make_float3(r * cosf(turn), r * sinf(turn), z) - point;
    LightSample result;
    result.distance = length(way);
    result.direction = way / result.distance;
    result.radiance = power / dot(way, way);
    return result;
}
RT_CALLABLE_PROGRAM LightSample light_sun(float3, float2 u) {
    LightSample result;
    result.direction = normalize(place + size * make_float3(u.x - 0.5f, 0.0f, u.y - 0.5f));
    result.radiance = power;
    result.distance = RT_DEFAULT_MAX;
    return result;
}
