// SPDX-License-Identifier: Apache-2.0
// Functions that the host headers define themselves: loading the library, stack sizes, tiling of
// denoiser images. Test functions in the table replace those of the library.
#include <optix.h>
#include <optix_denoiser_tiling.h>
#include <optix_function_table_definition.h>
#include <optix_stack_size.h>
#include <optix_stubs.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace {

bool tableIsEmpty() {
    const OptixFunctionTable empty = {};
    return std::memcmp(&empty, &g_optixFunctionTable, sizeof(empty)) == 0;
}

class Stubs : public ::testing::Test {
protected:
    void SetUp() override { clear(); }
    void TearDown() override { clear(); }
    static void clear() {
        unsetenv("FAKE_OPTIX_RESULT");
        g_optixFunctionTable = OptixFunctionTable{};
    }
};

// ---- Loading. The library found is chosen by ctest through LD_LIBRARY_PATH.

TEST_F(Stubs, LoadsTheLibraryAndUnloadsIt) {
    void* handle = nullptr;
    ASSERT_EQ(optixInitWithHandle(&handle), OPTIX_SUCCESS);
    ASSERT_NE(handle, nullptr);
    EXPECT_STREQ(optixGetErrorName(OPTIX_SUCCESS), "from the library");
    EXPECT_EQ(optixUninitWithHandle(handle), OPTIX_SUCCESS);
    EXPECT_TRUE(tableIsEmpty());
}

TEST_F(Stubs, InitNeedsNoHandle) {
    EXPECT_EQ(optixInitWithHandle(nullptr), OPTIX_SUCCESS);
    EXPECT_EQ(optixInit(), OPTIX_SUCCESS);
    EXPECT_FALSE(tableIsEmpty());
}

TEST_F(Stubs, RefusalOfTheLibraryIsReturnedAndLeavesAnEmptyTable) {
    setenv("FAKE_OPTIX_RESULT", "7801", 1);
    void* handle = &handle;
    EXPECT_EQ(optixInitWithHandle(&handle), OPTIX_ERROR_UNSUPPORTED_ABI_VERSION);
    EXPECT_EQ(handle, nullptr);
    EXPECT_TRUE(tableIsEmpty());
    EXPECT_STREQ(optixGetErrorName(OPTIX_ERROR_UNSUPPORTED_ABI_VERSION),
                 "OPTIX_ERROR_UNSUPPORTED_ABI_VERSION");
}

TEST_F(Stubs, UninitOfNothingIsAnError) {
    EXPECT_EQ(optixUninitWithHandle(nullptr), OPTIX_ERROR_INVALID_VALUE);
}

TEST_F(Stubs, CallsBeforeInitAreErrors) {
    OptixDeviceContext context = nullptr;
    EXPECT_EQ(optixDeviceContextCreate(nullptr, nullptr, &context), OPTIX_ERROR_INVALID_OPERATION);
    EXPECT_EQ(optixLaunch(nullptr, nullptr, 0, 0, nullptr, 1, 1, 1), OPTIX_ERROR_INVALID_OPERATION);
    EXPECT_STREQ(optixGetErrorName(OPTIX_ERROR_LIBRARY_NOT_FOUND), "OPTIX_ERROR_LIBRARY_NOT_FOUND");
    EXPECT_STREQ(optixGetErrorString(OPTIX_SUCCESS), "Success");
    EXPECT_STREQ(optixGetErrorName(static_cast<OptixResult>(12345)),
                 "Unrecognized OptixResult code");
}

// ---- Stack sizes. A program group of these tests is the sizes it reports.

OptixResult groupSizes(OptixProgramGroup group, OptixStackSizes* sizes) {
    if (!group)
        return OPTIX_ERROR_INVALID_VALUE;
    *sizes = *reinterpret_cast<const OptixStackSizes*>(group);
    return OPTIX_SUCCESS;
}

