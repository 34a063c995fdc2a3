// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of latticework.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

enum LatticePattern : unsigned { kSolidWall, kRoundHoles, kDiamonds, kSpirals, kCrumbs };

// Where x^2 + z^2 + bend * y^2 = size, with lengths in units of the axes, between two heights.
struct LatticeShell {
    float3 at, axes;
    float bend, size, low, high;
    unsigned pattern;
    float columns, rows; // of holes: around the axis, and for a unit of height
    float3 color;
};

struct LatticeParams {
    float4* image;
    OptixTraversableHandle court;
    Camera camera;
    float3 sun, lamp; // a direction, a place
    float softness;
    unsigned samples, sunRays, maxLayers;
};

struct LatticeRecord {
    const LatticeShell* shells; // null: a floor
};
