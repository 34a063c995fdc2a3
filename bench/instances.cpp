// SPDX-License-Identifier: Apache-2.0
// Many instances of one mesh: an instance acceleration structure built by optixAccelBuild and rays
// through optixLaunch, against Embree's instances on the same transforms and rays, in one process,
// all threads on both sides.
//   bench_instances [--quick] [--processors] [--fast-trace] [--instances N] [--triangles N]
// Runs alternate between the two; the best of several counts. --processors: compares processor time
// of all threads, for machines that are not idle.
#include "embree_rays.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace {

using namespace bench;

struct Options {
    bool quick = false, processors = false, fastTrace = false;
    uint32_t instances = 100000, triangles = 4000;
};

// The instances on the device and their acceleration structure.
class Instances {
public:
    Instances(Optix& optix, const std::vector<float>& matrices, OptixTraversableHandle child,
              bool fastTrace)
        : optix_(optix), records_(makeRecords(matrices, child)), temp_(16), output_(16) {
        input_.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
        input_.instanceArray.instances = records_.address();
        input_.instanceArray.numInstances = unsigned(matrices.size() / 12);
        options_.operation = OPTIX_BUILD_OPERATION_BUILD;
        if (fastTrace)
            options_.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
        CHECK(optixAccelComputeMemoryUsage(optix.context, &options_, &input_, 1, &sizes_));
        temp_ = Buffer(sizes_.tempSizeInBytes);
        output_ = Buffer(sizes_.outputSizeInBytes);
    }

    void build() {
        CHECK(optixAccelBuild(optix_.context, nullptr, &options_, &input_, 1, temp_.address(),
                              sizes_.tempSizeInBytes, output_.address(), sizes_.outputSizeInBytes,
                              &handle, nullptr, 0));
        CHECK(cudaDeviceSynchronize());
    }

    OptixTraversableHandle handle = 0;

private:
    static std::vector<OptixInstance> makeRecords(const std::vector<float>& matrices,
                                                  OptixTraversableHandle child) {
        std::vector<OptixInstance> records(matrices.size() / 12);
        for (size_t i = 0; i < records.size(); ++i) {
            std::memcpy(records[i].transform, &matrices[12 * i], sizeof(records[i].transform));
            records[i].instanceId = unsigned(i);
            records[i].visibilityMask = 255;
            records[i].traversableHandle = child;
        }
        return records;
    }

    Optix& optix_;
    Buffer records_, temp_, output_;
    OptixBuildInput input_ = {};
    OptixAccelBuildOptions options_ = {};
    OptixAccelBufferSizes sizes_ = {};
};

RTCScene embreeInstances(RTCDevice device, RTCScene mesh, const std::vector<float>& matrices) {
    RTCScene scene = rtcNewScene(device);
    for (size_t i = 0; i < matrices.size() / 12; ++i) {
        RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, mesh);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, &matrices[12 * i]);
        rtcCommitGeometry(instance);
        rtcAttachGeometryByID(scene, instance, unsigned(i));
        rtcReleaseGeometry(instance);
    }
    return scene;
}

// The points where rays meet the scene. Scales are uniform, so normals transform like vectors.
std::vector<Surfel> surfels(RTCScene scene, const std::vector<float>& matrices,
                            const std::vector<Ray>& rays) {
    std::vector<Surfel> points(rays.size());
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < rays.size(); ++i) {
        RTCRayHit hit;
        hit.ray = embreeRay(rays[i]);
        hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &hit);
        points[i] = {hit.hit.geomID != RTC_INVALID_GEOMETRY_ID, hit.ray.tfar, {}};
        if (!points[i].hit)
            continue;
        const float* m = &matrices[12 * size_t(hit.hit.instID[0])];
        for (int k = 0; k < 3; ++k)
            points[i].normal[k] = m[4 * k] * hit.hit.Ng_x + m[4 * k + 1] * hit.hit.Ng_y +
                                  m[4 * k + 2] * hit.hit.Ng_z;
    }
    return points;
}

// The share of rays whose hits differ in existence or clearly in place.
double differences(Optix::Kind kind, const std::vector<BenchHit>& ours,
                   const std::vector<BenchHit>& theirs) {
    size_t count = 0;
    for (size_t i = 0; i < ours.size(); ++i) {
        const BenchHit &a = ours[i], &b = theirs[i];
        count += kind == Optix::kAny ? a.primitive != b.primitive
                                     : (a.primitive == ~0u) != (b.primitive == ~0u) ||
                                           std::fabs(a.t - b.t) > 1e-3f * std::fabs(b.t) + 1e-4f;
    }
    return double(count) / double(ours.size());
}

