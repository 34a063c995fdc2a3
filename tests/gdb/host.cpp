// SPDX-License-Identifier: Apache-2.0
// Launches __raygen__debug of the PTX file that the argument names, for one index, at debug level
// FULL, and prints the result. Runs under gdb: see check.cmake.
#include "shared_params.h"

#include <optix.h>
#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace {

void check(OptixResult result, const char* what) {
    if (result == OPTIX_SUCCESS)
        return;
    std::fprintf(stderr, "%s: %s\n", what, optixGetErrorName(result));
    std::exit(1);
}

void printLog(unsigned, const char* tag, const char* text, void*) {
    std::fprintf(stderr, "[%s] %s\n", tag, text);
}

} // namespace

int main(int argc, char** argv) {
    std::ifstream file(argc > 1 ? argv[1] : "");
    std::ostringstream text;
    text << file.rdbuf();
    const std::string ptx = text.str();

    check(optixInit(), "optixInit");
    OptixDeviceContextOptions contextOptions{};
    contextOptions.logCallbackFunction = printLog;
    contextOptions.logCallbackLevel = 3;
    OptixDeviceContext context = nullptr;
    check(optixDeviceContextCreate(nullptr, &contextOptions, &context), "context");
    OptixModuleCompileOptions moduleOptions{};
    moduleOptions.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_FULL;
    moduleOptions.optLevel = OPTIX_COMPILE_OPTIMIZATION_LEVEL_0;
    OptixPipelineCompileOptions options{};
    options.pipelineLaunchParamsVariableName = "params";
    OptixModule module = nullptr;
    check(optixModuleCreateFromPTX(context, &moduleOptions, &options, ptx.data(), ptx.size(),
                                   nullptr, nullptr, &module),
          "module");
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    desc.raygen = {module, "__raygen__debug"};
    OptixProgramGroupOptions groupOptions{};
    OptixProgramGroup group = nullptr;
    check(optixProgramGroupCreate(context, &desc, 1, &groupOptions, nullptr, nullptr, &group),
          "group");
    OptixPipelineLinkOptions link{};
    link.maxTraceDepth = 1;
    link.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_FULL;
    OptixPipeline pipeline = nullptr;
    check(optixPipelineCreate(context, &options, &link, &group, 1, nullptr, nullptr, &pipeline),
          "pipeline");
    alignas(OPTIX_SBT_RECORD_ALIGNMENT) char record[OPTIX_SBT_RECORD_HEADER_SIZE];
    check(optixSbtRecordPackHeader(group, record), "record");
    OptixShaderBindingTable table{};
    table.raygenRecord = reinterpret_cast<CUdeviceptr>(record);
    unsigned out = 0;
    Params params = {&out, 100};
    check(optixLaunch(pipeline, nullptr, reinterpret_cast<CUdeviceptr>(&params), sizeof params,
                      &table, 1, 1, 1),
          "launch");
    check(optixDeviceContextDestroy(context), "destroy"); // waits
    std::printf("result %u\n", out);
    return 0;
}
