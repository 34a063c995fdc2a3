// SPDX-License-Identifier: Apache-2.0
// OptiX code shared by the benchmarks of rays: device memory, a pipeline of the programs in
// launch_rays.cu, a mesh with its acceleration structure. The Embree side is in embree_rays.h.
#pragma once

#include "launch_rays.h"
#include "scenes.h"

#include <cuda_runtime.h>
#include <optix.h>
#include <optix_stubs.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace bench {

inline void check(OptixResult result, const char* call) {
    if (result == OPTIX_SUCCESS)
        return;
    std::fprintf(stderr, "%s failed: error %d\n", call, int(result));
    std::exit(1);
}
inline void check(cudaError_t result, const char* call) {
    if (result == cudaSuccess)
        return;
    std::fprintf(stderr, "%s failed: %s\n", call, cudaGetErrorString(result));
    std::exit(1);
}
#define CHECK(call) check(call, #call)

inline double seconds(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Processor time of all threads, which other programs on the machine disturb less than elapsed
// time.
inline double processSeconds(const std::function<void()>& work) {
    const auto now = [] {
        timespec t;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
        return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    };
    const double start = now();
    work();
    return now() - start;
}

// Device memory.
class Buffer {
public:
    explicit Buffer(size_t size) {
        CHECK(cudaMalloc(&memory_, std::max<size_t>(size, 16)));
    }
    template <class T>
    explicit Buffer(const std::vector<T>& from) : Buffer(from.size() * sizeof(T)) {
        CHECK(cudaMemcpy(memory_, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice));
    }
    Buffer(Buffer&& other) noexcept : memory_(std::exchange(other.memory_, nullptr)) {}
    Buffer& operator=(Buffer&& other) noexcept {
        std::swap(memory_, other.memory_);
        return *this;
    }
    ~Buffer() { cudaFree(memory_); }
    CUdeviceptr address() const { return reinterpret_cast<CUdeviceptr>(memory_); }
    template <class T>
    T* as() const {
        return static_cast<T*>(memory_);
    }
    template <class T>
    std::vector<T> read(size_t count) const {
        std::vector<T> out(count);
        CHECK(cudaMemcpy(out.data(), memory_, count * sizeof(T), cudaMemcpyDeviceToHost));
        return out;
    }

private:
    void* memory_ = nullptr;
};

struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) Record {
    char header[OPTIX_SBT_RECORD_HEADER_SIZE];
};

inline void onLog(unsigned level, const char* tag, const char* text, void*) {
    if (level <= 3)
        std::fprintf(stderr, "[%s] %s\n", tag, text);
}

// The OptiX side: one pipeline with two ray generation programs.
class Optix {
public:
    enum Kind { kClosest, kAny };

    // `type`: the primitives that rays may meet.
    explicit Optix(unsigned graphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS,
                   OptixPrimitiveType type = OPTIX_PRIMITIVE_TYPE_TRIANGLE,
                   std::string ptx = BENCH_PTX, bool motion = false)
        : graphFlags_(graphFlags), type_(type), ptx_(std::move(ptx)), motion_(motion),
          records_(4 * sizeof(Record)), params_(sizeof(LaunchRaysParams)) {
        CHECK(cudaFree(nullptr));
        CHECK(optixInit());
        OptixDeviceContextOptions options = {};
        options.logCallbackFunction = onLog;
        options.logCallbackLevel = 4;
        CHECK(optixDeviceContextCreate(nullptr, &options, &context));
        createPipeline();
    }

    OptixDeviceContext context = nullptr;

    // Uploads the data of a series of launches.
    void prepare(const Buffer& rays, const Buffer& hits, OptixTraversableHandle handle) {
        LaunchRaysParams params;
        params.rays = rays.as<BenchRay>();
        params.hits = hits.as<BenchHit>();
        params.handle = handle;
        params.shutter = motion_ ? 1.0f : 0.0f;
        CHECK(cudaMemcpy(params_.as<void>(), &params, sizeof(params), cudaMemcpyHostToDevice));
    }

    // Traces `count` rays and waits.
    void launch(Kind kind, size_t count) {
        queue(kind, count);
        CHECK(cudaDeviceSynchronize());
    }

