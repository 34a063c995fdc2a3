// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of bezier_patches.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

// Control points in rows along v.
struct BezierPatch {
    float3 points[16];
};

enum PatchShading : unsigned { kCeramicShading, kChromeShading, kVelvetShading, kPatchShadings };

struct BezierParams {
    float4* image;
    OptixTraversableHandle gallery;
    Camera camera;
    float3 sun;
    unsigned samples, openRays;
    float reach;
};

struct BezierRecord {
    const BezierPatch* patches; // null: a floor
};
