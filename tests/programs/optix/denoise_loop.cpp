// SPDX-License-Identifier: Apache-2.0
// The denoiser in the loop of an animation: programs draw noise into the buffers that the denoiser
// reads, all on one stream, in formats and strides that the renderer chooses. A temporal denoiser
// goes from frame to frame; a second one works in tiles. Both must bring the picture closer to the
// truth, and tiles must give what the whole gives.
#include "common.h"

#include <optix_denoiser_tiling.h>
#include <optix_function_table_definition.h>

#include <algorithm>
#include <cmath>

#include "device/denoise_loop.h"

namespace {

constexpr unsigned kWidth = 144, kHeight = 96, kNormalRow = 3 * kWidth + 16, kFrames = 4;

OptixImage2D image(CUdeviceptr data, OptixPixelFormat format, unsigned pixel, unsigned row) {
    OptixImage2D made = {};
    made.data = data;
    made.width = kWidth;
    made.height = kHeight;
    made.format = format;
    made.pixelStrideInBytes = pixel;
    made.rowStrideInBytes = row;
    return made;
}

float truth(unsigned i, unsigned channel, float shift) {
    const float x = float(i % kWidth) + shift, y = float(i / kWidth);
    const bool dark = (int(std::floor(x / 16)) + int(std::floor(y / 16))) & 1;
    const float dim[3] = {.2f, .3f, .6f}, bright[3] = {.8f, .7f, .4f};
    return (dark ? dim : bright)[channel] *
           (0.5f + 0.5f * std::sin(0.05f * x) * std::cos(0.04f * y));
}

double errorOf(const std::vector<float>& seen, float shift) {
    double sum = 0;
    for (unsigned i = 0; i < kWidth * kHeight; ++i)
        for (unsigned c = 0; c < 3; ++c) {
            const double d = seen[3 * i + c] - truth(i, c, shift);
            sum += d * d;
        }
    return std::sqrt(sum / (3 * kWidth * kHeight));
}

struct Denoiser {
    Denoiser(OptixDeviceContext context, OptixDenoiserModelKind kind, bool normals,
             unsigned tileWidth, unsigned tileHeight, cudaStream_t stream)
        : tileWidth(tileWidth), tileHeight(tileHeight) {
        OptixDenoiserOptions options = {};
        options.guideAlbedo = 1;
        options.guideNormal = normals;
        OPTIX_TRY(optixDenoiserCreate(context, kind, &options, &handle));
        OPTIX_TRY(optixDenoiserComputeMemoryResources(handle, tileWidth, tileHeight, &sizes));
        state.resize(sizes.stateSizeInBytes);
        scratch.resize(
            std::max(sizes.withOverlapScratchSizeInBytes, sizes.withoutOverlapScratchSizeInBytes));
        intensity.resize(sizeof(float));
        const unsigned overlap = sizes.overlapWindowSizeInPixels;
        const bool tiled = tileWidth < kWidth || tileHeight < kHeight;
        OPTIX_TRY(optixDenoiserSetup(handle, stream, tiled ? tileWidth + 2 * overlap : tileWidth,
                                     tiled ? tileHeight + 2 * overlap : tileHeight, state.ptr(),
                                     state.size, scratch.ptr(), scratch.size));
    }
    ~Denoiser() { optixDenoiserDestroy(handle); }
    OptixDenoiser handle = nullptr;
    OptixDenoiserSizes sizes = {};
    Buffer state, scratch, intensity;
    unsigned tileWidth, tileHeight;
};

bool run() {
    OptixDeviceContext context = makeContext();
    auto options = pipelineOptions(0, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS);
    OptixModule module = makeModule(context, options);
    const OptixProgramGroup raygen = raygenGroup(context, module, "__raygen__draw"),
                            miss = missGroup(context, module, "__miss__none");
    OptixPipeline pipeline = makePipeline(context, options, {raygen, miss}, 0);
    Buffer table(std::vector<Record<Nothing>>{packed(raygen, Nothing()), packed(miss, Nothing())});
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = table.ptr();
    sbt.missRecordBase = table.ptr() + sizeof(Record<Nothing>);
    sbt.missRecordStrideInBytes = sizeof(Record<Nothing>);
    sbt.missRecordCount = 1;

    cudaStream_t stream = nullptr;
    CUDA_TRY(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking));
    const size_t pixels = kWidth * kHeight;
    Buffer beauty(pixels * 12), albedo(pixels * 16), normal(kNormalRow * kHeight * 4),
        flow(pixels * 8), output(pixels * 12), previous(pixels * 12), whole(pixels * 12),
        tiles(pixels * 12), params(sizeof(Params));
    bool right = true;
    {
        Denoiser temporal(context, OPTIX_DENOISER_MODEL_KIND_TEMPORAL, true, kWidth, kHeight,
                          stream);
        Denoiser plain(context, OPTIX_DENOISER_MODEL_KIND_HDR, false, kWidth, kHeight, stream);
        Denoiser tiled(context, OPTIX_DENOISER_MODEL_KIND_HDR, false, 64, 48, stream);
        double noisy = 0, temporalError = 0, plainError = 0, between = 0;
        for (unsigned frame = 0; frame < kFrames; ++frame) {
            const float shift = -2.0f * frame;
            const Params values = {beauty.as<float3>(),
                                   albedo.as<float4>(),
                                   normal.as<float>(),
                                   flow.as<float2>(),
                                   kWidth,
                                   kNormalRow,
                                   frame,
                                   shift};
            CUDA_TRY(cudaMemcpyAsync(params.data, &values, sizeof values, cudaMemcpyHostToDevice,
                                     stream));
            OPTIX_TRY(optixLaunch(pipeline, stream, params.ptr(), sizeof values, &sbt, kWidth,
                                  kHeight, 1));
            OptixDenoiserGuideLayer guides = {};
            guides.albedo = image(albedo.ptr(), OPTIX_PIXEL_FORMAT_FLOAT4, 16, 16 * kWidth);
            guides.normal = image(normal.ptr(), OPTIX_PIXEL_FORMAT_FLOAT3, 12, 4 * kNormalRow);
            guides.flow = image(flow.ptr(), OPTIX_PIXEL_FORMAT_FLOAT2, 8, 8 * kWidth);
            OptixDenoiserLayer layer = {};
            layer.input = image(beauty.ptr(), OPTIX_PIXEL_FORMAT_FLOAT3, 12, 12 * kWidth);
            layer.output = image(output.ptr(), OPTIX_PIXEL_FORMAT_FLOAT3, 12, 12 * kWidth);
            layer.previousOutput = image(frame ? previous.ptr() : beauty.ptr(),
                                         OPTIX_PIXEL_FORMAT_FLOAT3, 12, 12 * kWidth);
            OptixDenoiserParams how = {};
            OPTIX_TRY(optixDenoiserComputeIntensity(temporal.handle, stream, &layer.input,
                                                    temporal.intensity.ptr(),
                                                    temporal.scratch.ptr(), temporal.scratch.size));
            how.hdrIntensity = temporal.intensity.ptr();
            OPTIX_TRY(optixDenoiserInvoke(temporal.handle, stream, &how, temporal.state.ptr(),
                                          temporal.state.size, &guides, &layer, 1, 0, 0,
                                          temporal.scratch.ptr(), temporal.scratch.size));
            CUDA_TRY(cudaMemcpyAsync(previous.data, output.data, output.size,
                                     cudaMemcpyDeviceToDevice, stream));

            guides.normal = guides.flow = OptixImage2D();
            layer.previousOutput = OptixImage2D();
            layer.output.data = whole.ptr();
            OPTIX_TRY(optixDenoiserInvoke(plain.handle, stream, &how, plain.state.ptr(),
                                          plain.state.size, &guides, &layer, 1, 0, 0,
                                          plain.scratch.ptr(), plain.scratch.size));
            layer.output.data = tiles.ptr();
            OPTIX_TRY(optixUtilDenoiserInvokeTiled(tiled.handle, stream, &how, tiled.state.ptr(),
                                                   tiled.state.size, &guides, &layer, 1,
                                                   tiled.scratch.ptr(), tiled.scratch.size,
                                                   tiled.sizes.overlapWindowSizeInPixels, 64, 48));
            CUDA_TRY(cudaStreamSynchronize(stream));
            noisy = errorOf(beauty.download<float>(), shift);
            temporalError = errorOf(previous.download<float>(), shift);
            plainError = errorOf(whole.download<float>(), shift);
            const auto a = whole.download<float>(), b = tiles.download<float>();
            for (size_t i = 0; i < a.size(); ++i)
                between = std::max(between, double(std::fabs(a[i] - b[i])));
            right =
                right && plainError < 0.5 * noisy && temporalError < 0.5 * noisy && between < 0.05;
        }
        std::printf(
            "error %.3f noisy, %.3f denoised, %.3f with earlier frames; tiles differ by %.4f\n",
            noisy, plainError, temporalError, between);
    }
    CUDA_TRY(cudaStreamDestroy(stream));
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return right;
}

} // namespace

int main() {
    return runChecked(run);
}
