// SPDX-License-Identifier: Apache-2.0
#pragma once
enum { kCloths = 3, kProbes = 256 };
struct Cloth {
    OptixTraversableHandle handle;
    const float3* corners; // the vertices of this frame
    const uint3* triangles;
    float tint[2];
};
struct Params {
    int frame;
    Cloth cloths[kCloths];
    float heights[2][kCloths][kProbes]; // filled by the programs; read back by the host
};
