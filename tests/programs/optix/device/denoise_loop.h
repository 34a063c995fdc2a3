// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Params {
    float3* beauty; // packed in three floats
    float4* albedo;
    float* normal; // three floats in rows of their own length
    float2* flow;
    unsigned width, normalRow, frame;
    float shift;
};
