// SPDX-License-Identifier: Apache-2.0
// Camera paths: light that comes from lamps directly, plus the splats of light paths.
#include "light_tracer_rays.h"

extern "C" __global__ void __raygen__eye() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned pixel = index.y * params.width + index.x;
    unsigned random = hashPcg(pixel ^ 0x5bd1e995u);
    const float3 direction =
        cameraDirection(params.camera, (index.x + nextFloat(random)) / params.width,
                        (index.y + nextFloat(random)) / params.height);
    const HallHit hit = findHit(params.camera.eye, direction);
    float3 light = vec(0.0f);
    for (unsigned i = 0; hit.isHit && i < params.numLamps; ++i) {
        const TracerLamp& lamp = params.lamps[i];
        const float a = nextFloat(random), b = nextFloat(random);
        const float3 on = lamp.corner + lamp.u * a + lamp.v * b, to = on - hit.point;
        const float squared = dot(to, to), distance = sqrtf(squared);
        const float cosine = dot(hit.normal, to) / distance;
        const float facing = -dot(cross(lamp.u, lamp.v), to) / distance;
        if (cosine > 0.0f && facing > 0.0f && areVisible(hit.point, on))
            light += hit.albedo * lamp.emission * (cosine * facing / (kPi * squared));
    }
    const float* const splats = params.film + 3 * pixel;
    light += vec(splats[0], splats[1], splats[2]);
    params.image[pixel] = withWeight(light, 1.0f);
}
