// SPDX-License-Identifier: Apache-2.0
// Programs of few rays a pixel over a terrain, and over instances of rocks: G-buffer, ambient
// occlusion, direct light, launches of all sizes.
#include "scene.h"

#include <algorithm>
#include <cstring>

std::string_view bench_surfaces_ptx();
std::string_view bench_instances_ptx();

namespace bench {
namespace {

Job terrain(OptixDeviceContext context, const JobSettings& settings, const char* raygen,
            double triangles = 1e6) {
    Job job;
    job.ptx = bench_surfaces_ptx();
    job.payloadValues = 7;
    job.raygen = raygen;
    job.misses = {"__miss__sky", "__miss__free"};
    job.hits = {{"__closesthit__surface"}};
    const Mesh mesh = makeScene(SceneKind::kTerrain, settings.some(triangles, 500));
    const Triangles uploaded = uploadTriangles(job, mesh);
    job.params.scene = addMesh(context, job, uploaded);
    job.records = {{0, materialOf(uploaded, vec(0.55f, 0.5f, 0.4f))}};
    lightOutside(job, mesh, settings);
    job.params.samples = 1;
    job.allocatePicture(settings.width, settings.height);
    return job;
}

Job gbuffer(OptixDeviceContext context, const JobSettings& settings) {
    return terrain(context, settings, "__raygen__gbuffer");
}
Job occlusion(OptixDeviceContext context, const JobSettings& settings) {
    Job job = terrain(context, settings, "__raygen__occlusion");
    job.params.samples = 64;
    return job;
}
Job smallLaunch(OptixDeviceContext context, const JobSettings& settings) {
    Job job = terrain(context, settings, "__raygen__direct");
    const unsigned side = std::min(256u, settings.width);
    job.allocatePicture(side, side);
    return job;
}

// 32,768 squared launch indices in full size.
Job hugeLaunch(OptixDeviceContext context, const JobSettings& settings) {
    Job job = terrain(context, settings, "__raygen__sparse", 1e4);
    unsigned side = 512;
    while (side > settings.width)
        side /= 2;
    job.allocatePicture(side, side);
    job.launchWidth = job.launchHeight = std::max(side, settings.some(32768, side) / side * side);
    return job;
}

Job manyLaunches(OptixDeviceContext context, const JobSettings& settings) {
    Job job = terrain(context, settings, "__raygen__tile", 1e5);
    constexpr unsigned kTile = 64, kAcross = 16;
    const unsigned across = std::min(kAcross, settings.some(kAcross * 100.0, 2));
    job.allocatePicture(kTile * across, kTile * across);
    job.launchWidth = job.launchHeight = kTile;
    job.launches = settings.some(10000, across * across);
    job.tiles = across * across; // rendered again and again
    return job;
}

Job instances(OptixDeviceContext context, const JobSettings& settings) {
    Job job;
    job.ptx = bench_instances_ptx();
    job.payloadValues = 7;
    job.graph = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
    job.graphDepth = 2;
    job.raygen = "__raygen__direct";
    job.misses = {"__miss__sky", "__miss__free"};
    job.hits = {{"__closesthit__surface"}};
    const Mesh rock = makeRock(settings.some(4000, 200));
    const Triangles uploaded = uploadTriangles(job, rock);
    const OptixTraversableHandle child = addMesh(context, job, uploaded);
    const std::vector<float> matrices = scatter(settings.some(1e5, 50));
    std::vector<OptixInstance> records(matrices.size() / 12);
    for (size_t i = 0; i < records.size(); ++i) {
        std::memcpy(records[i].transform, &matrices[12 * i], sizeof(records[i].transform));
        records[i].instanceId = unsigned(i);
        records[i].visibilityMask = 255;
        records[i].traversableHandle = child;
    }
    job.structures.push_back(buildInstances(context, records));
    job.params.scene = job.structures.back().handle;
    job.records = {{0, materialOf(uploaded, vec(0.5f))}};
    lightOutside(job, rock, settings);
    job.params.samples = 2;
    job.allocatePicture(settings.width, settings.height);
    return job;
}
Job instancesAny(OptixDeviceContext context, const JobSettings& settings) {
    Job job = instances(context, settings);
    job.graph = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
    return job;
}

} // namespace

std::vector<JobKind> surfaceJobs() {
    return {
        {"gbuffer", "one ray a pixel, two layers", gbuffer, 0.001, 0.01},
        {"occlusion_64", "ambient occlusion, 64 rays a pixel", occlusion, 0.001, 0.01},
        {"launch_256", "a launch of 256 x 256, direct light", smallLaunch, 0.001, 0.01},
        {"launch_huge", "a launch of 2^30 indices", hugeLaunch, 0.001, 0.01},
        {"launches_10000", "10,000 launches of 64 x 64", manyLaunches, 0.001, 0.01},
        {"instances", "direct light, 100,000 instances", instances, 0.001, 0.01},
        {"instances_any", "the same, compiled for graphs of any depth", instancesAny, 0.001, 0.01},
    };
}

} // namespace bench
