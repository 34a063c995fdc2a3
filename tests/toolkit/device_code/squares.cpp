// SPDX-License-Identifier: Apache-2.0
// Creates modules of the embedded texts.
#include "squares_ptx.h"
#include "tripled.h"

#include <optix.h>
#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <cstdio>
#include <cstring>

static int load(OptixDeviceContext context, const char* text, unsigned long size) {
    if (std::strlen(text) != size)
        return std::printf("size %lu, length %zu\n", size, std::strlen(text)), 1;
    OptixModuleCompileOptions moduleOptions = {};
    OptixPipelineCompileOptions pipelineOptions = {};
    pipelineOptions.pipelineLaunchParamsVariableName = "params";
    OptixModule module = nullptr;
    return optixModuleCreateFromPTX(context, &moduleOptions, &pipelineOptions, text, size, nullptr,
                                    nullptr, &module);
}

int main() {
    OptixDeviceContext context = nullptr;
    if (optixInit() || optixDeviceContextCreate(nullptr, nullptr, &context))
        return std::printf("no context\n"), 1;
    const int first = load(context, squares_ptx, squares_ptx_size);
    const int second = load(context, tripled, tripled_size);
    std::printf("modules: %d %d, different: %d\n", first, second,
                std::strcmp(squares_ptx, tripled) != 0);
    return first || second;
}
