// SPDX-License-Identifier: Apache-2.0
// The OptiX 7 side of twins.h.
#define BENCH_PTX BENCH_OPTIX7_PTX
#include "../optix_rays.h"
#include "twins.h"

#include <optix_function_table_definition.h>

#include <cstring>

namespace twin {
namespace {

using bench::Buffer;
using bench::check;
using bench::Record;

struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) HitRecord {
    char header[OPTIX_SBT_RECORD_HEADER_SIZE];
    HitData data;
};

class Optix7 : public Renderer {
public:
    Optix7(const Scene& scene, unsigned width, unsigned height, unsigned samples)
        : width_(width), height_(height), vertices_(scene.vertices), indices_(scene.indices),
          spheres_(scene.spheres), picture_(size_t(16) * width * height) {
        CHECK(cudaFree(nullptr));
        CHECK(optixInit());
        CHECK(optixDeviceContextCreate(nullptr, nullptr, &context_));
        makePipeline(scene.spheres.empty());
        const OptixTraversableHandle child =
            scene.spheres.empty() ? buildMesh(scene) : buildSpheres(scene);
        Params params{};
        params.traversable = buildInstances(scene, child);
        params.picture = picture_.as<float>();
        params.samples = samples;
        params.camera = scene.camera;
        params_ = Buffer(std::vector<Params>{params});
    }
    ~Optix7() override {
        optixPipelineDestroy(pipeline_);
        optixDeviceContextDestroy(context_);
    }

    void launch() override {
        CHECK(optixLaunch(pipeline_, nullptr, params_.address(), sizeof(Params), &sbt_, width_,
                          height_, 1));
        CHECK(cudaDeviceSynchronize());
    }
    std::vector<float> picture() override {
        return picture_.read<float>(size_t(4) * width_ * height_);
    }

private:
    void makePipeline(bool isMesh) {
        const std::string ptx = readDeviceCode(BENCH_OPTIX7_PTX);
        OptixModuleCompileOptions moduleOptions = {};
        OptixPipelineCompileOptions options = {};
        options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        options.numPayloadValues = 2;
        options.numAttributeValues = 3;
        options.pipelineLaunchParamsVariableName = "params";
        OptixModule module = nullptr;
        CHECK(optixModuleCreateFromPTX(context_, &moduleOptions, &options, ptx.data(), ptx.size(),
                                       nullptr, nullptr, &module));
        OptixProgramGroupDesc d[5] = {};
        d[0].kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
        d[0].raygen = {module, "__raygen__paths"};
        d[1].kind = d[2].kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
        d[1].miss = {module, "__miss__path"};
        d[2].miss = {module, "__miss__shadow"};
        for (int i = 3; i < 5; ++i) {
            d[i].kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
            if (!isMesh) {
                d[i].hitgroup.moduleIS = module;
                d[i].hitgroup.entryFunctionNameIS = "__intersection__sphere";
            }
        }
        d[3].hitgroup.moduleCH = d[4].hitgroup.moduleAH = module;
        d[3].hitgroup.entryFunctionNameCH = isMesh ? "__closesthit__mesh" : "__closesthit__sphere";
        d[4].hitgroup.entryFunctionNameAH = "__anyhit__shadow";
        OptixProgramGroupOptions groupOptions = {};
        OptixProgramGroup groups[5] = {};
        CHECK(optixProgramGroupCreate(context_, d, 5, &groupOptions, nullptr, nullptr, groups));
        OptixPipelineLinkOptions link = {};
        link.maxTraceDepth = 2;
        CHECK(optixPipelineCreate(context_, &options, &link, groups, 5, nullptr, nullptr,
                                  &pipeline_));
        makeRecords(groups);
    }
    void makeRecords(const OptixProgramGroup* groups) {
        std::vector<Record> records(3);
        for (int i = 0; i < 3; ++i)
            CHECK(optixSbtRecordPackHeader(groups[i], &records[i]));
        std::vector<HitRecord> hits(2);
        for (int i = 0; i < 2; ++i) {
            CHECK(optixSbtRecordPackHeader(groups[3 + i], &hits[i]));
            hits[i].data = {vertices_.as<float>(),
                            indices_.as<unsigned>(),
                            spheres_.as<float>(),
                            {0.75f, 0.62f, 0.5f}};
        }
        records_ = Buffer(records);
        hits_ = Buffer(hits);
        sbt_.raygenRecord = records_.address();
        sbt_.missRecordBase = records_.address() + sizeof(Record);
        sbt_.missRecordStrideInBytes = sizeof(Record);
        sbt_.missRecordCount = 2;
        sbt_.hitgroupRecordBase = hits_.address();
        sbt_.hitgroupRecordStrideInBytes = sizeof(HitRecord);
        sbt_.hitgroupRecordCount = 2;
    }

