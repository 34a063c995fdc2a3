// SPDX-License-Identifier: Apache-2.0
// Inputs and results of the device programs of the differential suite.
#pragma once

namespace differential {

struct TestRay {
    float origin[3], tmin;
    float direction[3], tmax;
    float time;
    unsigned mask, flags, sbtOffset, sbtStride, missIndex;
    unsigned long long handle;
};

enum Outcome : unsigned { kNothing, kMiss, kHit, kException };

// The outcome of one ray; members without a value stay 0.
struct Seen {
    unsigned outcome;
    float t;        // of the hit, or tmax as the miss program sees it
    unsigned value; // of the program's record
    unsigned attributes[2];
    unsigned primitive, sbtGasIndex, instanceIndex, instanceId;
    unsigned hitKind, primitiveType, sides; // sides: front, back, triangle, triangle front and back
    unsigned rayFlags, mask;
    unsigned transforms; // how many, and four bits for the type of each
    float time;
    float objectToWorld[12], worldToObject[12];
    float worldPoint[3], worldNormal[3]; // of (1, 2, 3)
    float geometry[16];                  // vertices as random access gives them
    unsigned payload[2];                 // as the caller sees them after the trace
    int exception;
    unsigned exceptionDetails[2];
};

// What any-hit programs do with a candidate.
enum Rule : unsigned {
    kAccept,
    kIgnoreOdd,     // odd primitives
    kIgnorePattern, // a checkerboard in barycentrics
    kTerminate,
    kIgnoreAll,
};

struct RecordData {
    unsigned value;
    unsigned rule;
    const float* spheres; // of custom primitives: centre and radius
};

struct Params {
    const TestRay* rays;
    Seen* seen;
};

} // namespace differential