    void queue(Kind kind, size_t count) {
        OptixShaderBindingTable sbt = {};
        sbt.raygenRecord = records_.address() + kind * sizeof(Record);
        sbt.missRecordBase = records_.address() + 2 * sizeof(Record);
        sbt.missRecordStrideInBytes = sizeof(Record);
        sbt.missRecordCount = 1;
        sbt.hitgroupRecordBase = records_.address() + 3 * sizeof(Record);
        sbt.hitgroupRecordStrideInBytes = sizeof(Record);
        sbt.hitgroupRecordCount = 1;
        CHECK(optixLaunch(pipeline_, nullptr, params_.address(), sizeof(LaunchRaysParams), &sbt,
                          unsigned(count), 1, 1));
    }

private:
    void createPipeline() {
        std::ifstream file(ptx_);
        std::stringstream text;
        text << file.rdbuf();
        const std::string ptx = text.str();
        OptixModuleCompileOptions moduleOptions = {};
        OptixPipelineCompileOptions options = {};
        options.traversableGraphFlags = graphFlags_;
        options.numPayloadValues = 2;
        options.usesMotionBlur = motion_;
        options.numAttributeValues = 2;
        options.pipelineLaunchParamsVariableName = "params";
        if (type_ != OPTIX_PRIMITIVE_TYPE_TRIANGLE)
            options.usesPrimitiveTypeFlags = 1u << (type_ - OPTIX_PRIMITIVE_TYPE_CUSTOM);
        OptixModule module = nullptr;
        CHECK(optixModuleCreateFromPTX(context, &moduleOptions, &options, ptx.data(), ptx.size(),
                                       nullptr, nullptr, &module));
        OptixProgramGroupDesc descs[4] = {};
        const char* names[] = {"__raygen__closest", "__raygen__any", "__miss__clear"};
        for (int i = 0; i < 3; ++i) {
            descs[i].kind = i < 2 ? OPTIX_PROGRAM_GROUP_KIND_RAYGEN : OPTIX_PROGRAM_GROUP_KIND_MISS;
            descs[i].raygen.module = module; // raygen and miss have one place in the union
            descs[i].raygen.entryFunctionName = names[i];
        }
        descs[3].kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        descs[3].hitgroup.moduleCH = module;
        descs[3].hitgroup.entryFunctionNameCH = "__closesthit__store";
        if (type_ != OPTIX_PRIMITIVE_TYPE_TRIANGLE) {
            OptixBuiltinISOptions builtin = {};
            builtin.builtinISModuleType = type_;
            builtin.usesMotionBlur = motion_;
            CHECK(optixBuiltinISModuleGet(context, &moduleOptions, &options, &builtin,
                                          &descs[3].hitgroup.moduleIS));
        }
        OptixProgramGroupOptions groupOptions = {};
        OptixProgramGroup groups[4] = {};
        CHECK(optixProgramGroupCreate(context, descs, 4, &groupOptions, nullptr, nullptr, groups));
        OptixPipelineLinkOptions link = {};
        link.maxTraceDepth = 1;
        CHECK(optixPipelineCreate(context, &options, &link, groups, 4, nullptr, nullptr,
                                  &pipeline_));
        std::vector<Record> records(4);
        for (int i = 0; i < 4; ++i)
            CHECK(optixSbtRecordPackHeader(groups[i], &records[i]));
        records_ = Buffer(records);
    }

    unsigned graphFlags_;
    OptixPrimitiveType type_;
    std::string ptx_; // path
    bool motion_;
    OptixPipeline pipeline_ = nullptr;
    Buffer records_, params_;
};

// A mesh on the device and its acceleration structure.
class Structure {
public:
    Structure(Optix& optix, const Mesh& mesh, unsigned buildFlags = 0)
        : optix_(optix), vertices_(mesh.vertices), indices_(mesh.indices), temp_(16), output_(16) {
        vertexBuffer_ = vertices_.address();
        input_.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        OptixBuildInputTriangleArray& t = input_.triangleArray;
        t.vertexBuffers = &vertexBuffer_;
        t.numVertices = mesh.numVertices();
        t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        t.indexBuffer = indices_.address();
        t.numIndexTriplets = mesh.numTriangles();
        t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
        t.flags = &flags_;
        t.numSbtRecords = 1;
        options_.buildFlags = OPTIX_BUILD_FLAG_ALLOW_COMPACTION | buildFlags;
        options_.operation = OPTIX_BUILD_OPERATION_BUILD;
        CHECK(optixAccelComputeMemoryUsage(optix.context, &options_, &input_, 1, &sizes_));
        temp_ = Buffer(sizes_.tempSizeInBytes);
        output_ = Buffer(sizes_.outputSizeInBytes);
    }

    void build() {
        queue();
        CHECK(cudaDeviceSynchronize());
    }
    void queue() {
        OptixAccelEmitDesc emit = {compacted_.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
        CHECK(optixAccelBuild(optix_.context, nullptr, &options_, &input_, 1, temp_.address(),
                              sizes_.tempSizeInBytes, output_.address(), sizes_.outputSizeInBytes,
                              &handle, &emit, 1));
    }
    uint64_t compactedSize() const { return compacted_.read<uint64_t>(1)[0]; }
    const OptixAccelBufferSizes& sizes() const { return sizes_; }

    OptixTraversableHandle handle = 0;

private:
    Optix& optix_;
    Buffer vertices_, indices_, temp_, output_, compacted_{sizeof(uint64_t)};
    CUdeviceptr vertexBuffer_ = 0;
    unsigned flags_ = OPTIX_GEOMETRY_FLAG_NONE;
    OptixBuildInput input_ = {};
    OptixAccelBuildOptions options_ = {};
    OptixAccelBufferSizes sizes_ = {};
};

} // namespace bench