OptixProgramGroup asGroup(OptixStackSizes& sizes) {
    return reinterpret_cast<OptixProgramGroup>(&sizes);
}

class StackSizes : public Stubs {
protected:
    void SetUp() override {
        Stubs::SetUp();
        g_optixFunctionTable.optixProgramGroupGetStackSize = groupSizes;
    }
    unsigned int traversal = 1, state = 1, continuation = 1;
    // RG, MS, CH, AH, IS, CC, DC
    const OptixStackSizes sizes = {100, 20, 30, 7, 40, 5, 11};
};

TEST_F(StackSizes, AccumulateTakesTheLargestOfEach) {
    OptixStackSizes a = {1, 9, 3, 0, 5, 0, 7}, b = {2, 8, 4, 6, 0, 1, 0}, sum = {};
    EXPECT_EQ(optixUtilAccumulateStackSizes(asGroup(a), &sum), OPTIX_SUCCESS);
    EXPECT_EQ(optixUtilAccumulateStackSizes(asGroup(b), &sum), OPTIX_SUCCESS);
    const OptixStackSizes expected = {2, 9, 4, 6, 5, 1, 7};
    EXPECT_EQ(std::memcmp(&sum, &expected, sizeof(sum)), 0);
    EXPECT_EQ(optixUtilAccumulateStackSizes(asGroup(a), nullptr), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(optixUtilAccumulateStackSizes(nullptr, &sum), OPTIX_ERROR_INVALID_VALUE);
}

TEST_F(StackSizes, ContinuationStackFollowsTheFormula) {
    // cssRG + CC tree + (depth - 1) * (max(CH, MS) + CC tree) + max(that, IS + AH)
    const auto size = [&](unsigned int traceDepth, unsigned int ccDepth) {
        EXPECT_EQ(optixUtilComputeStackSizes(&sizes, traceDepth, ccDepth, 2, &traversal, &state,
                                             &continuation),
                  OPTIX_SUCCESS);
        EXPECT_EQ(traversal, 22u);
        EXPECT_EQ(state, 22u);
        return continuation;
    };
    EXPECT_EQ(size(0, 0), 100u);
    EXPECT_EQ(size(0, 2), 110u);
    EXPECT_EQ(size(1, 0), 100u + 47u);
    EXPECT_EQ(size(3, 0), 100u + 2 * 30u + 47u);
    EXPECT_EQ(size(1, 4), 120u + 50u);
    EXPECT_EQ(size(3, 4), 120u + 3 * 50u);
}

TEST_F(StackSizes, CallTreesCanBeGivenWhole) {
    EXPECT_EQ(
        optixUtilComputeStackSizesCssCCTree(&sizes, 50, 2, 3, &traversal, &state, &continuation),
        OPTIX_SUCCESS);
    EXPECT_EQ(traversal, 33u);
    EXPECT_EQ(state, 33u);
    EXPECT_EQ(continuation, 100u + 50u + 80u + 80u);
}

TEST_F(StackSizes, DirectCallablesCanBeToldApart) {
    EXPECT_EQ(optixUtilComputeStackSizesDCSplit(&sizes, 8, 16, 1, 0, 2, 3, &traversal, &state,
                                                &continuation),
              OPTIX_SUCCESS);
    EXPECT_EQ(traversal, 16u);
    EXPECT_EQ(state, 48u);
    EXPECT_EQ(continuation, 147u);
}

TEST_F(StackSizes, ResultsMayBeNullInputsNot) {
    EXPECT_EQ(optixUtilComputeStackSizes(&sizes, 1, 0, 0, nullptr, nullptr, nullptr),
              OPTIX_SUCCESS);
    EXPECT_EQ(optixUtilComputeStackSizes(nullptr, 1, 0, 0, &traversal, &state, &continuation),
              OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(
        optixUtilComputeStackSizesCssCCTree(nullptr, 0, 1, 0, &traversal, &state, &continuation),
        OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(optixUtilComputeStackSizesDCSplit(nullptr, 0, 0, 1, 0, 0, 0, &traversal, &state,
                                                &continuation),
              OPTIX_ERROR_INVALID_VALUE);
}

TEST_F(StackSizes, PathTracer) {
    OptixStackSizes rg = {64, 0, 0, 0, 0, 0, 0}, ms1 = {0, 90, 0, 0, 0, 0, 0};
    OptixStackSizes ch1[] = {{0, 0, 30, 0, 0, 0, 0}, {0, 0, 70, 0, 0, 0, 0}};
    OptixStackSizes ms2 = {0, 10, 0, 0, 0, 0, 0}, ch2 = {0, 0, 25, 0, 0, 0, 0};
    OptixProgramGroup groups1[] = {asGroup(ch1[0]), asGroup(ch1[1])};
    OptixProgramGroup groups2[] = {asGroup(ch2)};
    const auto compute = [&](unsigned int count1, OptixProgramGroup miss2, unsigned int count2) {
        return optixUtilComputeStackSizesSimplePathTracer(asGroup(rg), asGroup(ms1), groups1,
                                                          count1, miss2, groups2, count2,
                                                          &traversal, &state, &continuation);
    };
    EXPECT_EQ(compute(2, asGroup(ms2), 1), OPTIX_SUCCESS);
    EXPECT_EQ(continuation, 64u + 70u + 25u);
    EXPECT_EQ(traversal + state, 0u);
    EXPECT_EQ(compute(1, asGroup(ms2), 1), OPTIX_SUCCESS);
    EXPECT_EQ(continuation, 64u + 90u); // the miss program needs more
    EXPECT_EQ(compute(2, nullptr, 0), OPTIX_SUCCESS);
    EXPECT_EQ(continuation, 64u + 90u);
    EXPECT_EQ(optixUtilComputeStackSizesSimplePathTracer(asGroup(rg), asGroup(ms1), nullptr, 1,
                                                         nullptr, nullptr, 0, nullptr, nullptr,
                                                         nullptr),
              OPTIX_ERROR_INVALID_VALUE);
}

// ---- Tiling.

OptixImage2D image(unsigned int width, unsigned int height, OptixPixelFormat format,
                   CUdeviceptr data = 0x100000) {
    OptixImage2D result = {data, width, height, 0, 0, format};
    result.rowStrideInBytes = width * optixUtilGetPixelStride(result);
    return result;
}

TEST(Tiling, PixelStrides) {
    const struct {
        OptixPixelFormat format;
        unsigned int size;
    } formats[] = {{OPTIX_PIXEL_FORMAT_HALF2, 4},   {OPTIX_PIXEL_FORMAT_HALF3, 6},
                   {OPTIX_PIXEL_FORMAT_HALF4, 8},   {OPTIX_PIXEL_FORMAT_FLOAT2, 8},
                   {OPTIX_PIXEL_FORMAT_FLOAT3, 12}, {OPTIX_PIXEL_FORMAT_FLOAT4, 16},
                   {OPTIX_PIXEL_FORMAT_UCHAR3, 3},  {OPTIX_PIXEL_FORMAT_UCHAR4, 4}};
    for (const auto& f : formats) {
        OptixImage2D i = {0, 1, 1, 0, 0, f.format};
        EXPECT_EQ(optixUtilGetPixelStride(i), f.size);
        i.pixelStrideInBytes = 20;
        EXPECT_EQ(optixUtilGetPixelStride(i), 20u);
    }
    EXPECT_EQ(optixUtilGetPixelStride({0, 1, 1, 0, 0, static_cast<OptixPixelFormat>(1)}), 0u);
}

// Checks that every output pixel is written once, from a tile that contains its neighbourhood.
void checkCover(unsigned int width, unsigned int height, unsigned int tileWidth,
                unsigned int tileHeight, unsigned int overlap) {
    const OptixImage2D in = image(width, height, OPTIX_PIXEL_FORMAT_HALF3);
    const OptixImage2D out = image(width, height, OPTIX_PIXEL_FORMAT_FLOAT4, 0x900000);
    std::vector<OptixUtilDenoiserImageTile> tiles;
    ASSERT_EQ(optixUtilDenoiserSplitImage(in, out, overlap, tileWidth, tileHeight, tiles),
              OPTIX_SUCCESS);
    std::vector<int> written(size_t(width) * height);
    for (const auto& tile : tiles) {
        EXPECT_EQ(tile.input.width, std::min(width, tileWidth + 2 * overlap));
        EXPECT_EQ(tile.input.height, std::min(height, tileHeight + 2 * overlap));
        const unsigned int inY = unsigned((tile.input.data - in.data) / in.rowStrideInBytes);
        const unsigned int inX = unsigned((tile.input.data - in.data) % in.rowStrideInBytes / 6);
        const unsigned int outY = unsigned((tile.output.data - out.data) / out.rowStrideInBytes);
        const unsigned int outX =
            unsigned((tile.output.data - out.data) % out.rowStrideInBytes / 16);
        EXPECT_EQ(tile.inputOffsetX, outX - inX);
        EXPECT_EQ(tile.inputOffsetY, outY - inY);
        EXPECT_LE(inX, outX < overlap ? 0 : outX - overlap);
        EXPECT_GE(inX + tile.input.width, std::min(width, outX + tile.output.width + overlap));
        EXPECT_LE(inY, outY < overlap ? 0 : outY - overlap);
        EXPECT_GE(inY + tile.input.height, std::min(height, outY + tile.output.height + overlap));
        EXPECT_LE(inX + tile.input.width, width);
        EXPECT_LE(inY + tile.input.height, height);
        for (unsigned int y = outY; y < outY + tile.output.height; ++y)
            for (unsigned int x = outX; x < outX + tile.output.width; ++x)
                ++written.at(size_t(y) * width + x);
    }
    for (int count : written)
        ASSERT_EQ(count, 1);
}

TEST(Tiling, TilesCoverImagesOfAllSizes) {
    for (unsigned int size = 1; size < 40; ++size)
        for (unsigned int tile : {1u, 3u, 8u, 64u})
            for (unsigned int overlap : {0u, 1u, 5u})
                checkCover(size, 41 - size, tile, tile + 2, overlap);
}

TEST(Tiling, HugeTilesDoNotOverflow) {
    checkCover(10, 10, 0xFFFFFFFFu - 20, 0xFFFFFFFFu - 20, 10);
    std::vector<OptixUtilDenoiserImageTile> tiles;
    const OptixImage2D i = image(10, 10, OPTIX_PIXEL_FORMAT_FLOAT4);
    EXPECT_EQ(optixUtilDenoiserSplitImage(i, i, 0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu, tiles),
              OPTIX_SUCCESS);
    EXPECT_EQ(tiles.size(), 1u);
}

TEST(Tiling, BadArguments) {
    std::vector<OptixUtilDenoiserImageTile> tiles;
    const OptixImage2D i = image(8, 8, OPTIX_PIXEL_FORMAT_FLOAT4);
    OptixImage2D unknown = i;
    unknown.format = static_cast<OptixPixelFormat>(3);
    const auto split = [&](const OptixImage2D& in, const OptixImage2D& out, unsigned int w,
                           unsigned int h) {
        return optixUtilDenoiserSplitImage(in, out, 1, w, h, tiles);
    };
    EXPECT_EQ(split(i, i, 0, 4), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(split(i, i, 4, 0), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(split(unknown, i, 4, 4), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(split(i, unknown, 4, 4), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(split(i, image(8, 9, OPTIX_PIXEL_FORMAT_FLOAT4), 4, 4), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(split(image(0, 8, OPTIX_PIXEL_FORMAT_FLOAT4), i, 4, 4), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_TRUE(tiles.empty());
}

struct Invocation {
    OptixDenoiserGuideLayer guide;
    std::vector<OptixDenoiserLayer> layers;
    unsigned int x, y;
};
std::vector<Invocation> gInvocations;

OptixResult recordInvoke(OptixDenoiser, CUstream, const OptixDenoiserParams*, CUdeviceptr, size_t,
                         const OptixDenoiserGuideLayer* guide, const OptixDenoiserLayer* layers,
                         unsigned int numLayers, unsigned int x, unsigned int y, CUdeviceptr,
                         size_t) {
    gInvocations.push_back({*guide, {layers, layers + numLayers}, x, y});
    return gInvocations.size() == 5 ? OPTIX_ERROR_CUDA_ERROR : OPTIX_SUCCESS;
}

class InvokeTiled : public Stubs {
protected:
    void SetUp() override {
        Stubs::SetUp();
        gInvocations.clear();
        g_optixFunctionTable.optixDenoiserInvoke = recordInvoke;
    }
    OptixResult invoke(unsigned int count, unsigned int tile, const OptixDenoiserLayer* all,
                       const OptixDenoiserGuideLayer* guides) {
        return optixUtilDenoiserInvokeTiled(nullptr, nullptr, nullptr, 0, 0, guides, all, count, 0,
                                            0, 2, tile, tile);
    }
    const OptixImage2D full = image(20, 10, OPTIX_PIXEL_FORMAT_FLOAT4);
    const OptixDenoiserLayer layers[2] = {{full, {}, full}, {full, full, full}};
    const OptixDenoiserGuideLayer guide = {full, {}, image(20, 10, OPTIX_PIXEL_FORMAT_HALF2)};
};

TEST_F(InvokeTiled, EachTileGetsItsPartOfEachImage) {
    EXPECT_EQ(invoke(2, 10, layers, &guide), OPTIX_SUCCESS);
    ASSERT_EQ(gInvocations.size(), 2u); // 12 + 8 columns
    const Invocation& second = gInvocations[1];
    EXPECT_EQ(second.x, 6u); // input is 14 wide and ends with the image
    EXPECT_EQ(second.y, 0u);
    ASSERT_EQ(second.layers.size(), 2u);
    EXPECT_EQ(second.layers[0].input.data, full.data + 6 * 16);
    EXPECT_EQ(second.layers[0].output.data, full.data + 12 * 16);
    EXPECT_EQ(second.layers[0].previousOutput.data, 0u);
    EXPECT_EQ(second.layers[1].previousOutput.data, full.data + 6 * 16);
    EXPECT_EQ(second.guide.albedo.data, full.data + 6 * 16);
    EXPECT_EQ(second.guide.normal.data, 0u);
    EXPECT_EQ(second.guide.flow.data, full.data + 6 * 4);
}

TEST_F(InvokeTiled, FirstErrorEndsIt) {
    EXPECT_EQ(invoke(1, 2, layers, &guide), OPTIX_ERROR_CUDA_ERROR);
    EXPECT_EQ(gInvocations.size(), 5u);
}

TEST_F(InvokeTiled, BadArguments) {
    EXPECT_EQ(invoke(1, 4, nullptr, &guide), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(invoke(1, 4, layers, nullptr), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(invoke(0, 4, layers, &guide), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_EQ(invoke(1, 0, layers, &guide), OPTIX_ERROR_INVALID_VALUE);
    OptixDenoiserGuideLayer wrong = guide;
    wrong.albedo = image(21, 10, OPTIX_PIXEL_FORMAT_FLOAT4);
    EXPECT_EQ(invoke(1, 4, layers, &wrong), OPTIX_ERROR_INVALID_VALUE);
    const OptixDenoiserLayer none = {{}, {}, full};
    EXPECT_EQ(invoke(1, 4, &none, &guide), OPTIX_ERROR_INVALID_VALUE);
    EXPECT_TRUE(gInvocations.empty());
}

} // namespace
