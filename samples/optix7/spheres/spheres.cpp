// SPDX-License-Identifier: Apache-2.0
// Spheres as custom primitives, with one row of the shader binding table for each material and two
// kinds of rays. Read triangle first.
#include "picture.h"

#include <optix_function_table_definition.h>

#include "params.h"

std::string_view spheres_ptx(); // the PTX of spheres.cu, built into this program

namespace {

struct Scene {
    std::vector<Sphere> spheres;
    std::vector<unsigned> materials; // for each sphere
};

Scene makeScene() {
    Scene scene;
    auto add = [&](Material material, float3 center, float radius, float3 color,
                   float index = 1.0f) {
        scene.spheres.push_back({center, radius, color, index});
        scene.materials.push_back(material);
    };
    add(kCheckered, vec(0.0f, -500.0f, 0.0f), 500.0f, vec(0.8f, 0.78f, 0.72f));
    add(kMatte, vec(-2.3f, 1.0f, 0.0f), 1.0f, vec(0.8f, 0.2f, 0.12f));
    add(kGlass, vec(0.0f, 1.0f, 0.8f), 1.0f, vec(0.97f, 1.0f, 0.98f), 1.5f);
    add(kMetal, vec(2.3f, 1.0f, 0.0f), 1.0f, vec(0.95f, 0.8f, 0.5f));
    add(kCutout, vec(0.2f, 1.3f, -2.4f), 1.3f, vec(0.25f, 0.55f, 0.3f));
    add(kMetal, vec(-1.2f, 0.35f, 2.0f), 0.35f, vec(0.9f, 0.9f, 0.92f));
    add(kMatte, vec(1.3f, 0.35f, 2.1f), 0.35f, vec(0.15f, 0.35f, 0.8f));
    return scene;
}

// One box for each sphere, and for each sphere the row of the shader binding table it uses.
Accel buildSpheres(OptixDeviceContext context, const Scene& scene) {
    std::vector<OptixAabb> boxes;
    for (const Sphere& sphere : scene.spheres) {
        float3 low = sphere.center - vec(sphere.radius), high = sphere.center + vec(sphere.radius);
        boxes.push_back({low.x, low.y, low.z, high.x, high.y, high.z});
    }
    DeviceBuffer deviceBoxes, deviceMaterials;
    deviceBoxes.upload(boxes);
    deviceMaterials.upload(scene.materials);
    CUdeviceptr boxAddress = deviceBoxes.address();

    std::vector<unsigned> flags(kMaterialCount, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
    flags[kCutout] = OPTIX_GEOMETRY_FLAG_NONE;
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    OptixBuildInputCustomPrimitiveArray& custom = input.customPrimitiveArray;
    custom.aabbBuffers = &boxAddress;
    custom.numPrimitives = unsigned(boxes.size());
    custom.flags = flags.data();
    custom.numSbtRecords = kMaterialCount;
    custom.sbtIndexOffsetBuffer = deviceMaterials.address();
    custom.sbtIndexOffsetSizeInBytes = sizeof(unsigned);
    custom.sbtIndexOffsetStrideInBytes = sizeof(unsigned);
    return buildAccel(context, input);
}

std::vector<SbtRecord<NoData>> makeHitRecords(Program& program) {
    const char* shaders[kMaterialCount] = {"__closesthit__matte", "__closesthit__checkered",
                                           "__closesthit__metal", "__closesthit__glass",
                                           "__closesthit__matte"};
    std::vector<SbtRecord<NoData>> records;
    for (unsigned material = 0; material < kMaterialCount; ++material) {
        const char* anyHit = material == kCutout ? "__anyhit__cutout" : nullptr;
        records.push_back(
            makeRecord(program.addHitgroup(shaders[material], anyHit, "__intersection__sphere")));
        records.push_back(
            makeRecord(program.addHitgroup(nullptr, anyHit, "__intersection__sphere")));
    }
    return records;
}

void render(OptixDeviceContext context, const Picture& picture, unsigned samplesPerAxis) {
    Scene scene = makeScene();
    Accel accel = buildSpheres(context, scene);
    Program program(context, spheres_ptx(), 4, 2, OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);

    auto raygenRecord = makeRecord(program.addRaygen("__raygen__camera"));
    std::vector<SbtRecord<NoData>> missRecords = {makeRecord(program.addMiss("__miss__sky")),
                                                  makeRecord(program.addMiss("__miss__shadow"))};
    std::vector<SbtRecord<NoData>> hitRecords = makeHitRecords(program);
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
    OptixPipeline pipeline = program.link(kMaxTraceDepth);

    DeviceBuffer image(picture.pixels() * sizeof(float4));
    DeviceBuffer spheres;
    spheres.upload(scene.spheres);
    Params params = {};
    params.image = image.as<float4>();
    params.spheres = spheres.as<Sphere>();
    params.camera = makeCamera(vec(0.5f, 2.2f, 8.0f), vec(0.0f, 0.9f, 0.0f), vec(0.0f, 1.0f, 0.0f),
                               36.0f, picture.aspect());
    params.lightDirection = normalize(vec(-0.6f, 1.0f, 0.7f));
    params.scene = accel.handle;
    params.samplesPerAxis = samplesPerAxis;
    launch(pipeline, sbt, params, picture);
    writePicture(picture, image);
}

} // namespace

int main(int argc, char** argv) {
    Picture picture = {"spheres.png", 960, 540};
    unsigned samplesPerAxis = 2;
    Arguments arguments("Ray traces spheres with an intersection program and several materials.");
    addPictureOptions(arguments, picture);
    arguments.add("--samples-per-axis", samplesPerAxis, 1, 16, "rays for a pixel, square root");
    return runSample("spheres", arguments, argc, argv,
                     [&](OptixDeviceContext context) { render(context, picture, samplesPerAxis); });
}
