// SPDX-License-Identifier: Apache-2.0
// The computations of both path tracers of this folder: random numbers, camera rays, shading,
// spheres. Programs of the classic API and of OptiX 7 share this code.
#pragma once

#include "tracer_params.h"

namespace twin {

struct V3 {
    float x, y, z;
};
__device__ __forceinline__ V3 vec(float x, float y, float z) {
    return {x, y, z};
}
__device__ __forceinline__ V3 vec(const float* v) {
    return {v[0], v[1], v[2]};
}
__device__ __forceinline__ V3 operator+(V3 a, V3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
__device__ __forceinline__ V3 operator-(V3 a, V3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
__device__ __forceinline__ V3 operator*(V3 a, V3 b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}
__device__ __forceinline__ V3 operator*(V3 a, float s) {
    return {a.x * s, a.y * s, a.z * s};
}
__device__ __forceinline__ float dot(V3 a, V3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
__device__ __forceinline__ V3 cross(V3 a, V3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
__device__ __forceinline__ V3 normalize(V3 a) {
    return a * (1.0f / sqrtf(dot(a, a)));
}

// A path from one segment to the next.
struct Path {
    V3 origin, direction, weight, light;
    unsigned seed;
    int done;
};

// A hash whose bits are all usable (O'Neill 2014).
__device__ __forceinline__ unsigned hash(unsigned value) {
    const unsigned state = value * 747796405u + 2891336453u;
    const unsigned word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
__device__ __forceinline__ float random(unsigned& seed) {
    seed = hash(seed);
    return (seed >> 8) * (1.0f / 16777216.0f);
}

__device__ __forceinline__ Path cameraPath(const Camera& c, unsigned seed, unsigned column,
                                           unsigned row, unsigned width, unsigned height) {
    Path path;
    path.seed = seed;
    const float x = (column + random(path.seed)) / width * 2.0f - 1.0f;
    const float y = 1.0f - (row + random(path.seed)) / height * 2.0f;
    path.origin = vec(c.eye);
    path.direction = normalize(vec(c.forward) + vec(c.right) * x + vec(c.up) * y);
    path.weight = vec(1, 1, 1);
    path.light = vec(0, 0, 0);
    path.done = 0;
    return path;
}

__device__ __forceinline__ void meetSky(Path& path) {
    const float blend = 0.5f + 0.5f * path.direction.y;
    path.light = path.light + path.weight * (vec(0.9f, 0.9f, 0.9f) * (1 - blend) +
                                             vec(0.35f, 0.55f, 0.9f) * blend);
    path.done = 1;
}

__device__ __forceinline__ V3 toSun() {
    return vec(0.48795f, 0.78072f, 0.39036f);
}
__device__ __forceinline__ V3 facing(V3 normal, V3 direction) {
    return dot(normal, direction) > 0 ? normal * -1.0f : normal;
}
// The share of the sun's light at a normal; 0 where the sun is behind.
__device__ __forceinline__ float sunCosine(V3 normal) {
    const float cosine = dot(normal, toSun());
    return cosine > 0 ? cosine : 0;
}
__device__ __forceinline__ void addSun(Path& path, float cosine) {
    path.light = path.light + path.weight * vec(1.6f, 1.45f, 1.2f) * cosine;
}

// Turns the path into a random direction about the normal.
__device__ __forceinline__ void scatter(Path& path, V3 point, V3 normal) {
    const float angle = 6.2831853f * random(path.seed), square = random(path.seed);
    const V3 side = fabsf(normal.x) > 0.5f ? vec(0, 1, 0) : vec(1, 0, 0);
    const V3 u = normalize(cross(side, normal)), v = cross(normal, u);
    const float radius = sqrtf(square);
    path.direction = normalize(u * (radius * cosf(angle)) + v * (radius * sinf(angle)) +
                               normal * sqrtf(1 - square));
    path.origin = point;
}

__device__ __forceinline__ V3 triangleNormal(const float* vertices, const unsigned* indices,
                                             unsigned triangle) {
    const V3 a = vec(vertices + 3 * indices[3 * triangle]);
    const V3 b = vec(vertices + 3 * indices[3 * triangle + 1]);
    const V3 c = vec(vertices + 3 * indices[3 * triangle + 2]);
    return cross(b - a, c - a);
}

// The nearer or the farther intersection within the interval; below tmin: none.
__device__ __forceinline__ float meetSphere(V3 origin, V3 direction, const float* sphere,
                                            float tmin, float tmax) {
    const V3 o = origin - vec(sphere);
    const float a = dot(direction, direction), b = dot(o, direction);
    const float root = b * b - a * (dot(o, o) - sphere[3] * sphere[3]);
    if (root < 0)
        return tmin - 1;
    const float s = sqrtf(root), near = (-b - s) / a, far = (-b + s) / a;
    if (near > tmin && near < tmax)
        return near;
    return far > tmin && far < tmax ? far : tmin - 1;
}

} // namespace twin
