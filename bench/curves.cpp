// SPDX-License-Identifier: Apache-2.0
// Round curves: a ball of hair built by optixAccelBuild and rays through optixLaunch, against
// Embree's round curves on the same control points and rays, in one process, all threads on both
// sides. Quadratic B-splines are left out: Embree has none.
//   bench_curves [--quick] [--fast-trace] [--motion] [--strands N]
// Runs alternate between the two; the best of several counts, by the clock and by processor time of
// all threads (for machines that are not idle).
#include "embree_rays.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace bench;

struct Options {
    bool quick = false, fastTrace = false, motion = false;
    uint32_t strands = 25000;
};

struct Basis {
    const char* name;
    OptixPrimitiveType type;
    RTCGeometryType peer;
    unsigned degree;
};
constexpr Basis kBases[] = {
    {"linear", OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE, 1},
    {"cubic B-spline", OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE,
     RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE, 3},
    {"Catmull-Rom", OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM,
     RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE, 3},
};

constexpr unsigned kStrandPoints = 11;

struct Hair {
    std::vector<float> points;   // x, y, z, radius
    std::vector<float> later;    // the same at the end of the motion
    std::vector<uint32_t> first; // first point of each segment
};

// Curly strands from a ball of radius 0.5 to a distance of about 1.2, with radii from 0.003 to
// 0.001.
Hair makeHair(uint32_t strands, unsigned degree) {
    Hair hair;
    uint32_t state = 1;
    const auto random = [&state] {
        state = state * 747796405u + 2891336453u;
        const uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
        return float(((word >> 22u) ^ word) >> 8) * 0x1p-24f;
    };
    for (uint32_t strand = 0; strand < strands; ++strand) {
        const float height = 2 * random() - 1, turn = 6.2831853f * random();
        const float level = std::sqrt(1 - height * height);
        const float out[3] = {level * std::cos(turn), height, level * std::sin(turn)};
        const float x[3] = {-std::sin(turn), 0, std::cos(turn)}; // across `out`
        const float y[3] = {-height * std::cos(turn), level, -height * std::sin(turn)};
        const float phase = 6.2831853f * random(), size = 0.5f + 0.2f * random();
        for (unsigned i = 0; i < kStrandPoints; ++i) {
            const float along = float(i) / (kStrandPoints - 1), angle = phase + 1.2f * float(i);
            const float curl = 0.01f + 0.04f * along;
            for (int k = 0; k < 3; ++k)
                hair.points.push_back(out[k] * (0.5f + size * along) +
                                      curl * (x[k] * std::cos(angle) + y[k] * std::sin(angle)));
            hair.points.push_back(0.003f - 0.002f * along);
            if (i + degree < kStrandPoints)
                hair.first.push_back(strand * kStrandPoints + i);
        }
    }
    return hair;
}

// Moves points by wind that grows with the distance from the ball.
void blow(Hair& hair) {
    hair.later = hair.points;
    for (size_t i = 0; i < hair.later.size(); i += 4) {
        float* const p = &hair.later[i];
        const float far = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 0.5f;
        p[0] += 0.1f * far;
        p[1] += 0.05f * far * std::sin(8 * p[2]);
    }
}

// The curves on the device and their acceleration structure.
class Curves {
public:
    Curves(Optix& optix, const Hair& hair, OptixPrimitiveType type, bool fastTrace)
        : optix_(optix), points_(hair.points), later_(hair.later), first_(hair.first), temp_(16),
          output_(16) {
        pointAddress_[0] = points_.address();
        pointAddress_[1] = later_.address();
        for (int key = 0; key < 2; ++key)
            radiusAddress_[key] = pointAddress_[key] + 3 * sizeof(float);
        input_.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
        OptixBuildInputCurveArray& c = input_.curveArray;
        c.curveType = type;
        c.numPrimitives = unsigned(hair.first.size());
        c.vertexBuffers = pointAddress_;
        c.numVertices = unsigned(hair.points.size() / 4);
        c.widthBuffers = radiusAddress_;
        c.vertexStrideInBytes = c.widthStrideInBytes = 4 * sizeof(float);
        c.indexBuffer = first_.address();
        options_.operation = OPTIX_BUILD_OPERATION_BUILD;
        if (!hair.later.empty())
            options_.motionOptions = {2, OPTIX_MOTION_FLAG_NONE, 0, 1};
        if (fastTrace)
            options_.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
        CHECK(optixAccelComputeMemoryUsage(optix.context, &options_, &input_, 1, &sizes_));
        temp_ = Buffer(sizes_.tempSizeInBytes);
        output_ = Buffer(sizes_.outputSizeInBytes);
    }
    Curves(const Curves&) = delete; // the input points into it

