// SPDX-License-Identifier: Apache-2.0
// The smallest classic program: every launch index fills one pixel with the colour of a variable.
#include <optix_world.h>

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(float3, color, , "the colour of the picture");
rtBuffer<float4, 2> result;

RT_PROGRAM void fill() {
    result[launch_index] = optix::make_float4(color, 1.0f);
}
