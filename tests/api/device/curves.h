// SPDX-License-Identifier: Apache-2.0
// Launch parameters of curves.cu: one ray for each launch index.
#pragma once

struct CurveRay {
    float origin[3];
    float tmin;
    float direction[3];
    float tmax;
    unsigned flags;
};

struct CurveResult {
    unsigned closestHits, misses, anyHits;
    float t, u;
    float anyHitT, anyHitU, anyHitTmax; // of the last any-hit call
    unsigned primitive, sbtGasIndex, hitKind, primitiveType, isFront, isBack, isTriangle;
    float points[16]; // by the getter of the hit's type, at the hit's indices
};

// Actions of any-hit.
enum CurveRule : unsigned { kCurveAccept, kCurveIgnore, kCurveTerminate, kCurveIgnoreFirstTwo };

struct CurveParams {
    unsigned long long handle;
    const CurveRay* rays;
    CurveResult* results;
    unsigned rule;
    float time; // of rays and getters
};
