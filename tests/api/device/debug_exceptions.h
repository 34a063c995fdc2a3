// SPDX-License-Identifier: Apache-2.0
// Shared by debug_exceptions.cu and its test: one kind of mistake per launch index.
#pragma once

#include "optix.h"

enum Mistake : unsigned {
    kFine,
    kDeepTrace,          // -2
    kBadTraversable,     // -5: garbage
    kBadMiss,            // -6
    kBadHit,             // -7
    kBadRay,             // -9
    kWrongParameters,    // -10
    kCallableOutOfRange, // -12
    kNoDirect,           // -13
    kNoContinuation,     // -14
    kListIndex,          // -16 of optixGetTransformListHandle in closest-hit
    kBadGasForVertices,  // -16 of optixGetTriangleVertexData
    kBadPrimitive,       // -17
    kBadSbtGasIndex,     // -18
    kNoVertexAccess,     // -32
    kNoInstanceAccess,   // -32
    kBadInstance,        // -17 of optixGetInstanceTraversableFromIAS
    kDeepCallables,      // -1
    kDeepRecursion,      // -1
    kReportKind,         // -17 of optixReportIntersection
    kAnyHitFlags,        // -16: ray flags that exclude each other
    kFaceFlags,          // -16
    kThrowCode,          // -16: a user exception with a negative code
    kMistakes,
    kLargeFrames, // -1, in a separate program: GPU compilers refuse such frames
};

struct DebugResult {
    int code;
    unsigned reached; // 1 after the mistake
    unsigned listSize, listType, sbtGasIndex;
    OptixTraversableHandle traversable;
    int sbtOffset;
    float ray[9];
    unsigned expected, passed, callableIndex;
    char name[32]; // of the callable
    char line[128];
    unsigned detail;
};

struct DebugParams {
    DebugResult* results;
    OptixTraversableHandle ias;       // one instance of gas, both with random access
    OptixTraversableHandle gas;
    OptixTraversableHandle plainIas;  // without random access
    OptixTraversableHandle plainGas;
    OptixTraversableHandle customs;
    unsigned mistake; // kMistakes: launch index modulo kMistakes
};