void benchRays(Optix& optix, OptixTraversableHandle handle, RTCScene peer, Optix::Kind kind,
               const std::vector<Ray>& rays, const char* what, const Options& options) {
    Buffer deviceRays(rays), deviceHits(rays.size() * sizeof(BenchHit));
    std::vector<BenchHit> theirs(rays.size());
    optix.prepare(deviceRays, deviceHits, handle);
    double ours = 1e30, embree = 1e30;
    const auto time = options.processors ? processSeconds : seconds;
    for (int i = 0; i < (options.quick ? 3 : 7); ++i) {
        ours = std::min(ours, time([&] { optix.launch(kind, rays.size()); }));
        embree = std::min(embree, time([&] { traceEmbree(peer, kind, rays, theirs); }));
    }
    const double scale = 1e-6 * double(rays.size());
    std::printf("| %s | %.2f Mrays/s | %.2f | %.2f | %.5f%% |\n", what, scale / ours,
                scale / embree, embree / ours,
                100 * differences(kind, deviceHits.read<BenchHit>(rays.size()), theirs));
    std::fflush(stdout);
}

void run(const Options& options) {
    const Mesh mesh = makeRock(options.triangles);
    const std::vector<float> matrices = scatter(options.instances);
    Optix optix(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING);
    Structure structure(optix, mesh);
    structure.build();
    RTCDevice device = rtcNewDevice(nullptr);
    RTCScene peerMesh = embreeScene(device, mesh);
    rtcCommitScene(peerMesh);

    Instances instances(optix, matrices, structure.handle, options.fastTrace);
    const auto time = options.processors ? processSeconds : seconds;
    RTCScene peer = nullptr;
    double ours = 1e30, embree = 1e30;
    for (int i = 0; i < (options.quick ? 2 : 4); ++i) {
        ours = std::min(ours, time([&] { instances.build(); }));
        if (peer)
            rtcReleaseScene(peer);
        peer = embreeInstances(device, peerMesh, matrices);
        embree = std::min(embree, time([&] { rtcCommitScene(peer); }));
    }
    std::printf("%u instances of %u triangles\n\n| rays | Sunstone | Embree | ratio | hits that "
                "differ |\n|---|---|---|---|---|\n| build | %.2f ms | %.2f | %.2f | |\n",
                options.instances, mesh.numTriangles(), ours * 1e3, embree * 1e3, embree / ours);

    const std::vector<Ray> primary =
        primaryRays(mesh, options.quick ? 640 : 1280, options.quick ? 360 : 720);
    const std::vector<Surfel> points = surfels(peer, matrices, primary);
    const auto bench = [&](Optix::Kind kind, const std::vector<Ray>& rays, const char* what) {
        benchRays(optix, instances.handle, peer, kind, rays, what, options);
    };
    const auto secondary = [&](RayKind kind) {
        return secondaryRays(primary, points, mesh.aoRadius, kind);
    };
    bench(Optix::kClosest, primary, "primary");
    bench(Optix::kAny, secondary(RayKind::kShadow), "shadow");
    bench(Optix::kAny, secondary(RayKind::kAmbientOcclusion), "AO");
    bench(Optix::kClosest, secondary(RayKind::kDiffuse), "diffuse");
    rtcReleaseScene(peer);
    rtcReleaseScene(peerMesh);
    rtcReleaseDevice(device);
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--quick") {
            options.quick = true;
        } else if (word == "--processors") {
            options.processors = true;
        } else if (word == "--fast-trace") {
            options.fastTrace = true;
        } else if (word == "--instances" && i + 1 < argc) {
            options.instances = uint32_t(std::max(1, std::atoi(argv[++i])));
        } else if (word == "--triangles" && i + 1 < argc) {
            options.triangles = uint32_t(std::max(16, std::atoi(argv[++i])));
        } else {
            std::fprintf(stderr,
                         "usage: bench_instances [--quick] [--processors] [--fast-trace] "
                         "[--instances N] [--triangles N]\n");
            return word == "--help" ? 0 : 2;
        }
    }
    run(options);
}
