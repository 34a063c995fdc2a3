// SPDX-License-Identifier: Apache-2.0
// Launch parameters of spheres.cu: one ray for each launch index.
#pragma once

struct SphereRay {
    float origin[3];
    float tmin;
    float direction[3];
    float tmax;
    unsigned flags;
};

struct SphereResult {
    unsigned closestHits, misses, anyHits;
    float t;
    unsigned primitive, sbtGasIndex, hitKind, primitiveType, isFront, isBack, isTriangle;
    float data[4]; // optixGetSphereData at the hit's indices
};

struct SphereParams {
    unsigned long long handle;
    const SphereRay* rays;
    SphereResult* results;
    unsigned ignore; // any-hit ignores this many hits
    float time;
};