    void build() {
        CHECK(optixAccelBuild(optix_.context, nullptr, &options_, &input_, 1, temp_.address(),
                              sizes_.tempSizeInBytes, output_.address(), sizes_.outputSizeInBytes,
                              &handle, nullptr, 0));
        CHECK(cudaDeviceSynchronize());
    }

    OptixTraversableHandle handle = 0;

private:
    Optix& optix_;
    Buffer points_, later_, first_, temp_, output_;
    CUdeviceptr pointAddress_[2], radiusAddress_[2]; // at each motion key
    OptixBuildInput input_ = {};
    OptixAccelBuildOptions options_ = {};
    OptixAccelBufferSizes sizes_ = {};
};

RTCScene embreeCurves(RTCDevice device, const Hair& hair, RTCGeometryType type) {
    RTCScene scene = rtcNewScene(device);
    RTCGeometry curves = rtcNewGeometry(device, type);
    rtcSetSharedGeometryBuffer(curves, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                               hair.points.data(), 0, 16, hair.points.size() / 4);
    if (!hair.later.empty()) {
        rtcSetGeometryTimeStepCount(curves, 2);
        rtcSetSharedGeometryBuffer(curves, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT4,
                                   hair.later.data(), 0, 16, hair.later.size() / 4);
    }
    rtcSetSharedGeometryBuffer(curves, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT,
                               hair.first.data(), 0, 4, hair.first.size());
    rtcCommitGeometry(curves);
    rtcAttachGeometry(scene, curves);
    rtcReleaseGeometry(curves);
    return scene;
}

// The best of several runs of a kind of work, by two measures.
struct Best {
    double clock = 1e30, processors = 1e30;
    void run(const std::function<void()>& work) {
        clock = std::min(clock, seconds([&] {
                             processors = std::min(processors, processSeconds(work));
                         }));
    }
};

void printRow(const char* what, const Best& ours, const Best& theirs, const std::string& rest) {
    std::printf("| %s | %.1f ms | %.1f | %.2f | %.2f | %s |\n", what, 1e3 * ours.processors,
                1e3 * theirs.processors, theirs.processors / ours.processors,
                theirs.clock / ours.clock, rest.c_str());
    std::fflush(stdout);
}

std::vector<Surfel> surfels(RTCScene scene, const std::vector<Ray>& rays) {
    std::vector<Surfel> points(rays.size());
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < rays.size(); ++i) {
        RTCRayHit hit;
        hit.ray = embreeRay(rays[i]);
        hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &hit);
        points[i] = {hit.hit.geomID != RTC_INVALID_GEOMETRY_ID,
                     hit.ray.tfar,
                     {hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z}};
    }
    return points;
}

// Percentage of rays whose hits differ in existence or clearly in place.
double differences(Optix::Kind kind, const std::vector<BenchHit>& ours,
                   const std::vector<BenchHit>& theirs) {
    size_t count = 0;
    for (size_t i = 0; i < ours.size(); ++i) {
        const BenchHit &a = ours[i], &b = theirs[i];
        count += kind == Optix::kAny ? a.primitive != b.primitive
                                     : (a.primitive == ~0u) != (b.primitive == ~0u) ||
                                           std::fabs(a.t - b.t) > 1e-3f * std::fabs(b.t) + 1e-4f;
    }
    return 100 * double(count) / double(ours.size());
}

