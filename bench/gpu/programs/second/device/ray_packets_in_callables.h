// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of ray_packets_in_callables.cu.
#pragma once

#include "camera.h"

#include <optix.h>

// The order of the callables.
enum NetworkNodeKind : unsigned {
    kLightNode,
    kAmbientNode,
    kMirrorNode,
    kInfluenceNode,
    kSumNode,
    kChoiceNode,
    kPatternCallable // direct; of the kind above
};

struct NetworkNode {
    unsigned kind;
    unsigned a, b; // other nodes
    float3 color;
    float value;
};

struct InfluenceBall {
    float3 center;
    float radius;
    float3 color;
};

struct NetworkParams {
    float4* image;
    OptixTraversableHandle scene;
    OptixTraversableHandle influences;
    const InfluenceBall* balls;
    const NetworkNode* nodes;
    Camera camera;
    float3 sun;
    float reach;
    unsigned maxDepth;
};

struct NetworkRecord {
    const float3* vertices;
    const uint3* indices;
    unsigned root; // node
};
