// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Ray {
    float3 origin, direction;
    float time;
};
struct Answer {
    float t;        // negative: a miss
    unsigned id;    // of the instance
    unsigned depth; // of the list of transforms
    unsigned outer; // id of the outermost instance
    float3 local;   // the hit in the object's space
    float3 world;   // the same through the transform of points
};
struct Params {
    OptixTraversableHandle scene;
    const Ray* rays;
    Answer* answers;
    struct {
        unsigned stride, count;
    } layout[2];
};
