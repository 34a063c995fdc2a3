// SPDX-License-Identifier: Apache-2.0
// Small additions of OptiX 7.5 and 7.6, used through the 7.6 headers: names of errors, strides
// between instances, the geometry flag against face culling, and new fields of the denoiser's
// structs.
#include "device/probe.h"
#include "rig.h"
#include "scene.h"

#include <cmath>

namespace tests::api {
namespace {

class Later : public ApiTest {};

TEST_F(Later, NamesOfErrors) {
    EXPECT_STREQ("OPTIX_ERROR_NOT_COMPATIBLE", optixGetErrorName(OPTIX_ERROR_NOT_COMPATIBLE));
    EXPECT_STREQ("OPTIX_ERROR_DEVICE_OUT_OF_MEMORY",
                 optixGetErrorName(OPTIX_ERROR_DEVICE_OUT_OF_MEMORY));
    EXPECT_STRNE(optixGetErrorString(OPTIX_ERROR_NOT_COMPATIBLE),
                 optixGetErrorString(OPTIX_ERROR_DEVICE_OUT_OF_MEMORY));
}

TEST_F(Later, InstanceStride) {
    TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    constexpr unsigned kStride = 112;
    Buffer memory(3 * kStride);
    for (unsigned i = 0; i < 3; ++i) {
        const OptixInstance instance = instanceOf(gas.handle, translation(10.0f * float(i), 0, 0));
        std::memcpy(memory.as<char>() + i * kStride, &instance, sizeof(instance));
    }
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input.instanceArray.instances = memory.address();
    input.instanceArray.numInstances = 3;
    input.instanceArray.instanceStride = kStride;
    const Buffer box(sizeof(OptixAabb));
    buildAccel(context_, log_, {input}, 0, {{box.address(), OPTIX_PROPERTY_TYPE_AABBS}});
    EXPECT_NEAR(0.0f, box.as<OptixAabb>()->minX, 1e-4f);
    EXPECT_NEAR(21.0f, box.as<OptixAabb>()->maxX, 1e-4f);
    for (unsigned stride : {16u, 79u, 81u, 88u}) {
        input.instanceArray.instanceStride = stride;
        OptixAccelBuildOptions options = buildOptions(0);
        OptixAccelBufferSizes sizes{};
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelComputeMemoryUsage", "instanceStride",
                        optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes));
    }
}

TEST_F(Later, RelocationInputsOfInstances) {
    TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    InstanceList list({instanceOf(gas.handle, identity())});
    const Accel ias = buildAccel(context_, log_, {list.input});
    OptixRelocationInfo info{};
    ASSERT_OK(optixAccelGetRelocationInfo(context_, ias.handle, &info));
    EXPECT_NE(0u, info.info[0] | info.info[1] | info.info[2] | info.info[3]);
    const Buffer handles(std::vector<OptixTraversableHandle>{gas.handle});
    OptixRelocateInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input.instanceArray.numInstances = 1;
    input.instanceArray.traversableHandles = handles.address();
    OptixTraversableHandle moved = 0;
    const auto relocate = [&](size_t count) {
        return optixAccelRelocate(context_, nullptr, &info, &input, count, ias.memory.address(),
                                  ias.memory.size(), &moved);
    };
    EXPECT_OK(relocate(1));
    EXPECT_EQ(ias.handle, moved);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelRelocate", "numRelocateInputs",
                    relocate(2));
    input.instanceArray.numInstances = 2;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelRelocate", "numInstances", relocate(1));
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    input.triangleArray = {1, {0}};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelRelocate", "type", relocate(1));
    waitForDevice();
}

class LaterTraversal : public DeviceTest {};

