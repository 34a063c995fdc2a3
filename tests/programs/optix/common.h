// SPDX-License-Identifier: Apache-2.0
// Code that several programs of this folder share: errors as exceptions, buffers, modules of the
// device code that the build embeds.
#pragma once

#include <cuda_runtime.h>
#include <optix.h>
#include <optix_stubs.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

extern "C" const char device_ptx[];
extern "C" const unsigned long device_ptx_size;

#define CUDA_TRY(call)                                                                             \
    do {                                                                                           \
        const cudaError_t code_ = (call);                                                          \
        if (code_ != cudaSuccess)                                                                  \
            throw std::runtime_error(std::string(#call ": ") + cudaGetErrorString(code_));         \
    } while (0)
#define OPTIX_TRY(call)                                                                            \
    do {                                                                                           \
        const OptixResult code_ = (call);                                                          \
        if (code_ != OPTIX_SUCCESS)                                                                \
            throw std::runtime_error(std::string(#call ": ") + optixGetErrorName(code_));          \
    } while (0)

struct Buffer {
    Buffer() = default;
    explicit Buffer(size_t bytes) { resize(bytes); }
    template <class T>
    explicit Buffer(const std::vector<T>& values) {
        upload(values.data(), values.size() * sizeof(T));
    }
    Buffer(const Buffer&) = delete;
    Buffer(Buffer&& other) noexcept : data(other.data), size(other.size) { other.data = nullptr; }
    Buffer& operator=(Buffer&& other) noexcept {
        std::swap(data, other.data);
        std::swap(size, other.size);
        return *this;
    }
    ~Buffer() { cudaFree(data); }
    void resize(size_t bytes) {
        cudaFree(data);
        data = nullptr;
        size = bytes;
        CUDA_TRY(cudaMalloc(&data, bytes));
    }
    void upload(const void* from, size_t bytes) {
        if (size < bytes || !data)
            resize(bytes);
        CUDA_TRY(cudaMemcpy(data, from, bytes, cudaMemcpyHostToDevice));
    }
    template <class T>
    std::vector<T> download() const {
        std::vector<T> values(size / sizeof(T));
        CUDA_TRY(
            cudaMemcpy(values.data(), data, values.size() * sizeof(T), cudaMemcpyDeviceToHost));
        return values;
    }
    CUdeviceptr ptr() const { return reinterpret_cast<CUdeviceptr>(data); }
    template <class T>
    T* as() const {
        return static_cast<T*>(data);
    }
    void* data = nullptr;
    size_t size = 0;
};

template <class T>
struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) Record {
    char header[OPTIX_SBT_RECORD_HEADER_SIZE];
    T data;
};
struct Nothing {};

static inline void logLine(unsigned level, const char* tag, const char* text, void*) {
    std::fprintf(stderr, "[%u][%s]: %s\n", level, tag, text);
}

static inline OptixDeviceContext makeContext(bool validates = false) {
    CUDA_TRY(cudaFree(nullptr));
    OPTIX_TRY(optixInit());
    OptixDeviceContextOptions options = {};
    options.logCallbackFunction = logLine;
    options.logCallbackLevel = 3;
    if (validates)
        options.validationMode = OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL;
    OptixDeviceContext context = nullptr;
    OPTIX_TRY(optixDeviceContextCreate(nullptr, &options, &context));
    return context;
}

static inline OptixPipelineCompileOptions pipelineOptions(unsigned payload, unsigned attributes,
                                                          unsigned graph) {
    OptixPipelineCompileOptions options = {};
    options.traversableGraphFlags = graph;
    options.numPayloadValues = int(payload);
    options.numAttributeValues = int(attributes);
    options.pipelineLaunchParamsVariableName = "params";
    return options;
}

static inline OptixModule makeModule(OptixDeviceContext context,
                                     const OptixPipelineCompileOptions& pipeline) {
    OptixModuleCompileOptions options = {};
    OptixModule module = nullptr;
    char log[2048];
    size_t size = sizeof log;
    OPTIX_TRY(optixModuleCreateFromPTX(context, &options, &pipeline, device_ptx, device_ptx_size,
                                       log, &size, &module));
    return module;
}

static inline OptixProgramGroup makeGroup(OptixDeviceContext context,
                                          const OptixProgramGroupDesc& description) {
    OptixProgramGroupOptions options = {};
    OptixProgramGroup group = nullptr;
    OPTIX_TRY(
        optixProgramGroupCreate(context, &description, 1, &options, nullptr, nullptr, &group));
    return group;
}
static inline OptixProgramGroup raygenGroup(OptixDeviceContext context, OptixModule module,
                                            const char* name) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    description.raygen = {module, name};
    return makeGroup(context, description);
}
static inline OptixProgramGroup missGroup(OptixDeviceContext context, OptixModule module,
                                          const char* name) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
    description.miss = {name ? module : nullptr, name};
    return makeGroup(context, description);
}
static inline OptixProgramGroup hitGroup(OptixDeviceContext context, OptixModule module,
                                         const char* closest, const char* any,
                                         const char* intersection) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
    description.hitgroup = {closest ? module : nullptr,      closest,
                            any ? module : nullptr,          any,
                            intersection ? module : nullptr, intersection};
    return makeGroup(context, description);
}

