// SPDX-License-Identifier: Apache-2.0
// Radiology in balls: rays count what they pass through. All work is in any-hit programs, which
// ignore every hit; the intersection program reports both surfaces of a ball. There is no miss
// program at all, and the second launch ends rays at a limit.
#include "common.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "device/anyhit_count.h"

namespace {

constexpr unsigned kRays = 32 * 24, kBalls = 200;

std::vector<float4> makeBalls() {
    std::vector<float4> balls;
    unsigned state = 7;
    auto next = [&] { return float((state = state * 1664525u + 1013904223u) >> 8) / (1 << 24); };
    for (unsigned i = 0; i < kBalls; ++i) {
        const float x = next() * 20, y = next() * 8, z = next() * 8;
        balls.push_back({x + 2, y, z, 0.2f + 0.6f * next()});
    }
    return balls;
}

OptixTraversableHandle build(OptixDeviceContext context, const std::vector<float4>& balls,
                             Buffer& memory) {
    std::vector<OptixAabb> boxes;
    for (const float4& b : balls)
        boxes.push_back({b.x - b.w, b.y - b.w, b.z - b.w, b.x + b.w, b.y + b.w, b.z + b.w});
    Buffer buffer(boxes);
    const CUdeviceptr address = buffer.ptr();
    const unsigned flags = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
    std::vector<OptixBuildInput> input(1);
    input[0].type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    input[0].customPrimitiveArray.aabbBuffers = &address;
    input[0].customPrimitiveArray.numPrimitives = kBalls;
    input[0].customPrimitiveArray.flags = &flags;
    input[0].customPrimitiveArray.numSbtRecords = 1;
    return buildAccel(context, input, memory,
                      OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_PREFER_FAST_BUILD);
}

struct Expected {
    unsigned count = 0;
    float sum = 0;
    bool isClose = false; // a ray that grazes a ball may go either way
};

Expected expected(unsigned ray, const std::vector<float4>& balls) {
    const float y = (ray / 32 + 0.5f) / (kRays / 32) * 8.0f, z = (ray % 32 + 0.5f) / 4.0f;
    Expected all;
    for (const float4& b : balls) {
        const float rest = b.w * b.w - (b.y - y) * (b.y - y) - (b.z - z) * (b.z - z);
        all.isClose |= std::fabs(rest) < 1e-4f;
        if (rest <= 0)
            continue;
        ++all.count;
        all.sum += b.x + 1 - std::sqrt(rest);
    }
    return all;
}

bool run() {
    OptixDeviceContext context = makeContext();
    auto options = pipelineOptions(4, 1, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS);
    options.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
    OptixModule module = makeModule(context, options);
    const OptixProgramGroup raygen = raygenGroup(context, module, "__raygen__count"),
                            miss = missGroup(context, module, nullptr),
                            hit = hitGroup(context, module, "__closesthit__never",
                                           "__anyhit__count", "__intersection__ball");
    OptixPipeline pipeline = makePipeline(context, options, {raygen, miss, hit});

    const std::vector<float4> balls = makeBalls();
    Buffer memory, ballBuffer(balls), reports(8), result(kRays * 8);
    const OptixTraversableHandle handle = build(context, balls, memory);
    Buffer table(std::vector<Record<Nothing>>{packed(raygen, Nothing()), packed(miss, Nothing()),
                                              packed(hit, Nothing())});
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = table.ptr();
    sbt.missRecordBase = table.ptr() + sizeof(Record<Nothing>);
    sbt.hitgroupRecordBase = table.ptr() + 2 * sizeof(Record<Nothing>);
    sbt.missRecordStrideInBytes = sbt.hitgroupRecordStrideInBytes = sizeof(Record<Nothing>);
    sbt.missRecordCount = sbt.hitgroupRecordCount = 1;

    unsigned wrong = 0;
    for (const unsigned limit : {~0u, 3u}) {
        CUDA_TRY(cudaMemset(reports.data, 0, 8));
        Buffer params(
            std::vector<Params>{{handle, ballBuffer.as<float4>(), reports.as<unsigned long long>(),
                                 result.as<uint2>(), limit}});
        OPTIX_TRY(optixLaunch(pipeline, nullptr, params.ptr(), sizeof(Params), &sbt, kRays, 1, 1));
        const auto seen = result.download<uint2>();
        unsigned long long total = 0, close = 0;
        for (unsigned ray = 0; ray < kRays; ++ray) {
            const Expected right = expected(ray, balls);
            float sum;
            std::memcpy(&sum, &seen[ray].y, 4);
            close += right.isClose ? 4 : 0;
            total += limit == ~0u ? 2 * right.count : 0;
            if (right.isClose)
                continue;
            wrong += seen[ray].x != std::min(right.count, limit);
            if (limit == ~0u)
                wrong += std::fabs(sum - right.sum) > 1e-3f * right.sum;
        }
        const unsigned long long counted = reports.download<unsigned long long>()[0];
        if (limit == ~0u)
            wrong += counted + close < total || counted > total + close;
    }
    std::printf("%u wrong\n", wrong);
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return wrong == 0;
}

} // namespace

int main() {
    return runChecked(run);
}