TEST_P(LaterTraversal, GeometryMayRefuseFaceCulling) {
    auto r = rig("probe", compileOptions(4));
    r->raygenRecord(r->raygen("__raygen__probe"));
    r->missRecord(r->miss("__miss__probe"), ProbeData{1, 0, nullptr, 0, 0});
    r->hitRecord(r->hit("__closesthit__probe", "__anyhit__probe"),
                 ProbeData{1000, kProbeAccept, nullptr, 0, 0});
    r->link();
    TriangleMesh mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    for (const unsigned flag : {unsigned(OPTIX_GEOMETRY_FLAG_NONE),
                                unsigned(OPTIX_GEOMETRY_FLAG_DISABLE_TRIANGLE_FACE_CULLING)}) {
        mesh.input.triangleArray.flags = &flag;
        const Accel gas = buildAccel(context_, log_, {mesh.input});
        std::vector<ProbeRay> rays;
        for (const unsigned cull : {OPTIX_RAY_FLAG_CULL_FRONT_FACING_TRIANGLES,
                                    OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES}) {
            ProbeRay ray{};
            ray.origin[2] = 1;
            ray.direction[2] = -1;
            ray.tmax = 10;
            ray.mask = 255;
            ray.flags = cull;
            ray.sbtStride = 1;
            ray.handle = gas.handle;
            rays.push_back(ray);
        }
        const Buffer rayMemory(rays), results(rays.size() * sizeof(ProbeResult));
        r->run(ProbeParams{rayMemory.as<const ProbeRay>(), results.as<ProbeResult>()}, 2);
        unsigned hits = 0;
        for (unsigned i = 0; i < 2; ++i)
            hits += results.as<ProbeResult>()[i].closestHits;
        EXPECT_EQ(flag == OPTIX_GEOMETRY_FLAG_NONE ? 1u : 2u, hits);
    }
}
INSTANTIATE_DEVICE_TEST(LaterTraversal);

// ---- the denoiser ----

class LaterDenoiser : public ApiTest {
protected:
    static constexpr unsigned kWidth = 24, kHeight = 16;

    void TearDown() override {
        if (denoiser_)
            EXPECT_OK(optixDenoiserDestroy(denoiser_));
        ApiTest::TearDown();
    }
    void create(OptixDenoiserModelKind kind) {
        if (denoiser_)
            ASSERT_OK(optixDenoiserDestroy(denoiser_));
        const OptixDenoiserOptions options{};
        ASSERT_OK(optixDenoiserCreate(context_, kind, &options, &denoiser_));
        ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser_, kWidth, kHeight, &sizes_));
        state_ = Buffer(sizes_.stateSizeInBytes);
        scratch_ = Buffer(sizes_.withoutOverlapScratchSizeInBytes);
        ASSERT_OK(optixDenoiserSetup(denoiser_, nullptr, kWidth, kHeight, state_.address(),
                                     state_.size(), scratch_.address(), scratch_.size()));
    }
    OptixImage2D image(const Buffer& memory, OptixPixelFormat format, unsigned pixel) {
        return {memory.address(), kWidth, kHeight, kWidth * pixel, pixel, format};
    }
    OptixResult invoke(const OptixDenoiserLayer& layer,
                       const OptixDenoiserGuideLayer& guides = {}) {
        const OptixResult result =
            optixDenoiserInvoke(denoiser_, nullptr, &params_, state_.address(), state_.size(),
                                &guides, &layer, 1, 0, 0, scratch_.address(), scratch_.size());
        waitForDevice();
        return result;
    }

    OptixDenoiser denoiser_ = nullptr;
    OptixDenoiserSizes sizes_{};
    OptixDenoiserParams params_{};
    Buffer state_, scratch_;
};

