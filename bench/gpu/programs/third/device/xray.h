// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of xray.cu.
#pragma once

#include "vec.h"

#include <optix.h>

struct XrayDetector {
    float3 corner, across, down;
};

struct XrayParams {
    float4* image;
    OptixTraversableHandle patient;
    XrayDetector detector;
    float3 source;
    float spot; // its radius
    unsigned samples;
    float3 spectrum; // shares of three energies
};

struct XrayMaterial {
    float attenuation[3]; // per length, at the energies
};
