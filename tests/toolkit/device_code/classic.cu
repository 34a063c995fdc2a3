// SPDX-License-Identifier: Apache-2.0
#include <optix_world.h>

rtBuffer<unsigned int, 1> image;
rtDeclareVariable(uint2, launchIndex, rtLaunchIndex, );

RT_PROGRAM void squares() {
    image[launchIndex.x] = launchIndex.x * launchIndex.x;
}
