// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of molecules.cu.
#pragma once

#include "camera.h"

#include <optix.h>

constexpr unsigned kElements = 5;

// Ways to colour, by the numbers of the callables.
enum Coloring : unsigned { kByElement, kByChain, kByCharge, kColorings };

struct MoleculeParams {
    float4* image;
    OptixTraversableHandle cell;
    Camera camera;
    float3 sun;
    float reach;    // of ambient occlusion
    float fogStart; // distance
    unsigned openRays, contourRays;
    float contourWidth; // in pixels
};

struct MoleculeRecord {
    float3 color;
    float gloss;
};
