// SPDX-License-Identifier: Apache-2.0
// What device code of that time does beside the API: tables in constant memory, counters in the
// module's own memory, pointers in structures, clocks, atomics, payloads of 160 bytes, random
// numbers from hashes, launch indices of several types. A loop goes through the planes below the
// camera.
#include "common.h"

#include <optixu/optixu_math_namespace.h>
#include <optixu/optixu_matrix_namespace.h>

#include <cmath>
#include <cstring>
#include <vector>

using namespace optix;

namespace {

constexpr unsigned kWidth = 24, kHeight = 16, kStairs = 4;

struct Surface {
    float3 albedo;
    float ior;
    unsigned long long next;
};

class Walker {
public:
    Walker() {
        context_ = Context::create();
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(2);
        context_->setPrintEnabled(false);
        context_->setExceptionEnabled(RT_EXCEPTION_ALL, true);
        output_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, kWidth, kHeight);
        counters_ = context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_UNSIGNED_INT, 8, 2, 3);
        steps_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT, 4);
        context_["output_buffer"]->set(output_);
        context_["counters"]->set(counters_);
        context_["steps"]->set(steps_);
        const double exposure = 2.5;
        context_["exposure"]->setUserData(sizeof exposure, &exposure);
        context_["view"]->setMatrix4x4fv(false,
                                         Matrix4x4::translate(make_float3(0, 0, 1)).getData());
        context_->setRayGenerationProgram(0, program("camera"));
        context_->setRayGenerationProgram(1, program("show_memory"));
        context_->setExceptionProgram(0, program("exception"));
        context_->setMissProgram(0, program("outside"));
        makeSurfaces();
        Geometry geometry = context_->createGeometry();
        geometry->setPrimitiveCount(kStairs);
        geometry->setBoundingBoxProgram(program("stairs_bounds"));
        geometry->setIntersectionProgram(program("stairs"));
        Material material = context_->createMaterial();
        material->setClosestHitProgram(0, program("climb"));
        GeometryGroup group = context_->createGeometryGroup();
        group->addChild(context_->createGeometryInstance(geometry, &material, &material + 1));
        group->setAcceleration(context_->createAcceleration("MedianBvh", "Bvh"));
        context_["top_object"]->set(group);
    }
    ~Walker() { context_->destroy(); }
    Walker(const Walker&) = delete;

    void checkPicture() {
        clear();
        context_->launch(0, kWidth, kHeight);
        const float4 wanted = path();
        const auto* pixels = static_cast<const float4*>(output_->map());
        for (unsigned i = 0; i < kWidth * kHeight; ++i) {
            const float4 off = pixels[i] - wanted;
            require(dot(off, off) < 1e-6f,
                    "pixel " + std::to_string(i) + " is " + std::to_string(pixels[i].x) + ' ' +
                        std::to_string(pixels[i].w) + " in place of " + std::to_string(wanted.x) +
                        ' ' + std::to_string(wanted.w));
        }
        output_->unmap();
        const auto* counts = static_cast<const unsigned*>(counters_->map());
        for (unsigned i = 0; i < 8 * 2 * 3; ++i)
            require(counts[i] == (i % 8 == 4 && i < 16 ? kWidth * kHeight / 2 : 0),
                    "counter " + std::to_string(i) + " is " + std::to_string(counts[i]));
        counters_->unmap();
    }
    void checkMemory(unsigned launches) {
        context_->launch(1, 4);
        const auto* values = static_cast<const float*>(steps_->map());
        require(values[0] == float(launches + 4) && values[1] == 4,
                "the module's memory has " + std::to_string(values[0]));
        steps_->unmap();
    }
    void checkException() {
        context_["view"]->setMatrix4x4fv(false,
                                         (Matrix4x4::translate(make_float3(0, 0, 1)) *
                                          Matrix4x4::rotate(float(M_PI), make_float3(1, 0, 0)))
                                             .getData());
        context_->launch(0, kWidth, kHeight);
        const auto* pixels = static_cast<const float4*>(output_->map());
        for (unsigned i = 0; i < kWidth * kHeight; ++i)
            require(pixels[i].x == 5, "no exception at pixel " + std::to_string(i));
        output_->unmap();
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    void clear() {
        std::memset(counters_->map(), 0, 8 * 2 * 3 * 4);
        counters_->unmap();
    }
    // A list whose links are addresses of the device.
    void makeSurfaces() {
        list_ = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_USER, kStairs);
        list_->setElementSize(sizeof(Surface));
        auto* to = static_cast<Surface*>(list_->map());
        for (unsigned i = 0; i < kStairs; ++i)
            to[i] = surfaces_[i] = {make_float3(float(i + 1), 0.5f, 0.25f * float(i)),
                                    1 + 0.1f * float(i), 0};
        list_->unmap();
        const auto address = reinterpret_cast<unsigned long long>(list_->getDevicePointer(0));
        to = static_cast<Surface*>(list_->map());
        for (unsigned i = 0; i + 1 < kStairs; ++i)
            to[i].next = address + (i + 1) * sizeof(Surface);
        list_->unmap();
        context_["surfaces"]->setUserData(sizeof address, &address);
    }
    // The same for each pixel: straight down, from plane to plane.
    float4 path() const {
        float3 radiance = make_float3(0), attenuation = make_float3(1);
        double weight = 1;
        float history[24];
        std::fill(history, history + 24, -1.0f);
        float z = 1;
        int depth = 0, stair = -1;
        while (stair != 3) {
            ++stair;
            const Surface& surface = surfaces_[stair];
            history[4 * depth + 1] = z + 2.0f * float(stair);
            if (stair % 3 == 0)
                radiance += attenuation * surface.albedo;
            else if (stair % 3 == 1)
                attenuation *= lerp(surface.albedo, make_float3(1), 0.5f);
            else
                radiance = fmaxf(radiance, surface.albedo);
            weight *= 0.5;
            history[4 * depth] = length(radiance);
            ++depth;
            z -= 2;
        }
        constexpr float kWeights[5] = {0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f};
        float sum = 0;
        for (int i = 0; i < 5; ++i)
            sum += kWeights[i] * history[4 * i] + history[4 * i + 1];
        return make_float4(radiance * float(2.5 * weight), sum);
    }

    Context context_;
    Buffer output_, counters_, steps_, list_;
    Surface surfaces_[kStairs] = {};
};

void run() {
    Walker program;
    program.checkPicture();
    program.checkMemory(1);
    program.checkPicture();
    program.checkMemory(2);
    program.checkException();
}

} // namespace

int main() {
    return runProgram(run);
}