static inline OptixPipeline makePipeline(OptixDeviceContext context,
                                         const OptixPipelineCompileOptions& options,
                                         const std::vector<OptixProgramGroup>& groups,
                                         unsigned depth = 1) {
    OptixPipelineLinkOptions link = {};
    link.maxTraceDepth = depth;
    OptixPipeline pipeline = nullptr;
    OPTIX_TRY(optixPipelineCreate(context, &options, &link, groups.data(), unsigned(groups.size()),
                                  nullptr, nullptr, &pipeline));
    return pipeline;
}

template <class T>
static inline Record<T> packed(OptixProgramGroup group, const T& data) {
    Record<T> record = {};
    record.data = data;
    OPTIX_TRY(optixSbtRecordPackHeader(group, &record));
    return record;
}

// Builds a structure; with compaction where the options allow it.
static inline OptixTraversableHandle
buildAccel(OptixDeviceContext context, const std::vector<OptixBuildInput>& inputs, Buffer& memory,
           unsigned flags = OPTIX_BUILD_FLAG_NONE, OptixMotionOptions motion = {}) {
    OptixAccelBuildOptions options = {};
    options.buildFlags = flags;
    options.operation = OPTIX_BUILD_OPERATION_BUILD;
    options.motionOptions = motion;
    OptixAccelBufferSizes sizes = {};
    const unsigned count = unsigned(inputs.size());
    OPTIX_TRY(optixAccelComputeMemoryUsage(context, &options, inputs.data(), count, &sizes));
    Buffer temporary(sizes.tempSizeInBytes), output(sizes.outputSizeInBytes), size(8);
    OptixAccelEmitDesc emit = {size.ptr(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
    const bool compacts = flags & OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
    OptixTraversableHandle handle = 0;
    OPTIX_TRY(optixAccelBuild(context, nullptr, &options, inputs.data(), count, temporary.ptr(),
                              temporary.size, output.ptr(), output.size, &handle,
                              compacts ? &emit : nullptr, compacts ? 1 : 0));
    memory = std::move(output);
    if (compacts) {
        const size_t bytes = size.download<unsigned long long>()[0];
        Buffer smaller(bytes);
        OPTIX_TRY(optixAccelCompact(context, nullptr, handle, smaller.ptr(), bytes, &handle));
        CUDA_TRY(cudaDeviceSynchronize());
        memory = std::move(smaller);
    }
    CUDA_TRY(cudaDeviceSynchronize());
    return handle;
}

template <class Body>
static int runChecked(Body body) {
    try {
        const bool right = body();
        std::printf(right ? "ok\n" : "wrong\n");
        return right ? 0 : 1;
    } catch (const std::exception& error) {
        std::printf("%s\n", error.what());
        return 1;
    }
}
