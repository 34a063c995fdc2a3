// SPDX-License-Identifier: Apache-2.0
// Arithmetic on CUDA's float3 for host and device code. It has only the functions that the samples
// need.
#pragma once

#include <cuda_runtime.h>
#include <math.h>

#ifdef __CUDACC__
#define SAMPLE_INLINE __host__ __device__ __forceinline__
#else
#define SAMPLE_INLINE inline
#endif

SAMPLE_INLINE float3 vec(float x, float y, float z) {
    float3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}
SAMPLE_INLINE float3 vec(float s) {
    return vec(s, s, s);
}
SAMPLE_INLINE float3 operator+(float3 a, float3 b) {
    return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
SAMPLE_INLINE float3 operator-(float3 a, float3 b) {
    return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
SAMPLE_INLINE float3 operator-(float3 a) {
    return vec(-a.x, -a.y, -a.z);
}
SAMPLE_INLINE float3 operator*(float3 a, float3 b) {
    return vec(a.x * b.x, a.y * b.y, a.z * b.z);
}
SAMPLE_INLINE float3 operator*(float3 a, float s) {
    return vec(a.x * s, a.y * s, a.z * s);
}
SAMPLE_INLINE float3 operator*(float s, float3 a) {
    return a * s;
}
SAMPLE_INLINE float3 operator/(float3 a, float s) {
    return a * (1.0f / s);
}
SAMPLE_INLINE float3& operator+=(float3& a, float3 b) {
    a = a + b;
    return a;
}
SAMPLE_INLINE float3& operator*=(float3& a, float3 b) {
    a = a * b;
    return a;
}
SAMPLE_INLINE float dot(float3 a, float3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
SAMPLE_INLINE float3 cross(float3 a, float3 b) {
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
SAMPLE_INLINE float length(float3 a) {
    return sqrtf(dot(a, a));
}
SAMPLE_INLINE float3 normalize(float3 a) {
    return a * (1.0f / sqrtf(dot(a, a)));
}
SAMPLE_INLINE float minOf(float a, float b) {
    return a < b ? a : b;
}
SAMPLE_INLINE float maxOf(float a, float b) {
    return a > b ? a : b;
}
SAMPLE_INLINE float clamp01(float a) {
    return minOf(maxOf(a, 0.0f), 1.0f);
}
SAMPLE_INLINE float3 lerp(float3 a, float3 b, float t) {
    return a + (b - a) * t;
}
SAMPLE_INLINE float maxComponent(float3 a) {
    return maxOf(a.x, maxOf(a.y, a.z));
}
// `v` mirrored at the plane with unit normal `n`.
SAMPLE_INLINE float3 reflect(float3 v, float3 n) {
    return v - n * (2.0f * dot(v, n));
}
