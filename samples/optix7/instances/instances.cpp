// SPDX-License-Identifier: Apache-2.0
// Instances of instances: a cube of twelve triangles, twenty copies of which make a sponge, twenty
// of which make a larger one, and so on. The deepest has 20^6 = 64 million cubes, but memory holds
// only a cube and one small structure for each level. Read triangle first.
#include "picture.h"
#include "sampling.h"

#include <optix_function_table_definition.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "params.h"

std::string_view instances_ptx(); // the PTX of instances.cu, built into this program

namespace {

// A rotation about the y axis, a scale, then a translation.
OptixInstance place(const Accel& child, float turns, float scale, float3 at, unsigned id,
                    unsigned sbtOffset) {
    float2 circle = circlePoint(turns);
    float c = circle.x * scale, s = circle.y * scale;
    float matrix[12] = {c, 0, s, at.x, 0, scale, 0, at.y, -s, 0, c, at.z};
    OptixInstance instance = {};
    std::memcpy(instance.transform, matrix, sizeof(matrix));
    instance.instanceId = id;
    instance.sbtOffset = sbtOffset;
    instance.visibilityMask = 255;
    instance.traversableHandle = child.handle;
    return instance;
}

Accel buildTriangles(OptixDeviceContext context, const std::vector<float3>& corners) {
    DeviceBuffer vertices;
    vertices.upload(corners);
    CUdeviceptr vertexAddress = vertices.address();
    unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    input.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    input.triangleArray.vertexStrideInBytes = sizeof(float3);
    input.triangleArray.numVertices = unsigned(corners.size());
    input.triangleArray.vertexBuffers = &vertexAddress;
    input.triangleArray.flags = &flags;
    input.triangleArray.numSbtRecords = 1;
    return buildAccel(context, input);
}

// A cube of edge 1 around the origin; two triangles for each side, in the order -x +x -y +y -z +z.
std::vector<float3> cubeCorners() {
    std::vector<float3> corners;
    for (int side = 0; side < 6; ++side) {
        auto corner = [&](float u, float v) {
            float w = side % 2 ? 0.5f : -0.5f;
            return side / 2 == 0 ? vec(w, u, v) : side / 2 == 1 ? vec(u, w, v) : vec(u, v, w);
        };
        float3 a = corner(-0.5f, -0.5f), b = corner(0.5f, -0.5f);
        float3 c = corner(0.5f, 0.5f), d = corner(-0.5f, 0.5f);
        corners.insert(corners.end(), {a, b, c, a, c, d});
    }
    return corners;
}

// The structures that make up the scene; each refers to those before it.
struct Scene {
    std::vector<Accel> levels; // 0: the cube; n: twenty copies of level n - 1
    Accel ground, whole;
    unsigned graphDepth = 0;
};

Scene buildScene(OptixDeviceContext context, unsigned depth) {
    Scene scene;
    scene.levels.push_back(buildTriangles(context, cubeCorners()));
    for (unsigned level = 1; level <= depth; ++level) {
        std::vector<OptixInstance> copies;
        for (int i = 0; i < 27; ++i) {
            int x = i % 3 - 1, y = i / 3 % 3 - 1, z = i / 9 - 1;
            if ((x == 0) + (y == 0) + (z == 0) >= 2)
                continue; // the middle, and the middles of the sides
            copies.push_back(place(scene.levels.back(), 0.0f, 1.0f / 3.0f,
                                   vec(float(x), float(y), float(z)) / 3.0f,
                                   unsigned(copies.size()), level == 1 ? kCube : 0));
        }
        scene.levels.push_back(buildInstances(context, copies));
    }
    float3 a = vec(-500, 0, -500), b = vec(500, 0, -500), c = vec(500, 0, 500),
           d = vec(-500, 0, 500);
    scene.ground = buildTriangles(context, {a, b, c, a, c, d});

    // A large sponge among rings of smaller ones, which have fewer levels.
    const Accel& deepest = scene.levels[depth];
    const Accel& middle = scene.levels[depth > 1 ? depth - 1 : 1];
    std::vector<OptixInstance> all = {place(scene.ground, 0.0f, 1.0f, vec(0.0f), 0, kGround),
                                      place(deepest, 0.09f, 2.4f, vec(0.0f, 1.2f, 0.0f), 3, 0)};
    for (unsigned ring = 0; ring < 5; ++ring)
        for (unsigned i = 0, count = 9 + 6 * ring; i < count; ++i) {
            float2 circle = circlePoint((float(i) + 0.37f * float(ring)) / float(count));
            float radius = 2.6f + 1.5f * float(ring);
            float size =
                0.35f + 0.25f * float(hashPcg(i + 100 * ring) % 100) * 0.01f + 0.1f * float(ring);
            float turns = float(hashPcg(7 * i + ring) % 1000) * 0.001f;
            all.push_back(place(middle, turns, size,
                                vec(circle.x * radius, size * 0.5f, circle.y * radius),
                                (i + ring) % 20, 0));
        }
    scene.whole = buildInstances(context, all);
    scene.graphDepth = depth + 2; // levels, the scene, geometry
    return scene;
}

void render(OptixDeviceContext context, const Picture& picture, unsigned samples, unsigned depth) {
    Scene scene = buildScene(context, depth);
    size_t bytes = scene.ground.memory.size() + scene.whole.memory.size();
    for (const Accel& level : scene.levels)
        bytes += level.memory.size();
    std::printf("%.0f cubes in the large sponge, %.1f KiB of structures\n", std::pow(20.0, depth),
                double(bytes) / 1024.0);

    Program program(context, instances_ptx(), 5, 2, OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE, "params",
                    OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY);
    auto raygenRecord = makeRecord(program.addRaygen("__raygen__camera"));
    std::vector<SbtRecord<NoData>> missRecords = {makeRecord(program.addMiss("__miss__sky")),
                                                  makeRecord(program.addMiss("__miss__shadow"))};
    std::vector<SbtRecord<NoData>> hitRecords(kShapeCount);
    hitRecords[kCube] = makeRecord(program.addHitgroup("__closesthit__cube", nullptr, nullptr));
    hitRecords[kGround] = makeRecord(program.addHitgroup("__closesthit__ground", nullptr, nullptr));
    DeviceBuffer raygen, miss, hit;
    raygen.upload(&raygenRecord, sizeof(raygenRecord));
    miss.upload(missRecords);
    hit.upload(hitRecords);
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = raygen.address();
    sbt.missRecordBase = miss.address();
    sbt.missRecordStrideInBytes = sizeof(missRecords[0]);
    sbt.missRecordCount = unsigned(missRecords.size());
    sbt.hitgroupRecordBase = hit.address();
    sbt.hitgroupRecordStrideInBytes = sizeof(hitRecords[0]);
    sbt.hitgroupRecordCount = unsigned(hitRecords.size());
    OptixPipeline pipeline = program.link(4, scene.graphDepth); // camera, two bounces, shadow

    DeviceBuffer image(picture.pixels() * sizeof(float4));
    Params params = {};
    params.image = image.as<float4>();
    params.camera = makeCamera(vec(0.6f, 2.6f, 4.4f), vec(0.05f, 1.05f, 0.0f),
                               vec(0.0f, 1.0f, 0.0f), 38.0f, picture.aspect());
    params.sunDirection = normalize(vec(0.75f, 0.8f, 0.35f));
    params.scene = scene.whole.handle;
    params.samples = samples;
    params.epsilon = 2e-5f;
    launch(pipeline, sbt, params, picture);
    writePicture(picture, image, true);
}

} // namespace

int main(int argc, char** argv) {
    Picture picture = {"instances.png", 960, 540};
    unsigned samples = 16, depth = 6;
    Arguments arguments("Ray traces instances of instances: sponges of up to 64 million cubes.");
    addPictureOptions(arguments, picture);
    arguments.add("--spp", samples, 1, 4096, "paths for a pixel");
    arguments.add("--depth", depth, 1, 12, "levels of instances in the large sponge");
    return runSample("instances", arguments, argc, argv,
                     [&](OptixDeviceContext context) { render(context, picture, samples, depth); });
}
