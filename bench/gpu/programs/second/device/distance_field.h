// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of distance_field.cu.
#pragma once

#include "camera.h"

#include <optix.h>

enum FieldKind : unsigned { kBulb, kSponge, kGyroid, kRipples };

struct Field {
    float3 center;
    float radius; // of the box
    unsigned kind;
    float parameter;
    float3 color;
};

struct FieldRecord {
    const Field* fields;
    float precision;
};

struct FieldParams {
    float4* frame;
    unsigned width, height;
    Camera camera;
    float3 sun;
    OptixTraversableHandle root;
};
