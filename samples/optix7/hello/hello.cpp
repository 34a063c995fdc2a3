// SPDX-License-Identifier: Apache-2.0
// The smallest OptiX program, with every step in full: a ray generation program computes a colour
// gradient, without rays. Read next: triangle.
#include "arguments.h"
#include "check.h"
#include "png_image.h"

#include <optix.h>
#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <cstdio>
#include <string_view>

#include "params.h"

std::string_view hello_ptx(); // the PTX of hello.cu, built into this program

namespace {

int run(int argc, char** argv) {
    std::string output = "hello.png";
    unsigned width = 512, height = 384;
    Arguments arguments("Paints a colour gradient with an OptiX ray generation program.");
    arguments.add("-o,--output", output, "picture to write");
    arguments.add("--width", width, 1, 8192, "pixels across");
    arguments.add("--height", height, 1, 8192, "pixels down");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;

    // 1. A device context: OptiX on the current CUDA device.
    CUDA_CHECK(cudaFree(nullptr));
    OPTIX_CHECK(optixInit());
    OptixDeviceContextOptions contextOptions = {};
    OptixDeviceContext context = nullptr;
    OPTIX_CHECK(optixDeviceContextCreate(nullptr, &contextOptions, &context));

    // 2. A module: device code in PTX form.
    OptixModuleCompileOptions moduleOptions = {};
    OptixPipelineCompileOptions pipelineOptions = {};
    pipelineOptions.pipelineLaunchParamsVariableName = "params";
    std::string_view ptx = hello_ptx();
    OptixModule module = nullptr;
    OPTIX_CHECK(optixModuleCreateFromPTX(context, &moduleOptions, &pipelineOptions, ptx.data(),
                                         ptx.size(), nullptr, nullptr, &module));

    // 3. Program groups: the roles of the module's functions. Every pipeline needs ray generation;
    // without rays, a group without a function suffices as the miss program.
    OptixProgramGroupDesc descriptions[2] = {};
    descriptions[0].kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    descriptions[0].raygen.module = module;
    descriptions[0].raygen.entryFunctionName = "__raygen__gradient";
    descriptions[1].kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
    OptixProgramGroupOptions groupOptions = {};
    OptixProgramGroup groups[2] = {};
    OPTIX_CHECK(
        optixProgramGroupCreate(context, descriptions, 2, &groupOptions, nullptr, nullptr, groups));

    // 4. A pipeline: all programs of a launch, linked.
    OptixPipelineLinkOptions linkOptions = {};
    OptixPipeline pipeline = nullptr;
    OPTIX_CHECK(optixPipelineCreate(context, &pipelineOptions, &linkOptions, groups, 2, nullptr,
                                    nullptr, &pipeline));

    // 5. A shader binding table: here, one record without data for each group.
    struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) Record {
        char header[OPTIX_SBT_RECORD_HEADER_SIZE];
    };
    Record records[2] = {};
    OPTIX_CHECK(optixSbtRecordPackHeader(groups[0], &records[0]));
    OPTIX_CHECK(optixSbtRecordPackHeader(groups[1], &records[1]));
    Record* deviceRecords = nullptr;
    CUDA_CHECK(cudaMalloc(reinterpret_cast<void**>(&deviceRecords), sizeof(records)));
    CUDA_CHECK(cudaMemcpy(deviceRecords, records, sizeof(records), cudaMemcpyHostToDevice));
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = reinterpret_cast<CUdeviceptr>(&deviceRecords[0]);
    sbt.missRecordBase = reinterpret_cast<CUdeviceptr>(&deviceRecords[1]);
    sbt.missRecordStrideInBytes = sizeof(Record);
    sbt.missRecordCount = 1;

    // 6. Launch parameters: the contents of the program's `params` variable.
    size_t imageSize = size_t(width) * height * sizeof(float4);
    Params params = {};
    CUDA_CHECK(cudaMalloc(reinterpret_cast<void**>(&params.image), imageSize));
    Params* deviceParams = nullptr;
    CUDA_CHECK(cudaMalloc(reinterpret_cast<void**>(&deviceParams), sizeof(Params)));
    CUDA_CHECK(cudaMemcpy(deviceParams, &params, sizeof(Params), cudaMemcpyHostToDevice));

    // 7. Launch: one call of the ray generation program for each pixel.
    OPTIX_CHECK(optixLaunch(pipeline, nullptr, reinterpret_cast<CUdeviceptr>(deviceParams),
                            sizeof(Params), &sbt, width, height, 1));
    CUDA_CHECK(cudaDeviceSynchronize());

    std::vector<float> pixels(size_t(width) * height * 4);
    CUDA_CHECK(cudaMemcpy(pixels.data(), params.image, imageSize, cudaMemcpyDeviceToHost));
    writePng(output, width, height, toSrgb(pixels, false));
    std::printf("wrote %s\n", output.c_str());

    CUDA_CHECK(cudaFree(deviceParams));
    CUDA_CHECK(cudaFree(params.image));
    CUDA_CHECK(cudaFree(deviceRecords));
    OPTIX_CHECK(optixPipelineDestroy(pipeline));
    for (OptixProgramGroup group : groups)
        OPTIX_CHECK(optixProgramGroupDestroy(group));
    OPTIX_CHECK(optixModuleDestroy(module));
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("hello", [&] { return run(argc, argv); });
}
