// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Params {
    OptixTraversableHandle spheres;
    const float4* balls;         // centre and radius
    unsigned long long* reports; // of all rays
    uint2* result;               // balls met; bits of the sum of distances
    unsigned limit;
};
