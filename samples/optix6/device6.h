// SPDX-License-Identifier: Apache-2.0
// Code that device files of the classic samples share: the camera's variables and random numbers.
#pragma once

#include <optix_world.h>

rtDeclareVariable(optix::uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(optix::uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(optix::float3, eye, , "the camera's place");
rtDeclareVariable(optix::float3, camera_right, , "from the middle to the right edge");
rtDeclareVariable(optix::float3, camera_up, , "from the middle to the upper edge");
rtDeclareVariable(optix::float3, camera_forward, , "to the middle of the picture");

// The direction through a point of the launch index, both coordinates from 0 to 1.
static __device__ __forceinline__ optix::float3 cameraDirection(float x, float y) {
    const float u = (launch_index.x + x) / launch_dim.x * 2.0f - 1.0f;
    const float v = 1.0f - (launch_index.y + y) / launch_dim.y * 2.0f;
    return optix::normalize(camera_forward + camera_right * u + camera_up * v);
}

// A hash whose bits are all usable (O'Neill 2014).
static __device__ __forceinline__ unsigned hash(unsigned value) {
    const unsigned state = value * 747796405u + 2891336453u;
    const unsigned word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
static __device__ __forceinline__ float random(unsigned& seed) {
    seed = hash(seed);
    return (seed >> 8) * (1.0f / 16777216.0f);
}
