// SPDX-License-Identifier: Apache-2.0
// Texture footprints from device code, with a texture of the CUDA driver library. The contents of
// footprints are tested beside the sampler (src/texture/footprint_test.cpp).
#include "device/texture_footprint.h"
#include "device_memory.h"
#include "rig.h"

namespace tests::api {
namespace {

class TextureFootprint : public testing::TestWithParam<std::string> {
protected:
    void SetUp() override {
        loadLibrary();
        ASSERT_EQ(CUDA_SUCCESS, cuInit(0));
        ASSERT_EQ(CUDA_SUCCESS, cuDevicePrimaryCtxRetain(&primary_, 0));
        ASSERT_EQ(CUDA_SUCCESS, cuCtxSetCurrent(primary_));
        OptixDeviceContextOptions options{};
        options.logCallbackFunction = LogRecord::callback;
        options.logCallbackData = &log_;
        options.logCallbackLevel = 4;
        ASSERT_EQ(OPTIX_SUCCESS, optixDeviceContextCreate(nullptr, &options, &context_));
    }
    void TearDown() override {
        EXPECT_EQ(OPTIX_SUCCESS, optixDeviceContextDestroy(context_));
        cuCtxSetCurrent(nullptr);
        cuDevicePrimaryCtxRelease(0);
    }
    CUcontext primary_ = nullptr;
    LogRecord log_;
    OptixDeviceContext context_ = nullptr;
};

TEST_P(TextureFootprint, OfOnePlace) {
    CUDA_ARRAY3D_DESCRIPTOR shape{};
    shape.Width = shape.Height = 256;
    shape.Format = CU_AD_FORMAT_FLOAT;
    shape.NumChannels = 1;
    CUmipmappedArray array = nullptr;
    ASSERT_EQ(CUDA_SUCCESS, cuMipmappedArrayCreate(&array, &shape, 4));
    CUDA_RESOURCE_DESC resource{};
    resource.resType = CU_RESOURCE_TYPE_MIPMAPPED_ARRAY;
    resource.res.mipmap.hMipmappedArray = array;
    CUDA_TEXTURE_DESC description{};
    description.filterMode = description.mipmapFilterMode = CU_TR_FILTER_MODE_LINEAR;
    description.flags = CU_TRSF_NORMALIZED_COORDINATES;
    description.maxMipmapLevelClamp = 3;
    CUtexObject texture = 0;
    ASSERT_EQ(CUDA_SUCCESS, cuTexObjectCreate(&texture, &resource, &description, nullptr));

    Rig rig(context_, log_, compiledPtx("texture_footprint", GetParam()), compileOptions());
    rig.raygenRecord(rig.raygen("__raygen__footprint"));
    rig.link();
    Buffer results(4 * sizeof(FootprintResult));
    rig.run(FootprintParams{results.as<FootprintResult>(), texture}, 4);
    // Level 0: texels 130 and 131 of both axes, group 16, the first of block 2.
    // Level 1: texels 64 and 65, group 8, the first of block 1.
    // Level 2: texels 32 and 33, group 4, bit 4 + 8 * 4 of block 0.
    const unsigned expected[4][5] = {{1, 0, 2, 2, 1},
                                     {1, 0, 1, 1 | 1 << 12, 0},
                                     {0, 1 << 4, 0, 2 << 12, 0},
                                     {0, 1 << 4, 0, 2 << 12, 1}};
    for (unsigned i = 0; i < 4; ++i) {
        SCOPED_TRACE(i);
        const FootprintResult& r = results.as<FootprintResult>()[i];
        for (unsigned k = 0; k < 4; ++k)
            EXPECT_EQ(expected[i][k], r.words[k]) << k;
        EXPECT_EQ(expected[i][4], r.single);
    }
    cuTexObjectDestroy(texture);
    cuMipmappedArrayDestroy(array);
    if (onGpu())
        return; // a GPU reports the former texture, or its replacement
    rig.run(FootprintParams{results.as<FootprintResult>(), texture}, 4);
    for (unsigned i = 0; i < 4; ++i)
        EXPECT_EQ(0u, results.as<FootprintResult>()[i].words[0]) << "of a handle that is not alive";
}

INSTANTIATE_TEST_SUITE_P(Compiler, TextureFootprint, testing::ValuesIn(toolchains()),
                         [](const auto& info) { return info.param; });

} // namespace
} // namespace tests::api
