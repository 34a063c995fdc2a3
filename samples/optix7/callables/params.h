// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device programs.
#pragma once

#include "camera.h"

#include <optix.h>

// Rows of the callables' part of the shader binding table.
enum Callable : unsigned {
    // Direct callables float3(Point): the colour of a surface at a point.
    kSolid,
    kChecks,
    kRings,
    kMarble,
    kPatternCount,
    // Continuation callables float3(Point, float3 color): the light that leaves the surface.
    kMatte = kPatternCount,
    kPolished,
    kMirror,
    kGlass,
    kCallableCount
};

// The record data of a callable.
struct CallableData {
    float scale; // of a pattern; index of refraction of a material
};

// A sphere; with radius 0 the square of half-width 12 in the plane y = 0.
struct Shape {
    float3 center;
    float radius;
    unsigned pattern, material; // rows of callables
    float3 colors[2];
};

struct Point {
    float3 position, local; // local: relative to the centre, in radii
    float3 normal, incoming;
    float3 colors[2];
    unsigned isInside, bounce;
};

enum RayType : unsigned { kRadianceRay, kShadowRay, kRayTypeCount };
constexpr unsigned kMaxTraceDepth = 7;
constexpr float kFloorSize = 12.0f;

struct Params {
    float4* image; // width * height pixels, top row first
    const Shape* shapes;
    Camera camera;
    float3 lightDirection; // unit length, towards the light
    OptixTraversableHandle scene;
    unsigned samplesPerAxis; // rays for each pixel: the square of this
};
