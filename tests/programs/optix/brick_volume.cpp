// SPDX-License-Identifier: Apache-2.0
// A viewer of distance fields: a volume in eight bricks, each a texture with a texel of overlap,
// whose handles stand in the shader binding table beside surfaces that programs write. Rays that
// miss read a picture of the sky in bytes, repeated.
#include "common.h"

#include <optix_function_table_definition.h>

#include <cmath>

#include "device/brick_volume.h"

namespace {

constexpr int kWidth = 60, kHeight = 60, kTexels = 24;

// Two balls that touch.
float distanceTo(float x, float y, float z) {
    const float a = std::sqrt((x + .3f) * (x + .3f) + y * y + z * z) - .5f;
    const float b = std::sqrt((x - .45f) * (x - .45f) + (y - .2f) * (y - .2f) + z * z) - .35f;
    return std::fmin(a, b);
}

cudaTextureObject_t distances(float3 low, float size) {
    std::vector<float> texels;
    for (int z = 0; z < kTexels; ++z)
        for (int y = 0; y < kTexels; ++y)
            for (int x = 0; x < kTexels; ++x)
                texels.push_back(distanceTo(low.x + size * x / (kTexels - 1),
                                            low.y + size * y / (kTexels - 1),
                                            low.z + size * z / (kTexels - 1)));
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<float>();
    cudaArray_t array;
    CUDA_TRY(cudaMalloc3DArray(&array, &format, make_cudaExtent(kTexels, kTexels, kTexels)));
    cudaMemcpy3DParms copy = {};
    copy.srcPtr = make_cudaPitchedPtr(texels.data(), kTexels * 4, kTexels, kTexels);
    copy.dstArray = array;
    copy.extent = make_cudaExtent(kTexels, kTexels, kTexels);
    copy.kind = cudaMemcpyHostToDevice;
    CUDA_TRY(cudaMemcpy3D(&copy));
    cudaResourceDesc from = {};
    from.resType = cudaResourceTypeArray;
    from.res.array.array = array;
    cudaTextureDesc how = {};
    how.filterMode = cudaFilterModeLinear;
    for (auto& mode : how.addressMode)
        mode = cudaAddressModeClamp;
    cudaTextureObject_t texture;
    CUDA_TRY(cudaCreateTextureObject(&texture, &from, &how, nullptr));
    return texture;
}

cudaTextureObject_t makeSky() {
    const unsigned char texels[2][4][4] = {
        {{0, 51, 102, 255}, {51, 51, 0, 255}, {255, 0, 0, 255}, {0, 0, 0, 255}},
        {{102, 0, 0, 255}, {0, 204, 0, 255}, {0, 0, 153, 255}, {9, 9, 9, 255}}};
    const cudaChannelFormatDesc format =
        cudaCreateChannelDesc(8, 8, 8, 8, cudaChannelFormatKindUnsigned);
    cudaArray_t array;
    CUDA_TRY(cudaMallocArray(&array, &format, 4, 2));
    CUDA_TRY(cudaMemcpy2DToArray(array, 0, 0, texels, 16, 16, 2, cudaMemcpyHostToDevice));
    cudaResourceDesc from = {};
    from.resType = cudaResourceTypeArray;
    from.res.array.array = array;
    cudaTextureDesc how = {};
    how.readMode = cudaReadModeNormalizedFloat;
    how.normalizedCoords = 1;
    how.addressMode[0] = cudaAddressModeWrap;
    how.addressMode[1] = cudaAddressModeMirror;
    cudaTextureObject_t texture;
    CUDA_TRY(cudaCreateTextureObject(&texture, &from, &how, nullptr));
    return texture;
}

float4 skyAt(float x, float y) {
    const float colours[2][4][3] = {
        {{0, .2f, .4f}, {.2f, .2f, 0}, {1, 0, 0}, {0, 0, 0}},
        {{.4f, 0, 0}, {0, .8f, 0}, {0, 0, .6f}, {9 / 255.f, 9 / 255.f, 9 / 255.f}}};
    const float place = x * .5f + .013f, u = place - std::floor(place), v = std::fabs(y * .5f);
    const float* c = colours[int(v * 2)][int(u * 4)];
    return {c[0], c[1], c[2], -1};
}

struct Volume {
    std::vector<Brick> bricks;
    std::vector<cudaArray_t> visits;
    Buffer boxes, memory;
    OptixTraversableHandle handle = 0;

