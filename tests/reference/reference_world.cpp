// SPDX-License-Identifier: Apache-2.0
#include "reference_world.h"

#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace reference {

void quit(int code, const std::string& text) {
    std::fprintf(stderr, "%s\n", text.c_str());
    std::fflush(stdout);
    std::exit(code);
}

void check(OptixResult result, const char* call) {
    if (result != OPTIX_SUCCESS)
        quit(1, std::string(call) + ": " + optixGetErrorName(result));
}

template <class Signature>
Signature* Cuda::function(const char* name) const {
    void* symbol = dlsym(library_, name);
    if (!symbol)
        quit(1, std::string("libcuda.so.1 without ") + name);
    Signature* result;
    std::memcpy(&result, &symbol, sizeof(result));
    return result;
}

Cuda::Cuda() : library_(dlopen("libcuda.so.1", RTLD_NOW)) {
    if (!library_)
        quit(77, "[SKIP] no libcuda.so.1");
    CUdevice device;
    if (function<int(unsigned int)>("cuInit")(0) != 0 ||
        function<int(CUdevice*, int)>("cuDeviceGet")(&device, 0) != 0)
        quit(77, "[SKIP] no CUDA device");
    CUcontext context;
    if (function<int(CUcontext*, CUdevice)>("cuDevicePrimaryCtxRetain")(&context, device) != 0 ||
        function<int(CUcontext)>("cuCtxSetCurrent")(context) != 0)
        quit(1, "no CUDA context");
}

CUdeviceptr Cuda::allocate(size_t size) const {
    CUdeviceptr address = 0;
    if (function<int(CUdeviceptr*, size_t)>("cuMemAlloc_v2")(&address, size ? size : 1) != 0)
        quit(1, "cuMemAlloc");
    return address;
}

void Cuda::copyIn(CUdeviceptr to, const void* from, size_t size) const {
    if (size && function<int(CUdeviceptr, const void*, size_t)>("cuMemcpyHtoD_v2")(to, from, size))
        quit(1, "cuMemcpyHtoD");
}

void Cuda::copyOut(void* to, CUdeviceptr from, size_t size) const {
    if (function<int(void*, CUdeviceptr, size_t)>("cuMemcpyDtoH_v2")(to, from, size) != 0)
        quit(1, "cuMemcpyDtoH");
}

void Cuda::wait() const {
    if (const int result = function<int()>("cuCtxSynchronize")())
        quit(1, "cuCtxSynchronize: " + std::to_string(result));
}

static void log(unsigned int level, const char* tag, const char* message, void*) {
    if (level <= 3)
        std::fprintf(stderr, "  [%u %s] %s\n", level, tag, message);
}

World::World() {
    const OptixResult loaded = optixInit();
    if (loaded == OPTIX_ERROR_LIBRARY_NOT_FOUND || loaded == OPTIX_ERROR_UNSUPPORTED_ABI_VERSION)
        quit(77, std::string("[SKIP] libnvoptix.so.1: ") + optixGetErrorName(loaded));
    CHECK(loaded);
    OptixDeviceContextOptions options = {log, nullptr, 3, OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_OFF};
    CHECK(optixDeviceContextCreate(nullptr, &options, &context));
}

OptixTraversableHandle World::build(const OptixBuildInput& input, unsigned int flags,
                                    CUdeviceptr* output) const {
    OptixAccelBuildOptions options = {};
    options.buildFlags = flags;
    options.operation = OPTIX_BUILD_OPERATION_BUILD;
    OptixAccelBufferSizes sizes;
    CHECK(optixAccelComputeMemoryUsage(context, &options, &input, 1, &sizes));
    OptixTraversableHandle handle = 0;
    const CUdeviceptr temporary = cuda.allocate(sizes.tempSizeInBytes);
    const CUdeviceptr block = cuda.allocate(sizes.outputSizeInBytes);
    CHECK(optixAccelBuild(context, nullptr, &options, &input, 1, temporary, sizes.tempSizeInBytes,
                          block, sizes.outputSizeInBytes, &handle, nullptr, 0));
    cuda.wait();
    if (output)
        *output = block;
    return handle;
}

OptixPipeline World::pipeline(const std::string& ptx, const OptixPipelineCompileOptions& options,
                              const char* const names[4], OptixShaderBindingTable& sbt) const {
    OptixModuleCompileOptions moduleOptions = {};
    OptixModule module = nullptr;
    CHECK(optixModuleCreateFromPTX(context, &moduleOptions, &options, ptx.data(), ptx.size(),
                                   nullptr, nullptr, &module));
    OptixProgramGroupDesc descriptions[3] = {};
    descriptions[0].kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    descriptions[0].raygen = {module, names[0]};
    descriptions[1].kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
    descriptions[1].miss = {module, names[1]};
    descriptions[2].kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
    descriptions[2].hitgroup = {module, names[2], module, names[3], nullptr, nullptr};
    OptixProgramGroupOptions groupOptions = {};
    OptixProgramGroup groups[3] = {};
    CHECK(
        optixProgramGroupCreate(context, descriptions, 3, &groupOptions, nullptr, nullptr, groups));
    OptixPipelineLinkOptions link = {1, OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT};
    OptixPipeline result = nullptr;
    CHECK(optixPipelineCreate(context, &options, &link, groups, 3, nullptr, nullptr, &result));
    struct Record {
        alignas(OPTIX_SBT_RECORD_ALIGNMENT) char header[OPTIX_SBT_RECORD_HEADER_SIZE];
    };
    std::vector<Record> records(3);
    for (int i = 0; i < 3; ++i)
        CHECK(optixSbtRecordPackHeader(groups[i], records[i].header));
    const CUdeviceptr address = cuda.upload(records);
    sbt = {};
    sbt.raygenRecord = address;
    sbt.missRecordBase = address + sizeof(Record);
    sbt.hitgroupRecordBase = address + 2 * sizeof(Record);
    sbt.missRecordStrideInBytes = sbt.hitgroupRecordStrideInBytes = sizeof(Record);
    sbt.missRecordCount = sbt.hitgroupRecordCount = 1;
    return result;
}

std::string fileText(const char* path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

} // namespace reference
