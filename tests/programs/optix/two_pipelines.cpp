// SPDX-License-Identifier: Apache-2.0
// A viewer that keeps a pipeline for pictures and one for picking. Each loads the module for
// itself, with other options; both use one scene, one stream each and parameters of their own.
#include "common.h"

#include <optix_function_table_definition.h>

#include <cmath>
#include <cstring>

#include "device/two_pipelines.h"

namespace {

constexpr int kWidth = 48, kHeight = 32, kDiscs = 6;

struct Pass {
    Pass(OptixDeviceContext context, const char* raygen, const char* closest, const char* any,
         const char* miss, unsigned payload) {
        const auto options =
            pipelineOptions(payload, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING);
        module = makeModule(context, options);
        groups = {raygenGroup(context, module, raygen), missGroup(context, module, miss),
                  hitGroup(context, module, closest, any, nullptr)};
        pipeline = makePipeline(context, options, groups);
        std::vector<Record<Nothing>> records;
        for (OptixProgramGroup group : groups)
            records.push_back(packed(group, Nothing()));
        table = Buffer(records);
        sbt.raygenRecord = table.ptr();
        sbt.missRecordBase = table.ptr() + sizeof records[0];
        sbt.hitgroupRecordBase = table.ptr() + 2 * sizeof records[0];
        sbt.missRecordStrideInBytes = sbt.hitgroupRecordStrideInBytes = sizeof records[0];
        sbt.missRecordCount = sbt.hitgroupRecordCount = 1;
        CUDA_TRY(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking));
        params.resize(sizeof(Params));
    }
    ~Pass() {
        optixPipelineDestroy(pipeline);
        for (OptixProgramGroup group : groups)
            optixProgramGroupDestroy(group);
        optixModuleDestroy(module);
        cudaStreamDestroy(stream);
    }
    void run(const Params& values, unsigned width, unsigned height) {
        CUDA_TRY(
            cudaMemcpyAsync(params.data, &values, sizeof values, cudaMemcpyHostToDevice, stream));
        OPTIX_TRY(
            optixLaunch(pipeline, stream, params.ptr(), sizeof values, &sbt, width, height, 1));
    }
    OptixModule module = nullptr;
    std::vector<OptixProgramGroup> groups;
    OptixPipeline pipeline = nullptr;
    Buffer table, params;
    OptixShaderBindingTable sbt = {};
    cudaStream_t stream = nullptr;
};

// Squares of half-width 0.3 at several depths; those with odd numbers are only for picking.
float2 centreOf(int i) {
    return {-0.6f + 0.22f * i, -0.4f + 0.17f * i};
}
float depthOf(int i) {
    return float((i * 5) % kDiscs);
}

bool covers(int i, float x, float y) {
    const float2 c = centreOf(i);
    return std::fabs(x - c.x) < 0.3f && std::fabs(y - c.y) < 0.3f;
}

OptixTraversableHandle makeScene(OptixDeviceContext context, Buffer& meshMemory, Buffer& memory) {
    Buffer corners(
        std::vector<float3>{{-.3f, -.3f, 0}, {.3f, -.3f, 0}, {.3f, .3f, 0}, {-.3f, .3f, 0}});
    Buffer indices(std::vector<unsigned short>{0, 1, 2, 0, 2, 3});
    const CUdeviceptr address = corners.ptr();
    const unsigned flags = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
    std::vector<OptixBuildInput> input(1);
    input[0].type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    auto& triangles = input[0].triangleArray;
    triangles.vertexBuffers = &address;
    triangles.numVertices = 4;
    triangles.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    triangles.indexBuffer = indices.ptr();
    triangles.numIndexTriplets = 2;
    triangles.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_SHORT3;
    triangles.flags = &flags;
    triangles.numSbtRecords = 1;
    const OptixTraversableHandle mesh = buildAccel(context, input, meshMemory);
    std::vector<OptixInstance> instances(kDiscs);
    for (int i = 0; i < kDiscs; ++i) {
        const float2 c = centreOf(i);
        const float place[12] = {1, 0, 0, c.x, 0, 1, 0, c.y, 0, 0, 1, -depthOf(i)};
        std::memcpy(instances[i].transform, place, sizeof place);
        instances[i].instanceId = unsigned(i);
        instances[i].visibilityMask = i % 2 ? 2 : 1;
        instances[i].traversableHandle = mesh;
    }
    Buffer buffer(instances);
    std::vector<OptixBuildInput> top(1);
    top[0].type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    top[0].instanceArray = {buffer.ptr(), kDiscs};
    return buildAccel(context, top, memory);
}

int wrongPixels(const std::vector<float>& depth) {
    int wrong = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            float nearest = 1000.0f;
            for (int i = 0; i < kDiscs; i += 2)
                if (covers(i, 2 * (x + .5f) / kWidth - 1, 2 * (y + .5f) / kHeight - 1))
                    nearest = std::fmin(nearest, 4 + depthOf(i));
            wrong += std::fabs(depth[y * kWidth + x] - nearest) > 1e-4f;
        }
    return wrong;
}

bool pickedRight(const unsigned* picked, int x, int y) {
    unsigned ids[2] = {~0u, ~0u};
    float depths[2] = {1e30f, 1e30f};
    for (int i = 0; i < kDiscs; ++i)
        if (covers(i, 2 * (x + .5f) / kWidth - 1, 2 * (y + .5f) / kHeight - 1)) {
            const int place = depthOf(i) < depths[0] ? 0 : depthOf(i) < depths[1] ? 1 : 2;
            if (place == 0) {
                ids[1] = ids[0];
                depths[1] = depths[0];
            }
            if (place < 2) {
                ids[place] = unsigned(i);
                depths[place] = depthOf(i);
            }
        }
    return picked[0] == ids[0] && picked[1] == ids[1];
}

bool run() {
    OptixDeviceContext context = makeContext();
    Buffer meshMemory, sceneMemory;
    const OptixTraversableHandle scene = makeScene(context, meshMemory, sceneMemory);
    int wrong = 0, wrongPicks = 0;
    {
        Pass draw(context, "__raygen__draw", "__closesthit__draw", nullptr, "__miss__draw", 4),
            pick(context, "__raygen__pick", nullptr, "__anyhit__pick", "__miss__pick", 6);
        Buffer depth(kWidth * kHeight * 4), picked(8);
        for (int frame = 0; frame < 40; ++frame) {
            Params params = {scene,   depth.as<float>(),    picked.as<unsigned>(), kWidth,
                             kHeight, (frame * 7) % kWidth, (frame * 11) % kHeight};
            draw.run(params, kWidth, kHeight);
            pick.run(params, 1, 1);
            unsigned ids[2];
            CUDA_TRY(cudaMemcpyAsync(ids, picked.data, 8, cudaMemcpyDeviceToHost, pick.stream));
            CUDA_TRY(cudaStreamSynchronize(pick.stream));
            wrongPicks += !pickedRight(ids, params.cursorX, params.cursorY);
            CUDA_TRY(cudaStreamSynchronize(draw.stream));
            wrong += wrongPixels(depth.download<float>());
        }
    }
    std::printf("%d pixels and %d picks wrong\n", wrong, wrongPicks);
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return wrong == 0 && wrongPicks == 0;
}

} // namespace

int main() {
    return runChecked(run);
}