    explicit Volume(OptixDeviceContext context) {
        std::vector<OptixAabb> bounds;
        for (int i = 0; i < 8; ++i) {
            const float3 low = {i & 1 ? 0.f : -1.f, i & 2 ? 0.f : -1.f, i & 4 ? 0.f : -1.f};
            cudaArray_t array;
            const cudaChannelFormatDesc format = cudaCreateChannelDesc<int>();
            CUDA_TRY(cudaMallocArray(&array, &format, 8, 8, cudaArraySurfaceLoadStore));
            const std::vector<int> zero(64);
            CUDA_TRY(
                cudaMemcpy2DToArray(array, 0, 0, zero.data(), 32, 32, 8, cudaMemcpyHostToDevice));
            cudaResourceDesc resource = {};
            resource.resType = cudaResourceTypeArray;
            resource.res.array.array = array;
            cudaSurfaceObject_t surface;
            CUDA_TRY(cudaCreateSurfaceObject(&surface, &resource));
            visits.push_back(array);
            bricks.push_back({distances(low, 1), surface, low, 1, kTexels});
            bounds.push_back({low.x, low.y, low.z, low.x + 1, low.y + 1, low.z + 1});
        }
        // One build input; the records of its primitives are chosen by an index for each.
        std::vector<unsigned> records, flags(8, OPTIX_GEOMETRY_FLAG_NONE);
        for (unsigned i = 0; i < 8; ++i)
            records.push_back(7 - i);
        boxes = Buffer(bounds);
        Buffer indices(records);
        const CUdeviceptr address = boxes.ptr();
        std::vector<OptixBuildInput> input(1);
        input[0].type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        auto& array = input[0].customPrimitiveArray;
        array.aabbBuffers = &address;
        array.numPrimitives = 8;
        array.flags = flags.data();
        array.numSbtRecords = 8;
        array.sbtIndexOffsetBuffer = indices.ptr();
        array.sbtIndexOffsetSizeInBytes = 4;
        handle = buildAccel(context, input, memory);
    }
};

unsigned wrongPixels(const std::vector<float4>& seen) {
    unsigned wrong = 0;
    for (int i = 0; i < kWidth * kHeight; ++i) {
        const float x = 2.4f * (i % kWidth + .5f) / kWidth - 1.2f,
                    y = 2.4f * (i / kWidth + .5f) / kHeight - 1.2f;
        // The first ball that the ray meets, exactly.
        float top = -9, clearance = 9;
        int covers = 0; // creases have no normal
        float3 centre = {};
        for (const float4 ball : {float4{-.3f, 0, 0, .5f}, {.45f, .2f, 0, .35f}}) {
            const float rest =
                ball.w * ball.w - (x - ball.x) * (x - ball.x) - (y - ball.y) * (y - ball.y);
            clearance = std::fmin(clearance, std::fabs(rest));
            covers += rest > 0;
            if (rest > 0 && std::sqrt(rest) > top) {
                top = std::sqrt(rest);
                centre = {ball.x, ball.y, ball.w};
            }
        }
        const float4 s = seen[i];
        if (top < 0) {
            const float4 sky = skyAt(x, y);
            const bool isRight =
                std::fabs(s.x - sky.x) + std::fabs(s.y - sky.y) + std::fabs(s.z - sky.z) < 1e-3f &&
                s.w == -1;
            wrong += !isRight && clearance > .03f;
        } else if (clearance > .06f) { // where the texture is not too coarse
            const float nx = (x - centre.x) / centre.z, ny = (y - centre.y) / centre.z;
            wrong += std::fabs(3 - s.w - top) > .03f;
            wrong += covers == 1 && (std::fabs(s.x - nx) > .15f || std::fabs(s.y - ny) > .15f);
        }
    }
    return wrong;
}

bool run() {
    OptixDeviceContext context = makeContext();
    auto options = pipelineOptions(4, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS);
    options.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
    OptixModule module = makeModule(context, options);
    const std::vector<OptixProgramGroup> groups = {
        raygenGroup(context, module, "__raygen__view"), missGroup(context, module, "__miss__sky"),
        hitGroup(context, module, "__closesthit__surface", nullptr, "__intersection__march")};
    OptixPipeline pipeline = makePipeline(context, options, groups);
    Volume volume(context);
    std::vector<Record<Brick>> records = {packed(groups[0], Brick()), packed(groups[1], Brick())};
    for (int i = 7; i >= 0; --i)
        records.push_back(packed(groups[2], volume.bricks[i]));
    Buffer table(records);
    OptixShaderBindingTable sbt = {};
    constexpr unsigned kStride = sizeof(Record<Brick>);
    sbt.raygenRecord = table.ptr();
    sbt.missRecordBase = table.ptr() + kStride;
    sbt.hitgroupRecordBase = table.ptr() + 2 * kStride;
    sbt.missRecordStrideInBytes = sbt.hitgroupRecordStrideInBytes = kStride;
    sbt.missRecordCount = 1;
    sbt.hitgroupRecordCount = 8;
    Buffer out(kWidth * kHeight * sizeof(float4));
    Buffer params(
        std::vector<Params>{{volume.handle, out.as<float4>(), makeSky(), kWidth, kHeight}});
    OPTIX_TRY(
        optixLaunch(pipeline, nullptr, params.ptr(), sizeof(Params), &sbt, kWidth, kHeight, 1));
    const unsigned wrong = wrongPixels(out.download<float4>());
    unsigned entered = 0;
    for (int i = 4; i < 8; ++i) { // the bricks in front
        int visits[64];
        CUDA_TRY(cudaMemcpy2DFromArray(visits, 32, volume.visits[i], 0, 0, 32, 8,
                                       cudaMemcpyDeviceToHost));
        for (int v : visits)
            entered += unsigned(v);
    }
    std::printf("%u pixels wrong, %u of 256 columns entered\n", wrong, entered);
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return wrong == 0 && entered == 256;
}

} // namespace

int main() {
    return runChecked(run);
}
