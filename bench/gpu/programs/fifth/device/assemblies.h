// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of assemblies.cu.
#pragma once

#include "camera.h"

#include <optix.h>

// Parts of an assembly, with an intersection program each.
enum PartKind : unsigned char { kBallPart, kDiscPart, kBoxPart, kRodPart, kPartKinds };

struct AssemblyPart {
    float3 at;     // a centre; of a rod the middle
    float3 extent; // half sides of a box; the unit axis of a disc or of a rod
    float radius, half;
    float3 color;
};

struct AssemblyParams {
    float4* image;
    OptixTraversableHandle yard;
    Camera camera;
    float3 sun;
    float reach;
    unsigned samples, openRays;
};

struct AssemblyRecord {
    const AssemblyPart* parts;
};
