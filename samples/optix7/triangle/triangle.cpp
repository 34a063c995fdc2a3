// SPDX-License-Identifier: Apache-2.0
// One triangle, coloured by its barycentric coordinates: the smallest program that traces rays.
// Read hello first; read next: spheres, mesh_path_tracer.
#include "picture.h"

#include <optix_function_table_definition.h>

#include "params.h"

std::string_view triangle_ptx(); // the PTX of triangle.cu, built into this program

namespace {

Accel buildTriangle(OptixDeviceContext context) {
    const std::vector<float3> corners = {vec(-1.0f, -0.75f, 0.0f), vec(1.0f, -0.75f, 0.0f),
                                         vec(0.0f, 0.95f, 0.0f)};
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

void render(OptixDeviceContext context, const Picture& picture) {
    Accel scene = buildTriangle(context);
    Program program(context, triangle_ptx(), 3, 2, OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);

    DeviceBuffer raygen, miss, hit;
    auto raygenRecord = makeRecord(program.addRaygen("__raygen__camera"));
    raygen.upload(&raygenRecord, sizeof(raygenRecord));
    auto missRecord =
        makeRecord(program.addMiss("__miss__background"), MissData{vec(0.05f, 0.06f, 0.1f)});
    miss.upload(&missRecord, sizeof(missRecord));
    TriangleData colors = {
        {vec(0.9f, 0.15f, 0.1f), vec(0.1f, 0.75f, 0.2f), vec(0.1f, 0.25f, 0.9f)}};
    auto hitRecord =
        makeRecord(program.addHitgroup("__closesthit__triangle", nullptr, nullptr), colors);
    hit.upload(&hitRecord, sizeof(hitRecord));
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = raygen.address();
    sbt.missRecordBase = miss.address();
    sbt.missRecordStrideInBytes = sizeof(missRecord);
    sbt.missRecordCount = 1;
    sbt.hitgroupRecordBase = hit.address();
    sbt.hitgroupRecordStrideInBytes = sizeof(hitRecord);
    sbt.hitgroupRecordCount = 1;
    OptixPipeline pipeline = program.link(1);

    DeviceBuffer image(picture.pixels() * sizeof(float4));
    Params params = {};
    params.image = image.as<float4>();
    params.scene = scene.handle;
    params.camera = makeCamera(vec(0.0f, 0.0f, 3.0f), vec(0.0f), vec(0.0f, 1.0f, 0.0f), 45.0f,
                               picture.aspect());
    launch(pipeline, sbt, params, picture);
    writePicture(picture, image);
}

} // namespace

int main(int argc, char** argv) {
    Picture picture = {"triangle.png", 512, 384};
    Arguments arguments("Traces one triangle and colours it by its barycentric coordinates.");
    addPictureOptions(arguments, picture);
    return runSample("triangle", arguments, argc, argv,
                     [&](OptixDeviceContext context) { render(context, picture); });
}
