// SPDX-License-Identifier: Apache-2.0
// The arithmetic of both sets of programs. They are compiled without contraction to fused
// operations, so that equal expressions have equal results.
#pragma once

namespace shade {

#define SHADE static __device__ __forceinline__

enum RayType { kRadiance, kShadow, kRayTypes };
constexpr float kEpsilon = 1e-3f, kFar = 1e16f;
constexpr unsigned kMaxBounce = 2;

SHADE float3 vec(float x, float y, float z) {
    float3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}
SHADE float3 plus(float3 a, float3 b) {
    return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
SHADE float3 minus(float3 a, float3 b) {
    return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
SHADE float3 times(float3 a, float s) {
    return vec(a.x * s, a.y * s, a.z * s);
}
SHADE float inner(float3 a, float3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
SHADE float3 outer(float3 a, float3 b) {
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
SHADE float3 unit(float3 a) {
    return times(a, 1.0f / sqrtf(inner(a, a)));
}
SHADE float3 mirror(float3 v, float3 n) {
    return minus(v, times(n, 2.0f * inner(v, n)));
}

SHADE float3 eye() {
    return vec(0.3f, 1.7f, 6.0f);
}
SHADE float3 direction(unsigned x, unsigned y, unsigned width, unsigned height) {
    const float u = ((x + 0.5f) / width - 0.5f) * 1.1f;
    const float v = (0.5f - (y + 0.5f) / height) * 0.825f;
    return unit(vec(u, v - 0.2f, -1.0f));
}
SHADE float3 toSun() {
    return unit(vec(0.6f, 0.9f, 0.35f));
}
SHADE float3 sky(float3 d) {
    const float height = 0.5f + 0.5f * d.y;
    return vec(0.9f - 0.6f * height, 0.9f - 0.4f * height, 0.9f);
}
SHADE float3 facing(float3 normal, float3 d) {
    return inner(normal, d) > 0.0f ? vec(-normal.x, -normal.y, -normal.z) : normal;
}
// `light`: the share that reaches the point.
SHADE float3 diffuse(float3 albedo, float3 normal, float light) {
    const float cosine = inner(normal, toSun());
    const float sum = 0.3f + (cosine > 0.0f ? cosine * light : 0.0f);
    return times(albedo, sum);
}

// Holes of triangles.
SHADE bool isHole(unsigned primitive, float2 barycentrics) {
    return (int(barycentrics.x * 6.0f) + int(barycentrics.y * 5.0f) + int(primitive)) % 3 == 0;
}

// Where a ray meets a sphere; false: nowhere.
SHADE bool hitSphere(float3 origin, float3 d, float4 sphere, float& near, float& far) {
    const float3 offset = minus(origin, vec(sphere.x, sphere.y, sphere.z));
    const float a = inner(d, d), b = inner(offset, d);
    const float c = inner(offset, offset) - sphere.w * sphere.w;
    const float discriminant = b * b - a * c;
    if (discriminant < 0.0f)
        return false;
    const float root = sqrtf(discriminant);
    near = (-b - root) / a;
    far = (-b + root) / a;
    return true;
}
SHADE float3 sphereNormal(float3 origin, float3 d, float4 sphere, float t) {
    const float3 point = plus(origin, times(d, t));
    return times(minus(point, vec(sphere.x, sphere.y, sphere.z)), 1.0f / sphere.w);
}

} // namespace shade