void benchRays(Optix& optix, OptixTraversableHandle handle, RTCScene peer, Optix::Kind kind,
               const std::vector<Ray>& rays, const char* what, const Options& options) {
    Buffer deviceRays(rays), deviceHits(rays.size() * sizeof(BenchHit));
    std::vector<BenchHit> peerHits(rays.size());
    optix.prepare(deviceRays, deviceHits, handle);
    Best ours, theirs;
    for (int i = 0; i < (options.quick ? 3 : 7); ++i) {
        ours.run([&] { optix.launch(kind, rays.size()); });
        theirs.run([&] { traceEmbree(peer, kind, rays, peerHits, options.motion); });
    }
    char rest[32];
    std::snprintf(rest, sizeof rest, "%.4f%%",
                  differences(kind, deviceHits.read<BenchHit>(rays.size()), peerHits));
    printRow(what, ours, theirs, rest);
}

void benchBasis(RTCDevice device, const Basis& basis, const Options& options) {
    Hair hair = makeHair(options.strands, basis.degree);
    if (options.motion)
        blow(hair);
    Optix optix(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS, basis.type, BENCH_PTX,
                options.motion);
    Curves curves(optix, hair, basis.type, options.fastTrace);
    std::printf("\n%s: %zu segments\n\n| rays | Sunstone | Embree | ratio by processor time | by "
                "the clock | hits that differ |\n|---|---|---|---|---|---|\n",
                basis.name, hair.first.size());
    Best ours, theirs;
    RTCScene peer = nullptr;
    for (int i = 0; i < (options.quick ? 2 : 4); ++i) {
        ours.run([&] { curves.build(); });
        if (peer)
            rtcReleaseScene(peer);
        peer = embreeCurves(device, hair, basis.peer);
        theirs.run([&] { rtcCommitScene(peer); });
    }
    printRow("build", ours, theirs, "");

    Mesh camera;
    const float eye[3] = {1, 0.8f, -2.6f};
    std::copy(eye, eye + 3, camera.eye);
    std::fill(camera.target, camera.target + 3, 0.0f);
    const std::vector<Ray> primary =
        primaryRays(camera, options.quick ? 640 : 1280, options.quick ? 360 : 720);
    const std::vector<Surfel> points = surfels(peer, primary);
    const auto bench = [&](Optix::Kind kind, const std::vector<Ray>& rays, const char* what) {
        benchRays(optix, curves.handle, peer, kind, rays, what, options);
    };
    const auto secondary = [&](RayKind kind) {
        std::vector<Ray> rays = secondaryRays(primary, points, 0.5f, kind);
        // Some rays would point into the hair at which they start; they start beyond it, because
        // OptiX does not hit curves from within and Embree may.
        if (kind == RayKind::kShadow)
            for (Ray& ray : rays)
                ray.tmin = 0.01f;
        return rays;
    };
    bench(Optix::kClosest, primary, "primary");
    bench(Optix::kAny, secondary(RayKind::kShadow), "shadow");
    bench(Optix::kAny, secondary(RayKind::kAmbientOcclusion), "AO");
    bench(Optix::kClosest, secondary(RayKind::kDiffuse), "diffuse");
    rtcReleaseScene(peer);
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--quick") {
            options.quick = true;
        } else if (word == "--fast-trace") {
            options.fastTrace = true;
        } else if (word == "--motion") {
            options.motion = true;
        } else if (word == "--strands" && i + 1 < argc) {
            options.strands = uint32_t(std::max(1, std::atoi(argv[++i])));
        } else {
            std::fprintf(stderr, "usage: bench_curves [--quick] [--fast-trace] [--motion] "
                                 "[--strands N]\n");
            return word == "--help" ? 0 : 2;
        }
    }
    RTCDevice device = rtcNewDevice(nullptr);
    for (const Basis& basis : kBases)
        benchBasis(device, basis, options);
    rtcReleaseDevice(device);
}
