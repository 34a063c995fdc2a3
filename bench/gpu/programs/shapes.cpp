// SPDX-License-Identifier: Apache-2.0
// Hair of two million curve segments, and particles of spheres.
#include "scene.h"

#include "sampling.h"

#include <cmath>

std::string_view bench_shapes_ptx();

namespace bench {
namespace {

Job shapes(const JobSettings& settings, const char* closestHit, OptixPrimitiveType type) {
    Job job;
    job.ptx = bench_shapes_ptx();
    job.traceDepth = 2;
    job.attributeValues = 2;
    job.raygen = "__raygen__camera";
    job.misses = {"__miss__sky", "__miss__sun"};
    job.hits = {{closestHit, nullptr, nullptr, unsigned(type)}};
    job.records = {{0, Look()}};
    job.params.samples = 2;
    job.allocatePicture(settings.width, settings.height);
    return job;
}

constexpr unsigned kPoints = 10; // of a strand

// Strands on a ball that curl and hang.
void addHair(OptixDeviceContext context, Job& job, OptixPrimitiveType type, unsigned degree,
             unsigned segments) {
    const unsigned each = kPoints - degree, strands = segments / each + 1;
    std::vector<float3> points;
    std::vector<float> radii;
    std::vector<unsigned> firsts;
    for (unsigned s = 0; s < strands; ++s) {
        const float height = 2 * randomOf(s, 0) - 1, level = sqrtf(1 - height * height);
        const float2 around = circlePoint(randomOf(s, 1));
        const float3 out = vec(level * around.x, height, level * around.y);
        float3 x, y;
        makeBasis(out, x, y);
        for (unsigned i = 0; i < kPoints; ++i) {
            const float along = float(i) / (kPoints - 1), turns = randomOf(s, 2) + 0.23f * float(i);
            const float2 curl = circlePoint(turns - floorf(turns));
            float3 p = out * (0.6f + 0.4f * along) + (x * curl.x + y * curl.y) * (0.04f * along);
            p.y -= 0.15f * along * along;
            points.push_back(p);
            radii.push_back(0.0012f - 0.0009f * along);
            if (i < each)
                firsts.push_back(s * kPoints + i);
        }
    }
    DeviceBuffer pointMemory, radiusMemory, firstMemory;
    pointMemory.upload(points);
    radiusMemory.upload(radii);
    firstMemory.upload(firsts);
    const CUdeviceptr pointAddress = pointMemory.address(), radiusAddress = radiusMemory.address();
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
    OptixBuildInputCurveArray& c = input.curveArray;
    c.curveType = type;
    c.numPrimitives = unsigned(firsts.size());
    c.vertexBuffers = &pointAddress;
    c.numVertices = unsigned(points.size());
    c.vertexStrideInBytes = sizeof(float3);
    c.widthBuffers = &radiusAddress;
    c.widthStrideInBytes = sizeof(float);
    c.indexBuffer = firstMemory.address();
    c.indexStrideInBytes = sizeof(unsigned);
    c.flag = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    job.structures.push_back(
        buildAccel(context, input, {}, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS));
    job.params.scene = job.structures.back().handle;
}

Job hair(OptixDeviceContext context, const JobSettings& settings, OptixPrimitiveType type,
         unsigned primitives, unsigned degree) {
    Job job = shapes(settings, "__closesthit__hair", type);
    job.primitives = primitives;
    addHair(context, job, type, degree, settings.some(2e6, 500));
    Mesh view;
    view.aoRadius = 0.02f;
    view.fovDegrees = 45;
    const float eye[3] = {-1.2f, 0.8f, -2.4f}, target[3] = {0, 0, 0};
    std::copy(eye, eye + 3, view.eye);
    std::copy(target, target + 3, view.target);
    lightOutside(job, view, settings);
    job.params.epsilon = 1e-3f;
    return job;
}
Job cubicHair(OptixDeviceContext context, const JobSettings& settings) {
    return hair(context, settings, OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE,
                OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CUBIC_BSPLINE, 3);
}
Job linearHair(OptixDeviceContext context, const JobSettings& settings) {
    return hair(context, settings, OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR,
                OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR, 1);
}

Job spheres(OptixDeviceContext context, const JobSettings& settings) {
    Job job = shapes(settings, "__closesthit__sphere", OPTIX_PRIMITIVE_TYPE_SPHERE);
    job.primitives = OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE;
    Mesh view;
    const std::vector<float> balls = makeBalls(settings.some(1e6, 300), view);
    const float* const memory = job.upload(balls);
    const auto centres = reinterpret_cast<CUdeviceptr>(memory), radii = centres + sizeof(float3);
    const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_SPHERES;
    OptixBuildInputSphereArray& s = input.sphereArray;
    s.vertexBuffers = &centres;
    s.vertexStrideInBytes = sizeof(Item);
    s.numVertices = unsigned(balls.size() / 4);
    s.radiusBuffers = &radii;
    s.radiusStrideInBytes = sizeof(Item);
    s.flags = &flags;
    s.numSbtRecords = 1;
    job.structures.push_back(buildAccel(context, input));
    job.params.scene = job.structures.back().handle;
    job.params.items = reinterpret_cast<const Item*>(memory);
    lightOutside(job, view, settings);
    return job;
}

} // namespace

std::vector<JobKind> shapeJobs() {
    return {
        {"hair_cubic", "two million segments of cubic B-splines", cubicHair, 0.002, 0.02},
        {"hair_linear", "two million linear segments", linearHair, 0.002, 0.02},
        {"spheres", "a million particles", spheres, 0.002, 0.02},
    };
}

} // namespace bench