TEST_F(LaterDenoiser, ScratchOfStatistics) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR);
    Buffer pixels(size_t(kWidth) * kHeight * 16), answer(12);
    for (unsigned i = 0; i < kWidth * kHeight * 4; ++i)
        pixels.as<float>()[i] = 0.5f;
    const OptixImage2D input = image(pixels, OPTIX_PIXEL_FORMAT_FLOAT4, 16);
    const Buffer forColor(sizes_.computeAverageColorSizeInBytes);
    const Buffer forIntensity(sizes_.computeIntensitySizeInBytes);
    EXPECT_OK(optixDenoiserComputeIntensity(denoiser_, nullptr, &input, answer.address(),
                                            forIntensity.address(), forIntensity.size()));
    waitForDevice();
    EXPECT_NEAR(0.18f / 0.5f, answer.as<float>()[0], 1e-3f);
    EXPECT_OK(optixDenoiserComputeAverageColor(denoiser_, nullptr, &input, answer.address(),
                                               forColor.address(), forColor.size()));
    waitForDevice();
    EXPECT_NEAR(std::log(0.5f), answer.as<float>()[2], 1e-3f);
}

TEST_F(LaterDenoiser, AlphaModes) {
    const size_t count = size_t(kWidth) * kHeight;
    Buffer in(count * 16), out(count * 16);
    for (unsigned i = 0; i < count; ++i)
        for (unsigned c = 0; c < 4; ++c) // alpha is noise
            in.as<float>()[4 * i + c] = c == 3 ? float(i * 7919 % 97) / 97 : 0.5f;
    OptixDenoiserLayer layer{};
    layer.input = image(in, OPTIX_PIXEL_FORMAT_FLOAT4, 16);
    layer.output = image(out, OPTIX_PIXEL_FORMAT_FLOAT4, 16);
    for (const OptixDenoiserAlphaMode mode :
         {OPTIX_DENOISER_ALPHA_MODE_COPY, OPTIX_DENOISER_ALPHA_MODE_ALPHA_AS_AOV,
          OPTIX_DENOISER_ALPHA_MODE_FULL_DENOISE_PASS}) {
        create(OPTIX_DENOISER_MODEL_KIND_AOV);
        params_.denoiseAlpha = mode;
        ASSERT_OK(invoke(layer));
        double changed = 0;
        for (unsigned i = 0; i < count; ++i)
            changed += std::fabs(in.as<float>()[4 * i + 3] - out.as<float>()[4 * i + 3]);
        if (mode == OPTIX_DENOISER_ALPHA_MODE_COPY)
            EXPECT_EQ(0.0, changed);
        else
            EXPECT_GT(changed, 0.05 * double(count)) << unsigned(mode);
    }
    params_.denoiseAlpha = 3;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDenoiserInvoke", "denoiseAlpha",
                    invoke(layer));
}

// A first frame has no predecessor: flow and previous output are not read.
TEST_F(LaterDenoiser, FirstFramesOfSequences) {
    create(OPTIX_DENOISER_MODEL_KIND_TEMPORAL);
    const size_t count = size_t(kWidth) * kHeight;
    Buffer in(count * 16), out(count * 16), previous(count * 16), flow(count * 8);
    for (unsigned i = 0; i < count * 4; ++i)
        in.as<float>()[i] = float(i * 7919 % 97) / 97;
    previous.fill(0);
    flow.fill(0);
    OptixDenoiserLayer layer{};
    layer.input = image(in, OPTIX_PIXEL_FORMAT_FLOAT4, 16);
    layer.output = image(out, OPTIX_PIXEL_FORMAT_FLOAT4, 16);
    params_.temporalModeUsePreviousLayers = 0;
    ASSERT_OK(invoke(layer));
    const float first = out.as<float>()[0];
    params_.temporalModeUsePreviousLayers = 1;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDenoiserInvoke", "previousOutput",
                    invoke(layer));
    layer.previousOutput = image(previous, OPTIX_PIXEL_FORMAT_FLOAT4, 16);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDenoiserInvoke", "flow", invoke(layer));
    OptixDenoiserGuideLayer guides{};
    guides.flow = image(flow, OPTIX_PIXEL_FORMAT_FLOAT2, 8);
    ASSERT_OK(invoke(layer, guides));
    EXPECT_TRUE(std::isfinite(first) && std::isfinite(out.as<float>()[0]));
}

} // namespace
} // namespace tests::api
