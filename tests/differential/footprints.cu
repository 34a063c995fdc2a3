// SPDX-License-Identifier: Apache-2.0
// Texture footprints, one call a launch index.
#include "optix76/optix.h"

#include "footprints.h"

using namespace differential;

extern "C" {
__constant__ FootprintParams params;
}

extern "C" __global__ void __raygen__footprints() {
    const unsigned i = optixGetLaunchIndex().x;
    const FootprintCall& call = params.calls[i];
    uint4 words;
    unsigned single = 7;
    if (call.form == kPlain)
        words = optixTexFootprint2D(call.texture, call.info, call.x, call.y, &single);
    else if (call.form == kLod)
        words = optixTexFootprint2DLod(call.texture, call.info, call.x, call.y, call.level,
                                       call.coarse != 0, &single);
    else
        words = optixTexFootprint2DGrad(call.texture, call.info, call.x, call.y, call.dx[0],
                                        call.dx[1], call.dy[0], call.dy[1], call.coarse != 0,
                                        &single);
    FootprintSeen& seen = params.seen[i];
    seen.words[0] = words.x;
    seen.words[1] = words.y;
    seen.words[2] = words.z;
    seen.words[3] = words.w;
    seen.single = single;
}
