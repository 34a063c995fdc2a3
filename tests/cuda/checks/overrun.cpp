// SPDX-License-Identifier: Apache-2.0
// Launches overrun.cu for the memory checker: `overrun PTX SHIFT`. Device memory comes from the
// CUDA driver, as in most applications.
#include "overrun.h"

#include <optix.h>
#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace {

void check(int result, const char* what) {
    if (result == 0)
        return;
    std::fprintf(stderr, "%s: %d\n", what, result);
    std::exit(2);
}

template <class T>
CUdeviceptr upload(const T& value) {
    CUdeviceptr memory = 0;
    check(cuMemAlloc(&memory, sizeof value), "cuMemAlloc");
    check(cuMemcpyHtoD(memory, &value, sizeof value), "cuMemcpyHtoD");
    return memory;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3)
        return 2;
    std::ifstream file(argv[1]);
    std::ostringstream text;
    text << file.rdbuf();
    const std::string ptx = text.str();
    check(cuInit(0), "cuInit");
    CUcontext cuda = nullptr;
    check(cuDevicePrimaryCtxRetain(&cuda, 0), "cuDevicePrimaryCtxRetain");
    check(cuCtxSetCurrent(cuda), "cuCtxSetCurrent");

    check(optixInit(), "optixInit");
    OptixDeviceContextOptions contextOptions{};
    OptixDeviceContext context = nullptr;
    check(optixDeviceContextCreate(cuda, &contextOptions, &context), "context");
    OptixModuleCompileOptions moduleOptions{};
    OptixPipelineCompileOptions options{};
    options.pipelineLaunchParamsVariableName = "params";
    OptixModule module = nullptr;
    check(optixModuleCreateFromPTX(context, &moduleOptions, &options, ptx.data(), ptx.size(),
                                   nullptr, nullptr, &module),
          "module");
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    desc.raygen = {module, "__raygen__overrun"};
    OptixProgramGroupOptions groupOptions{};
    OptixProgramGroup group = nullptr;
    check(optixProgramGroupCreate(context, &desc, 1, &groupOptions, nullptr, nullptr, &group),
          "group");
    OptixPipelineLinkOptions link{};
    link.maxTraceDepth = 1;
    OptixPipeline pipeline = nullptr;
    check(optixPipelineCreate(context, &options, &link, &group, 1, nullptr, nullptr, &pipeline),
          "pipeline");
    struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) {
        char header[OPTIX_SBT_RECORD_HEADER_SIZE];
    } record;
    check(optixSbtRecordPackHeader(group, &record), "record");
    OptixShaderBindingTable table{};
    table.raygenRecord = upload(record);
    constexpr unsigned kIndices = 100;
    CUdeviceptr out = 0;
    check(cuMemAlloc(&out, kIndices * sizeof(unsigned)), "cuMemAlloc");
    const OverrunParams params = {
        reinterpret_cast<unsigned*>(out), unsigned(std::atoi(argv[2])), {1, 2, 3, 4}};
    const CUdeviceptr deviceParams = upload(params);
    check(optixLaunch(pipeline, nullptr, deviceParams, sizeof params, &table, kIndices, 1, 1),
          "launch");
    std::printf("launch: %d\n", int(cuCtxSynchronize()));
    for (const CUdeviceptr memory : {table.raygenRecord, out, deviceParams})
        cuMemFree(memory);
    return 0;
}
