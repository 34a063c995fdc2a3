// SPDX-License-Identifier: Apache-2.0
// Hit and miss programs that both pipelines of light_tracer share.
#include "light_tracer.h"
#include "tools.h"

extern "C" __global__ void __closesthit__hall() {
    const unsigned long long address =
        (unsigned long long)(optixGetPayload_0()) << 32 | optixGetPayload_1();
    HallHit* const hit = reinterpret_cast<HallHit*>(address);
    const HallRecord* record = reinterpret_cast<const HallRecord*>(optixGetSbtDataPointer());
    const unsigned triangle = optixGetPrimitiveIndex();
    const uint3 t = record->indices[triangle];
    const float3 a = record->vertices[t.x];
    const float3 normal = cross(record->vertices[t.y] - a, record->vertices[t.z] - a);
    hit->normal = towardsRay(normalize(normal));
    hit->point = rayPoint() + hit->normal * 1e-3f;
    const unsigned tint =
        hashPcg(unsigned(floorf(hit->point.x * 0.5f)) * 7u + unsigned(floorf(hit->point.z * 0.5f)));
    hit->albedo = vec(0.45f + (tint & 255u) / 800.0f, 0.55f, 0.45f + (tint >> 8 & 255u) / 800.0f);
    hit->isHit = 1;
}
extern "C" __global__ void __miss__outside() {}
extern "C" __global__ void __miss__visible() {
    optixSetPayload_0(0);
}
