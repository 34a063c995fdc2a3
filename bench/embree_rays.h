// SPDX-License-Identifier: Apache-2.0
// Embree on the rays and meshes of optix_rays.h.
#pragma once

#include "optix_rays.h"

#include <embree3/rtcore.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace bench {

// The Embree side.
inline RTCScene embreeScene(RTCDevice device, const Mesh& mesh) {
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh.vertices.data(), 0, 12, mesh.numVertices());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.indices.data(), 0, 12, mesh.numTriangles());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    return scene;
}

inline RTCRay embreeRay(const Ray& r) {
    RTCRay ray = {};
    ray.org_x = r.origin[0], ray.org_y = r.origin[1], ray.org_z = r.origin[2];
    ray.dir_x = r.direction[0], ray.dir_y = r.direction[1], ray.dir_z = r.direction[2];
    ray.tnear = r.tmin, ray.tfar = r.tmax, ray.mask = ~0u;
    return ray;
}

// Stores the results that the device programs store.
inline void traceEmbree(RTCScene scene, Optix::Kind kind, const std::vector<Ray>& rays,
                        std::vector<BenchHit>& hits, bool motion = false) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, rays.size(), 256), [&](const auto& range) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (size_t i = range.begin(); i < range.end(); ++i) {
            if (kind == Optix::kClosest) {
                RTCRayHit hit;
                hit.ray = embreeRay(rays[i]);
                hit.ray.time = motion ? timeOfRay(unsigned(i)) : 0;
                hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(scene, &context, &hit);
                const bool found = hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
                hits[i] = {found ? hit.ray.tfar : -1.0f, found ? hit.hit.primID : ~0u};
            } else {
                RTCRay ray = embreeRay(rays[i]);
                ray.time = motion ? timeOfRay(unsigned(i)) : 0;
                rtcOccluded1(scene, &context, &ray);
                hits[i].primitive = ray.tfar < 0;
            }
        }
    });
}

} // namespace bench
