// SPDX-License-Identifier: Apache-2.0
// Curves, spheres and opacity micromaps, with and without motion.
#include "lab.h"

#include <cmath>

std::string_view differential_curves_ptx();  // programs.cu with its programs for curves
std::string_view differential_spheres_ptx(); // and for spheres

namespace differential {
namespace {

struct CurveKind {
    OptixPrimitiveType type;
    unsigned points; // of a segment
    const char* closestHit;
};
constexpr CurveKind kLinear = {OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, 2, "__closesthit__linear"};
constexpr CurveKind kQuadratic = {OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE, 3,
                                  "__closesthit__quadratic"};
constexpr CurveKind kCubic = {OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE, 4, "__closesthit__cubic"};
constexpr CurveKind kCatmullRom = {OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM, 4,
                                   "__closesthit__catmull_rom"};

// Positions or sizes at two motion keys, or at one: the second key is the first one disturbed.
class Keys {
public:
    Keys(const std::vector<float>& first, bool moves, float speed, uint64_t seed) {
        buffers_[0].upload(first);
        addresses_[0] = buffers_[0].address();
        if (!moves)
            return;
        Random random(seed);
        std::vector<float> second = first;
        for (float& x : second)
            x += speed * random.unit();
        buffers_[1].upload(second);
        addresses_[1] = buffers_[1].address();
    }
    const CUdeviceptr* addresses() const { return addresses_; }

private:
    DeviceBuffer buffers_[2];
    CUdeviceptr addresses_[2] = {};
};

OptixMotionOptions motionOf(bool moves) {
    OptixMotionOptions motion = {};
    if (moves)
        motion = {2, OPTIX_MOTION_FLAG_NONE, 0.0f, 1.0f};
    return motion;
}

// With motion, the rays' times go from before the first key to after the last.
std::vector<TestRay> raysFor(bool moves, uint64_t seed) {
    std::vector<TestRay> rays = randomRays(600, 3, seed);
    Random random(seed + 1);
    for (size_t i = 0; moves && i < rays.size(); ++i)
        rays[i].time = i % 5 == 0 ? float(i / 5 % 3) * 0.5f : -0.2f + 1.4f * random.unit();
    return rays;
}

void curves(const Lab& lab, Answer& answer, const CurveKind& kind, bool moves) {
    Random random(101);
    std::vector<float> points, widths;
    std::vector<unsigned> first;
    for (unsigned strand = 0; strand < 40; ++strand) {
        float p[3] = {random.symmetric(), random.symmetric(), random.symmetric()};
        float step[3] = {random.symmetric(), random.symmetric(), random.symmetric()};
        for (unsigned i = 0; i < 9; ++i) {
            if (i + kind.points <= 9)
                first.push_back(unsigned(widths.size()));
            for (int k = 0; k < 3; ++k) {
                points.push_back(p[k]);
                step[k] += 0.5f * random.symmetric();
                p[k] += 0.2f * step[k];
            }
            widths.push_back(0.02f + 0.03f * random.unit());
        }
    }
    DeviceBuffer deviceFirst;
    deviceFirst.upload(first);
    const Keys devicePoints(points, moves, 0.4f, 108), deviceWidths(widths, moves, 0.03f, 109);
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
    OptixBuildInputCurveArray& c = input.curveArray;
    c.curveType = kind.type;
    c.numPrimitives = unsigned(first.size());
    c.vertexBuffers = devicePoints.addresses();
    c.numVertices = unsigned(widths.size());
    c.widthBuffers = deviceWidths.addresses();
    c.indexBuffer = deviceFirst.address();
    const Accel accel =
        buildAccel(lab.context(), input, motionOf(moves),
                                   OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    Pipeline pipeline;
    pipeline.ptx = differential_curves_ptx();
    pipeline.motion = moves;
    pipeline.primitiveTypes = 1u << (kind.type - OPTIX_PRIMITIVE_TYPE_CUSTOM);
    HitRecord hit;
    hit.closestHit = kind.closestHit;
    hit.builtin = kind.type;
    hit.data = {100, kAccept, nullptr};
    pipeline.hits = {hit};
    answer.seen = lab.trace(pipeline, raysFor(moves, 102), accel.handle);
}

void spheres(const Lab& lab, Answer& answer, bool moves) {
    Random random(103);
    std::vector<float> centers, radii;
    for (unsigned i = 0; i < 200; ++i) {
        for (int k = 0; k < 3; ++k)
            centers.push_back(random.symmetric());
        radii.push_back(0.05f + 0.15f * random.unit());
    }
    const Keys deviceCenters(centers, moves, 0.4f, 110), deviceRadii(radii, moves, 0.1f, 111);
    const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_SPHERES;
    OptixBuildInputSphereArray& s = input.sphereArray;
    s.vertexBuffers = deviceCenters.addresses();
    s.numVertices = unsigned(radii.size());
    s.radiusBuffers = deviceRadii.addresses();
    s.flags = &flags;
    s.numSbtRecords = 1;
    const Accel accel =
        buildAccel(lab.context(), input, motionOf(moves),
                                   OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    Pipeline pipeline;
    pipeline.ptx = differential_spheres_ptx();
    pipeline.motion = moves;
    pipeline.primitiveTypes = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE);
    HitRecord hit;
    hit.closestHit = "__closesthit__sphere";
    hit.builtin = OPTIX_PRIMITIVE_TYPE_SPHERE;
    hit.data = {100, kAccept, nullptr};
    pipeline.hits = {hit};
    answer.seen = lab.trace(pipeline, raysFor(moves, 104), accel.handle);
}

// Micromaps of four states at level 3: transparent, opaque, and left to the any-hit program.
DeviceBuffer buildMicromaps(const Lab& lab, unsigned count) {
    constexpr unsigned kLevel = 3, kBytes = 16; // 64 states of two bits
    Random random(105);
    std::vector<unsigned char> states;
    std::vector<OptixOpacityMicromapDesc> descriptions;
    for (unsigned i = 0; i < count; ++i) {
        descriptions.push_back({unsigned(states.size()), (unsigned short)kLevel,
                                OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE});
        for (unsigned b = 0; b < kBytes; ++b)
            states.push_back((unsigned char)(random.next()));
    }
    DeviceBuffer deviceStates, deviceDescriptions;
    deviceStates.upload(states);
    deviceDescriptions.upload(descriptions);
    const OptixOpacityMicromapHistogramEntry histogram = {count, kLevel,
                                                          OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE};
    OptixOpacityMicromapArrayBuildInput input = {};
    input.inputBuffer = deviceStates.address();
    input.perMicromapDescBuffer = deviceDescriptions.address();
    input.numMicromapHistogramEntries = 1;
    input.micromapHistogramEntries = &histogram;
    OptixMicromapBufferSizes sizes = {};
    OPTIX_CHECK(optixOpacityMicromapArrayComputeMemoryUsage(lab.context(), &input, &sizes));
    DeviceBuffer array(sizes.outputSizeInBytes), temporary(sizes.tempSizeInBytes);
    const OptixMicromapBuffers buffers = {array.address(), array.size(), temporary.address(),
                                          temporary.size()};
    OPTIX_CHECK(optixOpacityMicromapArrayBuild(lab.context(), nullptr, &input, &buffers));
    CUDA_CHECK(cudaDeviceSynchronize());
    return array;
}

void micromaps(const Lab& lab, Answer& answer, bool moves) {
    constexpr unsigned kTriangles = 100, kMaps = 10;
    const DeviceBuffer array = buildMicromaps(lab, kMaps);
    const Mesh mesh = randomTriangles(kTriangles, 0.7f, 106);
    std::vector<short> mapOf;
    for (unsigned i = 0; i < kTriangles; ++i)
        mapOf.push_back(short(i % kMaps));
    DeviceBuffer indices, maps;
    const Keys vertices(mesh.vertices, moves, 0.3f, 112);
    indices.upload(mesh.indices);
    maps.upload(mapOf);
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& t = input.triangleArray;
    t.vertexBuffers = vertices.addresses();
    t.numVertices = 3 * kTriangles;
    t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    t.indexBuffer = indices.address();
    t.numIndexTriplets = kTriangles;
    t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    t.flags = mesh.flags.data();
    t.numSbtRecords = 1;
    const OptixOpacityMicromapUsageCount usage = {kTriangles, 3,
                                                  OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE};
    t.opacityMicromap.indexingMode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED;
    t.opacityMicromap.opacityMicromapArray = array.address();
    t.opacityMicromap.indexBuffer = maps.address();
    t.opacityMicromap.indexSizeInBytes = sizeof(short);
    t.opacityMicromap.numMicromapUsageCounts = 1;
    t.opacityMicromap.micromapUsageCounts = &usage;
    const Accel accel =
        buildAccel(lab.context(), input, motionOf(moves),
                                   OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    Pipeline pipeline;
    pipeline.micromaps = true;
    pipeline.motion = moves;
    HitRecord hit;
    hit.anyHit = "__anyhit__rule";
    hit.data = {100, kIgnoreOdd, nullptr};
    pipeline.hits = {hit};
    std::vector<TestRay> rays = raysFor(moves, 107);
    for (size_t i = 0; i < rays.size(); ++i)
        rays[i].flags = i % 3 == 0   ? OPTIX_RAY_FLAG_FORCE_OPACITY_MICROMAP_2_STATE
                        : i % 3 == 1 ? OPTIX_RAY_FLAG_DISABLE_ANYHIT
                                     : OPTIX_RAY_FLAG_NONE;
    answer.seen = lab.trace(pipeline, rays, accel.handle);
}

} // namespace

std::vector<Case> shapeCases() {
    const auto of = [](const CurveKind& kind, bool moves = false) {
        return [=](const Lab& lab, Answer& answer) { curves(lab, answer, kind, moves); };
    };
    const auto with = [](auto run, bool moves) {
        return [=](const Lab& lab, Answer& answer) { run(lab, answer, moves); };
    };
    return {{"curves.linear", of(kLinear)},
            {"curves.quadratic", of(kQuadratic)},
            {"curves.cubic", of(kCubic)},
            {"curves.catmull_rom", of(kCatmullRom)},
            {"spheres", with(spheres, false)},
            {"micromaps", with(micromaps, false)},
            {"motion.curves_linear", of(kLinear, true)},
            {"motion.curves_cubic", of(kCubic, true)},
            {"motion.spheres", with(spheres, true)},
            {"motion.micromaps", with(micromaps, true)}};
}

} // namespace differential
