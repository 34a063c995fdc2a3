// SPDX-License-Identifier: Apache-2.0
// Renders a scene with OptiX 7: an instance has its own record for each ray type.
#include "scene.h"

#include "modern.h"

#include "optix_setup.h"

#include <optix_function_table_definition.h>

#include <cstring>
#include <fstream>
#include <iterator>

namespace sunstone::pictures {

namespace {

class Drawing {
public:
    Drawing(OptixDeviceContext context, const Scene& scene, const std::string& ptx)
        : scene_(scene), context_(context),
          program_(context_, ptx, 5, 3,
                   scene.spheres.empty() ? OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE
                                         : OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM,
                   "params", OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING) {
        vertices_.upload(scene.vertices);
        triangles_.upload(scene.triangles);
        spheres_.upload(scene.spheres);
    }

    Picture draw() {
        const SbtRecord<NoData> raygenRecord = makeRecord(program_.addRaygen("__raygen__draw"));
        const std::vector<SbtRecord<NoData>> missRecords = {
            makeRecord(program_.addMiss("__miss__radiance")),
            makeRecord(program_.addMiss("__miss__shadow"))};
        const std::vector<SbtRecord<HitData>> hitRecords = records();
        DeviceBuffer raygen, miss, hit, params;
        raygen.upload(&raygenRecord, sizeof raygenRecord);
        miss.upload(missRecords);
        hit.upload(hitRecords);
        OptixShaderBindingTable sbt = {};
        sbt.raygenRecord = raygen.address();
        sbt.missRecordBase = miss.address();
        sbt.missRecordStrideInBytes = sizeof missRecords[0];
        sbt.missRecordCount = unsigned(missRecords.size());
        sbt.hitgroupRecordBase = hit.address();
        sbt.hitgroupRecordStrideInBytes = sizeof hitRecords[0];
        sbt.hitgroupRecordCount = unsigned(hitRecords.size());
        const OptixPipeline pipeline = program_.link(5, 2);

        const Accel geometry = buildAccel(context_, input());
        const Accel top = buildInstances(context_, instances(geometry.handle));
        DeviceBuffer picture(size_t(kWidth) * kHeight * sizeof(float4));
        const Params values = {picture.as<float4>(), vertices_.as<float3>(), triangles_.as<uint3>(),
                               spheres_.as<float4>(), top.handle};
        params.upload(&values, sizeof values);
        OPTIX_CHECK(optixLaunch(pipeline, nullptr, params.address(), sizeof values, &sbt, kWidth,
                                kHeight, 1));
        CUDA_CHECK(cudaDeviceSynchronize());
        return picture.download<std::array<float, 4>>();
    }

private:
    std::vector<SbtRecord<HitData>> records() {
        const bool isMesh = scene_.spheres.empty();
        const char* closest = isMesh ? "__closesthit__triangle" : "__closesthit__sphere";
        const char* intersection = isMesh ? nullptr : "__intersection__sphere";
        const OptixProgramGroup radiance = program_.addHitgroup(
            closest, scene_.isTransparent ? "__anyhit__cut" : nullptr, intersection);
        const OptixProgramGroup shadow = program_.addHitgroup(
            nullptr, scene_.isTransparent ? "__anyhit__dim" : "__anyhit__block", intersection);
        std::vector<SbtRecord<HitData>> made;
        for (const Instance& each : scene_.instances) {
            const HitData data = {{each.albedo[0], each.albedo[1], each.albedo[2]}};
            made.push_back(makeRecord(radiance, data));
            made.push_back(makeRecord(shadow, data));
        }
        return made;
    }
    OptixBuildInput input() {
        OptixBuildInput made = {};
        flags_ = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
        if (scene_.spheres.empty()) {
            made.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
            OptixBuildInputTriangleArray& mesh = made.triangleArray;
            vertexAddress_ = vertices_.address();
            mesh.vertexBuffers = &vertexAddress_;
            mesh.numVertices = unsigned(scene_.vertices.size());
            mesh.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
            mesh.indexBuffer = triangles_.address();
            mesh.numIndexTriplets = unsigned(scene_.triangles.size());
            mesh.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
            mesh.flags = &flags_;
            mesh.numSbtRecords = 1;
            return made;
        }
        std::vector<OptixAabb> boxes;
        for (const auto& s : scene_.spheres)
            boxes.push_back(
                {s[0] - s[3], s[1] - s[3], s[2] - s[3], s[0] + s[3], s[1] + s[3], s[2] + s[3]});
        boxes_.upload(boxes);
        boxAddress_ = boxes_.address();
        made.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        made.customPrimitiveArray.aabbBuffers = &boxAddress_;
        made.customPrimitiveArray.numPrimitives = unsigned(boxes.size());
        made.customPrimitiveArray.flags = &flags_;
        made.customPrimitiveArray.numSbtRecords = 1;
        return made;
    }
    std::vector<OptixInstance> instances(OptixTraversableHandle geometry) {
        std::vector<OptixInstance> made;
        for (const Instance& each : scene_.instances) {
            OptixInstance instance = {};
            std::memcpy(instance.transform, each.matrix.data(), sizeof instance.transform);
            instance.sbtOffset = unsigned(made.size()) * 2;
            instance.visibilityMask = 255;
            instance.traversableHandle = geometry;
            made.push_back(instance);
        }
        return made;
    }

    const Scene& scene_;
    OptixDeviceContext context_;
    Program program_;
    DeviceBuffer vertices_, triangles_, spheres_, boxes_;
    CUdeviceptr vertexAddress_ = 0, boxAddress_ = 0;
    unsigned flags_ = 0;
};

} // namespace

Picture drawModern(const Scene& scene, const std::string& ptxFile) {
    std::ifstream file(ptxFile);
    const std::string ptx(std::istreambuf_iterator<char>(file), {});
    const OptixDeviceContext context = createContext();
    Picture picture = Drawing(context, scene, ptx).draw();
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    return picture;
}

} // namespace sunstone::pictures
