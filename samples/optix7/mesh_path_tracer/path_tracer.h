// SPDX-License-Identifier: Apache-2.0
// The host's side of the path tracer: uploads a scene, builds its acceleration structure and adds
// samples to a picture, launch by launch.
#pragma once

#include "host_scene.h"
#include "optix_setup.h"
#include "params.h"

class PathTracer {
public:
    // `scene` may be freed afterwards; `studio` provides everything but the mesh.
    PathTracer(OptixDeviceContext context, const HostScene& scene, const Scene& studio,
               const Camera& camera, unsigned width, unsigned height);
    PathTracer(const PathTracer&) = delete;
    PathTracer& operator=(const PathTracer&) = delete;

    // Adds `samples` for each pixel and waits for them.
    void addSamples(unsigned samples);
    unsigned samples() const { return params_.firstSample; }
    // Mean of all samples, 4 floats a pixel.
    std::vector<float> image() const { return meanOf(sum_); }
    // Discards all samples; another seed gives other noise.
    void restart(unsigned seed = 0) {
        params_.firstSample = 0;
        params_.seed = seed;
    }

    // After this call, samples also store guides for a denoiser; `previous` is the camera to which
    // flow refers. moveTo() continues with another camera and discards all samples.
    void wantGuides(const Camera& previous);
    void moveTo(const Camera& camera) {
        params_.previousCamera = params_.camera;
        params_.camera = camera;
        restart(params_.seed + 1);
    }
    std::vector<float> albedo() const { return meanOf(albedo_); }       // 4 floats a pixel
    std::vector<float> normal() const { return meanOf(normal_); }       // 4 floats a pixel
    std::vector<float> flow() const { return flow_.download<float>(); } // 2 floats a pixel

private:
    void upload(const HostScene& scene);
    void makeTable(bool hasHoles);
    void uploadLooks(const HostScene& scene);
    std::vector<float> meanOf(const DeviceBuffer& sums) const;

    unsigned width_, height_;
    Program program_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer positions_, normals_, triangles_, materialOfTriangle_, materials_;
    DeviceBuffer colors_, texcoords_, textures_, linear_;
    std::vector<DeviceBuffer> texels_;
    DeviceBuffer raygenRecord_, missRecords_, hitRecord_;
    OptixShaderBindingTable table_ = {};
    Accel accel_;
    DeviceBuffer sum_, albedo_, normal_, flow_, deviceParams_;
    Params params_ = {};
};
