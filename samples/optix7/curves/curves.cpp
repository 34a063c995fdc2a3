// SPDX-License-Identifier: Apache-2.0
// Hair of round curves in all four bases over the same control points, from left to right: linear
// segments, quadratic B-splines, cubic B-splines, Catmull-Rom splines. Linear segments show the
// polygon of the points; B-splines cut its corners; Catmull-Rom splines go through the points.
// Read instances first.
#include "picture.h"
#include "sampling.h"

#include <optix_function_table_definition.h>

#include <algorithm>

#include "params.h"

std::string_view curves_ptx(); // the PTX of curves.cu, built into this program

namespace {

struct BasisKind {
    OptixPrimitiveType type;
    unsigned degree;
    float3 color;
};
const BasisKind kBases[kBasisCount] = {
    {OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, 1, vec(0.9f, 0.62f, 0.25f)},
    {OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE, 2, vec(0.75f, 0.2f, 0.1f)},
    {OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE, 3, vec(0.2f, 0.5f, 0.45f)},
    {OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM, 3, vec(0.35f, 0.3f, 0.7f)},
};
constexpr unsigned kBasisFlags =
    OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR | OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_QUADRATIC_BSPLINE |
    OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CUBIC_BSPLINE | OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CATMULLROM;

unsigned segmentsOf(const BasisKind& basis) {
    return kStrandPoints - basis.degree;
}

struct Hair {
    std::vector<float3> points; // kStrandPoints for each strand
    std::vector<float> radii;   // OptiX calls them widths
};

float random01(unsigned seed, unsigned stream) {
    return float(hashPcg(seed * 8 + stream) >> 8) * 0x1p-24f;
}

// A ball of curly strands around the origin that hang a little.
Hair makeHair(unsigned strands) {
    Hair hair;
    for (unsigned strand = 0; strand < strands; ++strand) {
        const float height = 2 * random01(strand, 0) - 1;
        const float2 around = circlePoint(random01(strand, 1));
        const float level = sqrtf(1 - height * height);
        const float3 out = vec(level * around.x, height, level * around.y);
        float3 x, y;
        makeBasis(out, x, y);
        const float phase = random01(strand, 2), size = 0.5f + 0.25f * random01(strand, 3);
        for (unsigned i = 0; i < kStrandPoints; ++i) {
            const float along = float(i) / (kStrandPoints - 1);
            const float turns = phase + 0.31f * float(i);
            const float2 curl = circlePoint(turns - floorf(turns));
            float3 point =
                out * (0.3f + size * along) + (x * curl.x + y * curl.y) * (0.02f + 0.07f * along);
            point.y -= 0.22f * along * along;
            hair.points.push_back(point);
            hair.radii.push_back(0.012f - 0.009f * along);
        }
    }
    return hair;
}

Accel buildHair(OptixDeviceContext context, const Hair& hair, const BasisKind& basis) {
    // Segment k of a strand has the control points k to k + degree.
    std::vector<unsigned> firstPoints;
    for (unsigned begin = 0; begin < hair.points.size(); begin += kStrandPoints)
        for (unsigned segment = 0; segment < segmentsOf(basis); ++segment)
            firstPoints.push_back(begin + segment);
    DeviceBuffer points, radii, indices;
    points.upload(hair.points);
    radii.upload(hair.radii);
    indices.upload(firstPoints);
    CUdeviceptr pointAddress = points.address(), radiusAddress = radii.address();

    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
    OptixBuildInputCurveArray& curves = input.curveArray;
    curves.curveType = basis.type;
    curves.numPrimitives = unsigned(firstPoints.size());
    curves.vertexBuffers = &pointAddress;
    curves.numVertices = unsigned(hair.points.size());
    curves.vertexStrideInBytes = sizeof(float3);
    curves.widthBuffers = &radiusAddress;
    curves.widthStrideInBytes = sizeof(float);
    curves.indexBuffer = indices.address();
    curves.indexStrideInBytes = sizeof(unsigned);
    curves.flag = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    // The programs read control points from the structure.
    return buildAccel(context, input, {}, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
}

// The balls of hair, side by side.
struct Scene {
    std::vector<Accel> balls;
    Accel top;
};
Scene buildScene(OptixDeviceContext context, unsigned strands) {
    Scene scene;
    const Hair hair = makeHair(strands);
    std::vector<OptixInstance> instances(kBasisCount);
    for (unsigned i = 0; i < kBasisCount; ++i) {
        scene.balls.push_back(buildHair(context, hair, kBases[i]));
        const float x = 2.3f * (float(i) - 1.5f);
        const float transform[12] = {1, 0, 0, x, 0, 1, 0, 1.25f, 0, 0, 1, 0};
        std::copy(transform, transform + 12, instances[i].transform);
        instances[i].instanceId = i;
        instances[i].sbtOffset = i;
        instances[i].visibilityMask = 255;
        instances[i].traversableHandle = scene.balls[i].handle;
    }
    scene.top = buildInstances(context, instances);
    return scene;
}

void render(OptixDeviceContext context, const Picture& picture, unsigned samplesPerAxis,
            unsigned strands) {
    Scene scene = buildScene(context, strands);
    Program program(context, curves_ptx(), 3, 2, kBasisFlags, "params",
                    OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING);
    auto raygenRecord = makeRecord(program.addRaygen("__raygen__camera"));
    std::vector<SbtRecord<NoData>> missRecords = {makeRecord(program.addMiss("__miss__backdrop")),
                                                  makeRecord(program.addMiss("__miss__shadow"))};
    std::vector<SbtRecord<HairData>> hitRecords;
    for (const BasisKind& basis : kBases)
        hitRecords.push_back(
            makeRecord(program.addBuiltinHitgroup("__closesthit__hair", nullptr, basis.type),
                       HairData{basis.color, segmentsOf(basis)}));
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
    OptixPipeline pipeline = program.link(2, 2);

    DeviceBuffer image(picture.pixels() * sizeof(float4));
    Params params = {};
    params.image = image.as<float4>();
    params.camera = makeCamera(vec(0.0f, 2.6f, 12.0f), vec(0.0f, 1.1f, 0.0f), vec(0.0f, 1.0f, 0.0f),
                               14.5f, picture.aspect());
    params.lightDirection = normalize(vec(-0.5f, 1.0f, 0.7f));
    params.scene = scene.top.handle;
    params.samplesPerAxis = samplesPerAxis;
    launch(pipeline, sbt, params, picture);
    writePicture(picture, image);
}

} // namespace

int main(int argc, char** argv) {
    Picture picture = {"curves.png", 1200, 400};
    unsigned samplesPerAxis = 3, strands = 4000;
    Arguments arguments("Ray traces hair made of round curves in four bases.");
    addPictureOptions(arguments, picture);
    arguments.add("--samples-per-axis", samplesPerAxis, 1, 16, "rays for a pixel, square root");
    arguments.add("--strands", strands, 1, 1000000, "strands of hair for each basis");
    return runSample("curves", arguments, argc, argv, [&](OptixDeviceContext context) {
        render(context, picture, samplesPerAxis, strands);
    });
}
