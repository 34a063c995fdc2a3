// SPDX-License-Identifier: Apache-2.0
// Inputs and results of the programs of probe.cu: one ray per launch index, and for each program
// kind every value that it may query. Read by host and device compilers.
#pragma once

struct ProbeRay {
    float origin[3];
    float tmin;
    float direction[3];
    float tmax;
    float time;
    unsigned mask, flags, sbtOffset, sbtStride, missIndex;
    unsigned long long handle;
};

// Values that one run of a program saw; members that its kind may not query stay 0.
struct ProbeSeen {
    float tmin, tmax, time;
    unsigned rayFlags, mask;
    float worldOrigin[3], worldDirection[3];
    float objectOrigin[3], objectDirection[3];
    unsigned primitive, sbtGasIndex, instanceId, instanceIndex;
    unsigned hitKind, primitiveType, isTriangle, isFront, isBack, isTriangleFront, isTriangleBack;
    unsigned attributes[8];
    float barycentrics[2];
    unsigned sbtValue; // ProbeData::value of the running program's record
    unsigned launchIndex;
    unsigned transformCount;
    unsigned transformType;      // of the first transform
    unsigned transformId;        // instance id of the first transform
    unsigned long long gas, transformChild;
    float objectToWorld[12], worldToObject[12];
    float instanceMatrix[12], instanceInverse[12]; // read through the first transform's handle
    float worldPoint[3];  // object (1, 2, 3) as point,
    float worldVector[3]; // as vector
    float worldNormal[3]; // and as normal in world space
    float objectPoint[3]; // and world (1, 2, 3) in object space
};

constexpr unsigned kProbeRuns = 12;

struct ProbeResult {
    unsigned closestHits, misses, anyHits, intersections, reports, accepted;
    ProbeSeen closestHit, miss;
    ProbeSeen anyHit[kProbeRuns];
    ProbeSeen intersection[kProbeRuns];
    unsigned payload[4]; // as the caller sees them after the trace
};

struct ProbeParams {
    const ProbeRay* rays;
    ProbeResult* results;
};

// Actions of any-hit programs on a candidate.
enum ProbeRule : unsigned {
    kProbeAccept,
    kProbeIgnore,
    kProbeTerminate,
    kProbeIgnoreOdd, // odd primitive indices
    kProbeFallThrough, // neither calls anything: accepts
};

// The user part of each record.
struct ProbeData {
    unsigned value;
    unsigned rule;
    const float* spheres; // custom primitives: centre and radius by primitive index
    unsigned primitiveOffset;
    unsigned reportBoth; // report the far crossing as well
};
