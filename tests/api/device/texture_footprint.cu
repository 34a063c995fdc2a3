// SPDX-License-Identifier: Apache-2.0
// Footprints of one place of a mipmapped texture: plain, two levels of one level of detail, gradient.
#include <optix.h>

#include "texture_footprint.h"

extern "C" {
__constant__ FootprintParams params;
}

extern "C" __global__ void __raygen__footprint() {
    const unsigned i = optixGetLaunchIndex().x;
    const unsigned info = 4u << 24 | 3u << 20 | 3u << 16 | 1u << 5 | 1u; // groups of 8 x 8 texels
    FootprintResult& result = params.results[i];
    uint4 words;
    unsigned single = 7;
    switch (i) {
    case 0:
        words = optixTexFootprint2D(params.texture, info, 0.51f, 0.51f, &single);
        break;
    case 1:
    case 2:
        words = optixTexFootprint2DLod(params.texture, info, 0.51f, 0.51f, 1.5f, i == 2, &single);
        break;
    default:
        words = optixTexFootprint2DGrad(params.texture, info, 0.51f, 0.51f, 4.0f / 256, 0, 0,
                                        4.0f / 256, false, &single);
    }
    result.words[0] = words.x;
    result.words[1] = words.y;
    result.words[2] = words.z;
    result.words[3] = words.w;
    result.single = single;
    result.undefined = optixUndefinedValue() & 0;
}
