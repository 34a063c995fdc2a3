// SPDX-License-Identifier: Apache-2.0
// An any-hit program adds the distances of exits and subtracts those of entries, weighted by the
// material, and ignores each hit. Payload: three sums and the number of faces.
#include "tools.h"
#include "xray.h"

extern "C" {
__constant__ XrayParams xray;
}

extern "C" __global__ void __anyhit__cross() {
    const XrayMaterial& m = *reinterpret_cast<const XrayMaterial*>(optixGetSbtDataPointer());
    const float t = optixIsFrontFaceHit() ? -optixGetRayTmax() : optixGetRayTmax();
    optixSetPayload_0(
        __float_as_uint(fmaf(m.attenuation[0], t, __uint_as_float(optixGetPayload_0()))));
    optixSetPayload_1(
        __float_as_uint(fmaf(m.attenuation[1], t, __uint_as_float(optixGetPayload_1()))));
    optixSetPayload_2(
        __float_as_uint(fmaf(m.attenuation[2], t, __uint_as_float(optixGetPayload_2()))));
    optixSetPayload_3(optixGetPayload_3() + 1);
    optixIgnoreIntersection();
}

extern "C" __global__ void __raygen__expose() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel), faces = 0;
    const XrayDetector& d = xray.detector;
    float3 dose = vec(0.0f);
    for (unsigned i = 0; i < xray.samples; ++i) {
        const float2 c = circlePoint(nextFloat(random));
        const float r = xray.spot * sqrtf(nextFloat(random));
        const float3 from = xray.source + vec(r * c.x, r * c.y, 0.0f);
        const float3 to = d.corner + d.across * ((index.x + nextFloat(random)) / size.x) +
                          d.down * ((index.y + nextFloat(random)) / size.y);
        const float3 line = to - from;
        const float distance = length(line);
        unsigned sums[4] = {0, 0, 0, 0};
        optixTrace(xray.patient, from, line * (1.0f / distance), 0.0f, distance, 0.0f,
                   OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_ENFORCE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 0, 0, 0,
                   sums[0], sums[1], sums[2], sums[3]);
        dose += vec(expf(-__uint_as_float(sums[0])), expf(-__uint_as_float(sums[1])),
                    expf(-__uint_as_float(sums[2]))) *
                xray.spectrum;
        faces += sums[3];
    }
    dose = dose / float(xray.samples);
    const float film = 1.0f - (dose.x + dose.y + dose.z);
    xray.image[pixel] = make_float4(film, film, film + 0.1f * dose.z, float(faces));
}
