// SPDX-License-Identifier: Apache-2.0
// Launch parameters of gaussians.cu.
#pragma once

#include "camera.h"

#include <optix.h>

struct Gaussian {
    float4 rows[3]; // from the world to the space where its deviations are 1
    float4 color;   // and the opacity in w
    float4 tint[3]; // change of the colour with the direction, for each channel
};

struct GaussianParams {
    float4* image;
    const Gaussian* gaussians;
    OptixTraversableHandle handle;
    Camera camera;
    float leastTransmittance;
    unsigned maxRounds;
};
