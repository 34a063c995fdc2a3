// SPDX-License-Identifier: Apache-2.0
#include "embree_tracer.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace {

// Traces rays for tracePath().
class EmbreeRays {
public:
    explicit EmbreeRays(RTCScene scene) : scene_(scene) {}

    Hit closest(float3 origin, float3 direction) const {
        RTCRayHit query;
        query.ray = makeRay(origin, direction, std::numeric_limits<float>::infinity());
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_, &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            return {-1.0f, 0, 0.0f, 0.0f};
        return {query.ray.tfar, query.hit.primID, query.hit.u, query.hit.v};
    }

    bool visible(float3 origin, float3 direction, float distance) const {
        RTCRay ray = makeRay(origin, direction, distance);
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene_, &context, &ray);
        return ray.tfar >= 0.0f;
    }

private:
    static RTCRay makeRay(float3 origin, float3 direction, float distance) {
        RTCRay ray = {};
        ray.org_x = origin.x;
        ray.org_y = origin.y;
        ray.org_z = origin.z;
        ray.dir_x = direction.x;
        ray.dir_y = direction.y;
        ray.dir_z = direction.z;
        ray.tfar = distance;
        ray.mask = ~0u;
        return ray;
    }

    RTCScene scene_;
};

} // namespace

EmbreeTracer::EmbreeTracer(const HostScene& scene, const Scene& studio, const Camera& camera,
                           unsigned width, unsigned height)
    : width_(width), height_(height), scene_(studio), camera_(camera),
      device_(rtcNewDevice(nullptr)), embree_(nullptr), sum_(size_t(width) * height * 4) {
    if (!device_)
        throw std::runtime_error("Embree has no device");
    scene_.mesh = {scene.positions.data(), scene.normals.data(), scene.triangles.data(),
                   scene.materialOfTriangle.data(), scene.materials.data()};
    embree_ = rtcNewScene(device_);
    RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree reads 16 bytes at the last vertex, so the vertices are copied to its own buffer.
    void* vertices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             sizeof(float3), scene.positions.size());
    std::copy(scene.positions.begin(), scene.positions.end(), static_cast<float3*>(vertices));
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               scene.triangles.data(), 0, sizeof(uint3), scene.triangles.size());
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(embree_, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(embree_);
}

EmbreeTracer::~EmbreeTracer() {
    rtcReleaseScene(embree_);
    rtcReleaseDevice(device_);
}

void EmbreeTracer::addSamples(unsigned samples) {
    EmbreeRays rays(embree_);
    tbb::parallel_for(tbb::blocked_range2d<unsigned>(0, height_, 16, 0, width_, 16),
                      [&](const tbb::blocked_range2d<unsigned>& tile) {
                          for (unsigned y = tile.rows().begin(); y < tile.rows().end(); ++y)
                              for (unsigned x = tile.cols().begin(); x < tile.cols().end(); ++x) {
                                  float3 sum = vec(0.0f);
                                  for (unsigned i = 0; i < samples; ++i)
                                      sum += samplePixel(scene_, rays, camera_, x, y, width_,
                                                         height_, samples_ + i);
                                  float* pixel = &sum_[(size_t(y) * width_ + x) * 4];
                                  pixel[0] += sum.x;
                                  pixel[1] += sum.y;
                                  pixel[2] += sum.z;
                                  pixel[3] = 1.0f;
                              }
                      });
    samples_ += samples;
}

std::vector<float> EmbreeTracer::image() const {
    std::vector<float> mean = sum_;
    for (float& value : mean)
        value /= float(std::max(samples_, 1u));
    return mean;
}

void EmbreeTracer::restart() {
    std::fill(sum_.begin(), sum_.end(), 0.0f);
    samples_ = 0;
}
