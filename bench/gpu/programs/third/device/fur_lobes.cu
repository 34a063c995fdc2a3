// SPDX-License-Identifier: Apache-2.0
// The three lobes of Marschner 2003 with Gaussian profiles: light that a strand reflects, lets
// through, and reflects inside.
#include "fur.h"

DEVICE float gaussian(float width, float x) {
    return expf(-0.5f * x * x / (width * width)) / (2.5066f * width);
}
// Along the strand, tilted by its scales.
DEVICE float along(const FurAngles& a, float tilt, float width) {
    const float theta = 0.5f * (asinf(fmaxf(-1.0f, fminf(1.0f, a.sinLight))) +
                                asinf(fmaxf(-1.0f, fminf(1.0f, a.sinEye))));
    return gaussian(width * a.roughness, theta - tilt);
}
DEVICE float fresnel(float cosine) {
    const float edge = 1.0f - fminf(fmaxf(cosine, 0.0f), 1.0f);
    return 0.046f + 0.954f * edge * edge * edge * edge * edge;
}
DEVICE float3 absorbed(float3 absorption, float length) {
    return vec(expf(-absorption.x * length), expf(-absorption.y * length),
               expf(-absorption.z * length));
}
// The path inside, for the offset at which the ray enters.
DEVICE float chord(const FurAngles& a) {
    const float h = a.offset / 1.55f;
    const float lean = sqrtf(fmaxf(0.05f, 1.0f - a.sinEye * a.sinEye));
    return 2.0f * sqrtf(fmaxf(0.0f, 1.0f - h * h)) / lean;
}

extern "C" __device__ float3 __direct_callable__reflected(const FurAngles& a) {
    const float half = sqrtf(fmaxf(0.0f, 0.5f + 0.5f * a.cosAround));
    return vec(along(a, -0.07f, 1.0f) * 0.25f * half * fresnel(half) * 6.0f);
}
extern "C" __device__ float3 __direct_callable__transmitted(const FurAngles& a) {
    const float pass = 1.0f - fresnel(sqrtf(fmaxf(0.0f, 1.0f - a.offset * a.offset)));
    const float around = gaussian(0.5f, acosf(fmaxf(-1.0f, fminf(1.0f, -a.cosAround))));
    return absorbed(a.absorption, chord(a)) * (along(a, 0.035f, 0.5f) * pass * pass * around);
}
extern "C" __device__ float3 __direct_callable__twice(const FurAngles& a) {
    const float f = fresnel(sqrtf(fmaxf(0.0f, 1.0f - a.offset * a.offset)));
    const float around = 0.4f + 0.6f * powf(fmaxf(0.0f, 0.5f + 0.5f * a.cosAround), 6.0f);
    return absorbed(a.absorption, 2.0f * chord(a)) *
           (along(a, 0.1f, 2.0f) * (1.0f - f) * (1.0f - f) * (0.1f + f) * around);
}
