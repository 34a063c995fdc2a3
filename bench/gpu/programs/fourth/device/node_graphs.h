// SPDX-License-Identifier: Apache-2.0
// Launch parameters, records and material nodes of node_graphs.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

// The kinds of nodes, by the numbers of the callables.
enum NodeKind : unsigned {
    kConstant,
    kPicture,
    kNoise,
    kMarble,
    kWood,
    kTiles,
    kSpots,
    kMix,
    kMultiply,
    kRamp,
    kFacing,
    kWarp,
    kNodeKinds
};

struct Node {
    unsigned kind, inputs[3]; // numbers of nodes
    float3 color;
    float scale;
};

// Where a graph is evaluated.
struct GraphPoint {
    float3 position, normal, eye;
};

struct GraphParams {
    float4* image;
    OptixTraversableHandle scene;
    const Node* nodes;
    cudaTextureObject_t pictures[2];
    Camera camera;
    float3 sun;
    unsigned samples, maxDepth;
};

struct GraphRecord {
    MeshView mesh;
    unsigned albedo, gloss; // nodes
};