    OptixTraversableHandle build(const OptixBuildInput& input) {
        OptixAccelBuildOptions options = {};
        options.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
        options.operation = OPTIX_BUILD_OPERATION_BUILD;
        OptixAccelBufferSizes sizes = {};
        CHECK(optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes));
        Buffer temp(sizes.tempSizeInBytes);
        structures_.emplace_back(sizes.outputSizeInBytes);
        OptixTraversableHandle handle = 0;
        CHECK(optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(),
                              sizes.tempSizeInBytes, structures_.back().address(),
                              sizes.outputSizeInBytes, &handle, nullptr, 0));
        CHECK(cudaDeviceSynchronize());
        return handle;
    }
    OptixTraversableHandle buildMesh(const Scene& scene) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
        const CUdeviceptr vertices = vertices_.address();
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        input.triangleArray.vertexBuffers = &vertices;
        input.triangleArray.numVertices = unsigned(scene.vertices.size() / 3);
        input.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        input.triangleArray.indexBuffer = indices_.address();
        input.triangleArray.numIndexTriplets = unsigned(scene.indices.size() / 3);
        input.triangleArray.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
        input.triangleArray.flags = &flags;
        input.triangleArray.numSbtRecords = 1;
        return build(input);
    }
    OptixTraversableHandle buildSpheres(const Scene& scene) {
        std::vector<OptixAabb> boxes;
        for (size_t i = 0; i < scene.spheres.size(); i += 4) {
            const float* s = &scene.spheres[i];
            boxes.push_back(
                {s[0] - s[3], s[1] - s[3], s[2] - s[3], s[0] + s[3], s[1] + s[3], s[2] + s[3]});
        }
        const Buffer memory(boxes);
        const CUdeviceptr address = memory.address();
        const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        input.customPrimitiveArray.aabbBuffers = &address;
        input.customPrimitiveArray.numPrimitives = unsigned(boxes.size());
        input.customPrimitiveArray.flags = &flags;
        input.customPrimitiveArray.numSbtRecords = 1;
        return build(input);
    }
    OptixTraversableHandle buildInstances(const Scene& scene, OptixTraversableHandle child) {
        std::vector<OptixInstance> instances;
        for (const std::array<float, 12>& matrix : scene.instances) {
            OptixInstance instance = {};
            std::memcpy(instance.transform, matrix.data(), sizeof instance.transform);
            instance.visibilityMask = 255;
            instance.traversableHandle = child;
            instances.push_back(instance);
        }
        const Buffer memory(instances);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
        input.instanceArray.instances = memory.address();
        input.instanceArray.numInstances = unsigned(instances.size());
        return build(input);
    }

    const unsigned width_, height_;
    Buffer vertices_, indices_, spheres_, picture_, params_{16}, records_{16}, hits_{16};
    std::vector<Buffer> structures_;
    OptixDeviceContext context_ = nullptr;
    OptixPipeline pipeline_ = nullptr;
    OptixShaderBindingTable sbt_ = {};
};

} // namespace

std::unique_ptr<Renderer> makeOptix7(const Scene& scene, unsigned width, unsigned height,
                                     unsigned samples) {
    return std::make_unique<Optix7>(scene, width, height, samples);
}

} // namespace twin
