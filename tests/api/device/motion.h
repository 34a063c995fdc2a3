// SPDX-License-Identifier: Apache-2.0
// Shared by the host and the device side of motion.cu.
#pragma once

struct MotionRay {
    float origin[3], direction[3];
    float time;
    unsigned rayFlags;
};

struct MotionSeen {
    unsigned hit; // 0: missed, 1: closest-hit ran
    unsigned primitive, instanceId;
    unsigned transforms, types[8];
    float t, rayTime;
    float hitTime;                // values that the hit program read
    float object[6], computed[6]; // object-space ray: as any-hit sees it, and by the helpers
    float back[3], normal[3];     // origin to object space and back; a normal to world space
    float toWorld[12], toObject[12];
    float vertices[9];
    float begin, end; // of the structure that was hit
    unsigned steps;
    unsigned anyHits;
    unsigned long long gas, motionChild; // child of the last motion transform in the list
    unsigned motionKeys;
};

struct MotionParams {
    unsigned long long handle;
    const MotionRay* rays;
    MotionSeen* seen;
    const float* boxes; // of custom primitives: keys times count times 6 floats
    unsigned boxCount, boxKeys;
    float boxBegin, boxEnd;
    unsigned dump; // print the transforms of hits
    unsigned sbtIndex;
};
