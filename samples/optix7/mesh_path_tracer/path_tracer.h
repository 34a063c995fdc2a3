// SPDX-License-Identifier: Apache-2.0
// The host's side of the path tracer: uploads a scene, builds its acceleration structure and adds
// samples to a picture, launch by launch.
#pragma once

#include "host_scene.h"
#include "optix_setup.h"
#include "params.h"

class PathTracer {
public:
    // `scene` may be dropped afterwards; `studio` gives everything but the mesh.
    PathTracer(OptixDeviceContext context, const HostScene& scene, const Scene& studio,
               const Camera& camera, unsigned width, unsigned height);
    PathTracer(const PathTracer&) = delete;
    PathTracer& operator=(const PathTracer&) = delete;

    // Adds `samples` for each pixel and waits for them.
    void addSamples(unsigned samples);
    unsigned samples() const { return params_.firstSample; }
    // Mean of all samples, 4 floats a pixel.
    std::vector<float> image() const;
    // Forgets all samples.
    void restart() { params_.firstSample = 0; }

private:
    void upload(const HostScene& scene);
    void makeTable();

    unsigned width_, height_;
    Program program_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer positions_, normals_, triangles_, materialOfTriangle_, materials_;
    DeviceBuffer raygenRecord_, missRecords_, hitRecord_;
    OptixShaderBindingTable table_ = {};
    Accel accel_;
    DeviceBuffer sum_, deviceParams_;
    Params params_ = {};
};
