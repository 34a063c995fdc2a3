// SPDX-License-Identifier: Apache-2.0
// What most programs of the third and the later sets have: a scene, programs, one pipeline with a
// table, and a picture. shapes.h has their meshes, ../second/kit.h the parts.
#pragma once

#include "../second/kit.h"
#include "shapes.h"

#include "device/mesh.h"
#include "sampling.h"

#include <cmath>

namespace bench {

class Renderer : public Application {
public:
    double compileTime() const override { return programs_.compileTime(); }
    std::vector<float> picture() override { return image_.download<float>(); }

protected:
    Renderer(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height) {}
    // Black, `width` and `height` are those of the settings by default.
    float4* allocatePicture(unsigned width = 0, unsigned height = 0) {
        image_.allocate(sizeof(float4) * (width ? width : width_) * (height ? height : height_));
        CUDA_CHECK(cudaMemset(image_.data(), 0, image_.size()));
        return image_.as<float4>();
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    OptixPipeline pipeline_ = nullptr;
    unsigned width_, height_;

private:
    DeviceBuffer image_;
};

inline MeshView viewOf(const MeshMemory& mesh) {
    return {reinterpret_cast<const float3*>(mesh.vertices),
            reinterpret_cast<const uint3*>(mesh.indices)};
}

// Addresses in host and device code of vectors that a scene keeps.
template <class T>
CUdeviceptr addressOf(Scene& scene, const std::vector<T>& data) {
    return reinterpret_cast<CUdeviceptr>(scene.upload(data));
}

template <class T>
JobKind thirdJob(const char* name, const char* summary, double meanTolerance,
                 double pixelTolerance) {
    return applicationJob<T>("third", name, summary, meanTolerance, pixelTolerance);
}

} // namespace bench
