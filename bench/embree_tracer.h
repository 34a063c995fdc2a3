// SPDX-License-Identifier: Apache-2.0
// The samples' path tracer in C++ over Embree: the peer of the OptiX path tracer. Same mathematics
// (shading.h), rays one at a time, TBB over tiles.
#pragma once

#include "host_scene.h"

#include <embree3/rtcore.h>

#include <vector>

class EmbreeTracer {
public:
    // `scene` must outlive the tracer.
    EmbreeTracer(const HostScene& scene, const Scene& studio, const Camera& camera, unsigned width,
                 unsigned height);
    EmbreeTracer(const EmbreeTracer&) = delete;
    EmbreeTracer& operator=(const EmbreeTracer&) = delete;
    ~EmbreeTracer();

    void addSamples(unsigned samples);
    std::vector<float> image() const; // mean, 4 floats a pixel
    void restart();

private:
    unsigned width_, height_, samples_ = 0;
    Scene scene_;
    Camera camera_;
    RTCDevice device_;
    RTCScene embree_;
    std::vector<float> sum_;
};
