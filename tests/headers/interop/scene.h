// SPDX-License-Identifier: Apache-2.0
// Shared by the host and the device side of the interop test. See interop.cpp.
#pragma once

enum Mode { kModeTriangle = 0, kModeCustom = 1, kModeThrow = 2 };

struct Result {
    unsigned int hits;   // closest-hit calls
    unsigned int misses; // miss calls
    float t;
    float barycentrics[2];
    unsigned int primitive;
    unsigned int instanceId;
    unsigned int instanceIndex;
    unsigned int hitKind;
    unsigned int front;
    unsigned int listSize;
    unsigned int listTypes[8];
    float objectToWorld[12];
    float worldToObject[12];
    float vertices[9];
    // In any-hit: the library's object-space ray, and the headers' transform of the world-space
    // one.
    float rayObject[6];
    float rayComputed[6];
    float normalWorld[3]; // of the object-space normal (0, 0, 1)
    float pointBack[3];   // world to object and back
    unsigned int payload[32];
    unsigned int attributes; // sum of attribute words, weighted by slot
    unsigned int sbtData;
    float called; // result of the direct callable
    int exceptionCode;
    unsigned int exceptionDetails[2];
};

struct Params {
    unsigned long long handle;
    Result* result;
    float origin[3];
    float direction[3];
    float time;
    int mode;
};
