// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Ray {
    float3 origin, direction;
    float time;
    unsigned mask;
};
struct Answer {
    float t; // negative: a miss
    unsigned primitive, id, index, record, kind;
    unsigned path;     // types of the transforms from the root on, as digits of base 8
    float3 point;      // (1, 2, 3) in world space
    float3 normal;     // the same as a normal
    float3 origin;     // of the ray, in the object's space
    float3 byHand;     // `point` through the list of transforms
    float3 tested;     // the origin that the intersection program has seen
    unsigned filtered; // calls of any-hit programs
};
struct Params {
    OptixTraversableHandle scene;
    const Ray* rays;
    Answer* answers;
};
