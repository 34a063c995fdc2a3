// SPDX-License-Identifier: Apache-2.0
// Any-hit programs that keep lists in the caller's memory: the nearest photons around a hit, and
// the nearest hits along a ray. Payload: the address of the list, or the hit.
#include "common.h"

constexpr unsigned kMost = 8;

// Sorted by distance, nearest first.
struct List {
    unsigned count;
    float distance[kMost];
    unsigned item[kMost];
};
DEVICE List& listOf() {
    return *reinterpret_cast<List*>((unsigned long long)(optixGetPayload_1()) << 32 |
                                    optixGetPayload_0());
}
DEVICE void insert(List& list, float distance, unsigned item) {
    if (list.count == kMost && distance >= list.distance[kMost - 1])
        return;
    unsigned at = list.count < kMost ? list.count++ : kMost - 1;
    // Equal distances are ordered by number, so that the order of calls does not matter.
    for (; at > 0 && (list.distance[at - 1] > distance ||
                      (list.distance[at - 1] == distance && list.item[at - 1] > item));
         --at) {
        list.distance[at] = list.distance[at - 1];
        list.item[at] = list.item[at - 1];
    }
    list.distance[at] = distance;
    list.item[at] = item;
}
DEVICE void gather(unsigned long long scene, float3 origin, float3 direction, float reach,
                   unsigned record, List& list) {
    list.count = 0;
    const unsigned long long address = reinterpret_cast<unsigned long long>(&list);
    unsigned low = unsigned(address), high = unsigned(address >> 32), no = 0;
    optixTrace(scene, origin, direction, 0.0f, reach, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT | OPTIX_RAY_FLAG_ENFORCE_ANYHIT, record, 1, 1, low,
               high, no, no);
}

// ---- Photons: spheres that contain the origin of a ray without length --------------------------

extern "C" __global__ void __intersection__photon() {
    const Item& photon = params.items[optixGetPrimitiveIndex()];
    const float3 to = optixGetObjectRayOrigin() - photon.at;
    const float squared = dot(to, to);
    if (squared < photon.radius * photon.radius)
        optixReportIntersection(optixGetRayTmin(), 0, __float_as_uint(squared));
}
extern "C" __global__ void __anyhit__photon() {
    insert(listOf(), __uint_as_float(optixGetAttribute_0()), optixGetPrimitiveIndex());
    optixIgnoreIntersection();
}

extern "C" __global__ void __closesthit__surface() {
    bool back;
    const float3 normal = facing(triangleNormal(), back);
    optixSetPayload_0(__float_as_uint(normal.x));
    optixSetPayload_1(__float_as_uint(normal.y));
    optixSetPayload_2(__float_as_uint(normal.z));
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
}
extern "C" __global__ void __miss__none() {
    optixSetPayload_3(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__list() {}

extern "C" __global__ void __raygen__photons() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i) {
        const float3 direction = cameraRay(random);
        unsigned x = 0, y = 0, z = 0, t = 0;
        optixTrace(params.scene, params.camera.eye, direction, 0.0f, 1e16f, 0.0f,
                   OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, x, y, z, t);
        const float distance = __uint_as_float(t);
        if (distance < 0.0f) {
            sum += skyColor(direction);
            continue;
        }
        List list;
        gather(params.photons, params.camera.eye + direction * distance, asFloats(x, y, z), 1e-6f,
               1, list);
        if (list.count == 0)
            continue;
        const float area = kPi * maxOf(list.distance[list.count - 1], 1e-8f);
        sum += vec(1.0f, 0.9f, 0.8f) * (float(list.count) / (area * params.reach));
    }
    store(sum / float(params.samples));
}

// ---- Multi-hit ----------------------------------------------------------------------------------

extern "C" __global__ void __anyhit__keep() {
    insert(listOf(), optixGetRayTmax(), optixGetPrimitiveIndex());
    optixIgnoreIntersection();
}

extern "C" __global__ void __raygen__layers() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i) {
        List list;
        const float3 direction = cameraRay(random);
        gather(params.scene, params.camera.eye, direction, 1e16f, 0, list);
        float clear = 1.0f;
        for (unsigned k = 0; k < list.count; ++k) {
            const unsigned seed = hashPcg(list.item[k] / 2);
            const float3 color = vec((seed & 255) / 255.0f, 0.6f, (seed >> 8 & 255) / 255.0f);
            sum += color * (clear * 0.3f);
            clear *= 0.7f;
        }
        sum += skyColor(direction) * clear;
    }
    store(sum / float(params.samples));
}
