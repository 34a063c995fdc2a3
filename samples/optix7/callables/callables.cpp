// SPDX-License-Identifier: Apache-2.0
// Any pattern on any material: each sphere refers to two callables, a direct callable for the
// colour and a continuation callable for the reflected light. Read spheres first.
#include "picture.h"

#include <optix_function_table_definition.h>

#include "params.h"

std::string_view callables_ptx(); // the PTX of callables.cu, built into this program

namespace {

// One sphere for each pattern (across) and material (to the back), on a floor.
std::vector<Shape> makeShapes() {
    std::vector<Shape> shapes;
    auto add = [&](float3 center, float radius, unsigned pattern, unsigned material, float3 first,
                   float3 second) {
        shapes.push_back({center, radius, pattern, material, {first, second}});
    };
    add(vec(0.0f), 0.0f, kChecks, kPolished, vec(0.72f, 0.7f, 0.66f), vec(0.3f, 0.31f, 0.33f));
    const float3 first[] = {vec(0.85f, 0.2f, 0.12f), vec(0.9f, 0.85f, 0.75f),
                            vec(0.95f, 0.75f, 0.2f), vec(0.93f, 0.93f, 0.9f)};
    const float3 second[] = {vec(0.0f), vec(0.12f, 0.3f, 0.6f), vec(0.15f, 0.45f, 0.3f),
                             vec(0.12f, 0.14f, 0.2f)};
    for (unsigned pattern = 0; pattern < kPatternCount; ++pattern)
        for (unsigned row = 0; row < 4; ++row) {
            unsigned material = kMatte + row;
            float3 a = first[pattern], b = second[pattern];
            if (material == kMirror || material == kGlass) { // light ones let more through
                a = lerp(a, vec(1.0f), 0.55f);
                b = lerp(b, vec(1.0f), 0.4f);
            }
            // The matte ones are in front, larger ones behind.
            float radius = 0.55f + 0.13f * float(row);
            float x = (float(pattern) - 1.5f) * (1.75f + 0.2f * float(row));
            add(vec(x, radius, 2.2f - 1.9f * float(row)), radius, pattern, material, a, b);
        }
    return shapes;
}

Accel buildShapes(OptixDeviceContext context, const std::vector<Shape>& shapes) {
    std::vector<OptixAabb> boxes;
    for (const Shape& shape : shapes) {
        float3 half = shape.radius > 0.0f ? vec(shape.radius) : vec(kFloorSize, 1e-3f, kFloorSize);
        float3 low = shape.center - half, high = shape.center + half;
        boxes.push_back({low.x, low.y, low.z, high.x, high.y, high.z});
    }
    DeviceBuffer deviceBoxes;
    deviceBoxes.upload(boxes);
    CUdeviceptr boxAddress = deviceBoxes.address();
    unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    input.customPrimitiveArray.aabbBuffers = &boxAddress;
    input.customPrimitiveArray.numPrimitives = unsigned(boxes.size());
    input.customPrimitiveArray.flags = &flags;
    input.customPrimitiveArray.numSbtRecords = 1;
    return buildAccel(context, input);
}

std::vector<SbtRecord<CallableData>> makeCallables(Program& program) {
    std::vector<SbtRecord<CallableData>> records(kCallableCount);
    auto pattern = [&](unsigned row, const char* function, float scale) {
        records[row] = makeRecord(program.addCallables(function, nullptr), CallableData{scale});
    };
    auto material = [&](unsigned row, const char* function, float index) {
        records[row] = makeRecord(program.addCallables(nullptr, function), CallableData{index});
    };
    pattern(kSolid, "__direct_callable__solid", 1.0f);
    pattern(kChecks, "__direct_callable__checks", 3.0f);
    pattern(kRings, "__direct_callable__rings", 3.5f);
    pattern(kMarble, "__direct_callable__marble", 2.2f);
    material(kMatte, "__continuation_callable__matte", 1.0f);
    material(kPolished, "__continuation_callable__polished", 1.5f);
    material(kMirror, "__continuation_callable__mirror", 1.0f);
    material(kGlass, "__continuation_callable__glass", 1.45f);
    return records;
}

void render(OptixDeviceContext context, const Picture& picture, unsigned samplesPerAxis) {
    std::vector<Shape> hostShapes = makeShapes();
    Accel accel = buildShapes(context, hostShapes);
    Program program(context, callables_ptx(), 4, 2, OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
    auto raygenRecord = makeRecord(program.addRaygen("__raygen__camera"));
    std::vector<SbtRecord<NoData>> missRecords = {makeRecord(program.addMiss("__miss__sky")),
                                                  makeRecord(program.addMiss("__miss__shadow"))};
    auto hitRecord =
        makeRecord(program.addHitgroup("__closesthit__shape", nullptr, "__intersection__shape"));
    std::vector<SbtRecord<CallableData>> callableRecords = makeCallables(program);
    DeviceBuffer raygen, miss, hit, callables;
    raygen.upload(&raygenRecord, sizeof(raygenRecord));
    miss.upload(missRecords);
    hit.upload(&hitRecord, sizeof(hitRecord));
    callables.upload(callableRecords);
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = raygen.address();
    sbt.missRecordBase = miss.address();
    sbt.missRecordStrideInBytes = sizeof(missRecords[0]);
    sbt.missRecordCount = unsigned(missRecords.size());
    sbt.hitgroupRecordBase = hit.address();
    sbt.hitgroupRecordStrideInBytes = sizeof(hitRecord);
    sbt.hitgroupRecordCount = 1;
    sbt.callablesRecordBase = callables.address();
    sbt.callablesRecordStrideInBytes = sizeof(callableRecords[0]);
    sbt.callablesRecordCount = unsigned(callableRecords.size());
    OptixPipeline pipeline = program.link(kMaxTraceDepth);

    DeviceBuffer image(picture.pixels() * sizeof(float4));
    DeviceBuffer shapes;
    shapes.upload(hostShapes);
    Params params = {};
    params.image = image.as<float4>();
    params.shapes = shapes.as<Shape>();
    params.camera = makeCamera(vec(0.6f, 4.4f, 8.6f), vec(0.0f, 0.45f, -0.6f),
                               vec(0.0f, 1.0f, 0.0f), 34.0f, picture.aspect());
    params.lightDirection = normalize(vec(-0.55f, 1.0f, 0.6f));
    params.scene = accel.handle;
    params.samplesPerAxis = samplesPerAxis;
    launch(pipeline, sbt, params, picture);
    writePicture(picture, image);
}

} // namespace

int main(int argc, char** argv) {
    Picture picture = {"callables.png", 960, 540};
    unsigned samplesPerAxis = 3;
    Arguments arguments("Ray traces spheres whose patterns and materials are callable programs.");
    addPictureOptions(arguments, picture);
    arguments.add("--samples-per-axis", samplesPerAxis, 1, 16, "rays for a pixel, square root");
    return runSample("callables", arguments, argc, argv,
                     [&](OptixDeviceContext context) { render(context, picture, samplesPerAxis); });
}
