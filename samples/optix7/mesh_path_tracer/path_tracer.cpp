// SPDX-License-Identifier: Apache-2.0
#include "path_tracer.h"

#include <algorithm>
#include <cmath>

std::string_view path_tracer_ptx(); // the PTX of path_tracer.cu, built into this program

PathTracer::PathTracer(OptixDeviceContext context, const HostScene& scene, const Scene& studio,
                       const Camera& camera, unsigned width, unsigned height)
    : width_(width), height_(height),
      program_(context, path_tracer_ptx(), 4, 2, OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) {
    makeTable(std::any_of(scene.materials.begin(), scene.materials.end(),
                          [](const Material& m) { return m.alpha != kOpaque; }));
    params_.scene = studio;
    upload(scene);

    CUdeviceptr vertexAddress = positions_.address();
    unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& triangles = input.triangleArray;
    triangles.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    triangles.vertexStrideInBytes = sizeof(float3);
    triangles.numVertices = unsigned(scene.positions.size());
    triangles.vertexBuffers = &vertexAddress;
    triangles.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    triangles.indexStrideInBytes = sizeof(uint3);
    triangles.numIndexTriplets = unsigned(scene.triangles.size());
    triangles.indexBuffer = triangles_.address();
    triangles.flags = &flags;
    triangles.numSbtRecords = 1;
    accel_ = buildAccel(context, input);

    sum_.allocate(size_t(width) * height * sizeof(float4));
    deviceParams_.allocate(sizeof(Params));
    params_.sum = sum_.as<float4>();
    params_.camera = camera;
    params_.traversable = accel_.handle;
}

void PathTracer::upload(const HostScene& scene) {
    positions_.upload(scene.positions);
    normals_.upload(scene.normals);
    triangles_.upload(scene.triangles);
    materialOfTriangle_.upload(scene.materialOfTriangle);
    materials_.upload(scene.materials);
    params_.scene.mesh = {positions_.as<float3>(), normals_.as<float3>(), triangles_.as<uint3>(),
                          materialOfTriangle_.as<unsigned>(), materials_.as<Material>()};
    uploadLooks(scene);
}

void PathTracer::uploadLooks(const HostScene& scene) {
    Mesh& mesh = params_.scene.mesh;
    if (!scene.colors.empty()) {
        colors_.upload(scene.colors);
        mesh.colors = colors_.as<float4>();
    }
    if (scene.texcoords.empty() || scene.textures.empty())
        return;
    texcoords_.upload(scene.texcoords);
    std::vector<float> linear;
    for (int byte = 0; byte < 256; ++byte) {
        const float value = float(byte) / 255.0f;
        linear.push_back(value <= 0.04045f ? value / 12.92f
                                           : std::pow((value + 0.055f) / 1.055f, 2.4f));
    }
    linear_.upload(linear);
    std::vector<Texture> textures;
    for (const HostTexture& texture : scene.textures) {
        texels_.emplace_back();
        texels_.back().upload(texture.texels);
        textures.push_back(
            {texels_.back().as<unsigned>(), linear_.as<float>(), texture.width, texture.height});
    }
    textures_.upload(textures);
    mesh.texcoords = texcoords_.as<float2>();
    mesh.textures = textures_.as<Texture>();
}

void PathTracer::makeTable(bool hasHoles) {
    auto raygen =
        makeRecord(program_.addRaygen(hasHoles ? "__raygen__paths_with_holes" : "__raygen__paths"));
    raygenRecord_.upload(&raygen, sizeof(raygen));
    std::vector<SbtRecord<NoData>> misses(kRayTypeCount);
    misses[kRadianceRay] = makeRecord(program_.addMiss("__miss__radiance"));
    misses[kShadowRay] = makeRecord(program_.addMiss("__miss__shadow"));
    missRecords_.upload(misses);
    auto hit = makeRecord(program_.addHitgroup("__closesthit__mesh", nullptr, nullptr));
    hitRecord_.upload(&hit, sizeof(hit));
    table_.raygenRecord = raygenRecord_.address();
    table_.missRecordBase = missRecords_.address();
    table_.missRecordStrideInBytes = sizeof(misses[0]);
    table_.missRecordCount = kRayTypeCount;
    table_.hitgroupRecordBase = hitRecord_.address();
    table_.hitgroupRecordStrideInBytes = sizeof(hit);
    table_.hitgroupRecordCount = 1;
    pipeline_ = program_.link(1);
}

void PathTracer::addSamples(unsigned samples) {
    params_.sampleCount = samples;
    CUDA_CHECK(cudaMemcpy(deviceParams_.data(), &params_, sizeof(Params), cudaMemcpyHostToDevice));
    OPTIX_CHECK(optixLaunch(pipeline_, nullptr, deviceParams_.address(), sizeof(Params), &table_,
                            width_, height_, 1));
    CUDA_CHECK(cudaDeviceSynchronize());
    params_.firstSample += samples;
}

void PathTracer::wantGuides(const Camera& previous) {
    size_t pixels = size_t(width_) * height_;
    albedo_.allocate(pixels * sizeof(float4));
    normal_.allocate(pixels * sizeof(float4));
    flow_.allocate(pixels * sizeof(float2));
    params_.guides = {albedo_.as<float4>(), normal_.as<float4>(), flow_.as<float2>()};
    params_.previousCamera = previous;
}

std::vector<float> PathTracer::meanOf(const DeviceBuffer& sums) const {
    std::vector<float> pixels = sums.download<float>();
    for (float& value : pixels)
        value /= float(std::max(params_.firstSample, 1u));
    return pixels;
}
