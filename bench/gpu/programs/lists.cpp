// SPDX-License-Identifier: Apache-2.0
// Custom primitives and any-hit lists: smoke in bricks, photons around hits, the nearest hits of a
// ray.
#include "scene.h"

#include "sampling.h"

#include <cmath>

std::string_view bench_volume_ptx();
std::string_view bench_lists_ptx();

namespace bench {
namespace {

constexpr unsigned kSide = 8; // densities across a brick

// Bricks of a cube with visible smoke: those near waves.
std::vector<Item> bricksOf(unsigned across, std::vector<float>& grid) {
    std::vector<Item> bricks;
    const float size = 2.0f / float(across);
    const auto density = [](float3 p) {
        const float wave = sinf(5 * p.x + 3 * p.y) + sinf(4 * p.z - 6 * p.y) + sinf(7 * p.x * p.z);
        return std::max(0.0f, wave - 0.6f - dot(p, p) * 0.4f);
    };
    for (unsigned i = 0; i < across * across * across; ++i) {
        const float3 at = vec(-1 + size * (float(i % across) + 0.5f),
                              -1 + size * (float(i / across % across) + 0.5f),
                              -1 + size * (float(i / across / across) + 0.5f));
        if (density(at) == 0.0f)
            continue;
        bricks.push_back({at, 0.5f * size});
        for (unsigned k = 0; k < kSide * kSide * kSide; ++k) {
            const auto along = [&](unsigned n) { return (float(n) / (kSide - 1) - 0.5f) * size; };
            grid.push_back(density(
                at + vec(along(k % kSide), along(k / kSide % kSide), along(k / kSide / kSide))));
        }
    }
    return bricks;
}

Job volume(OptixDeviceContext context, const JobSettings& settings) {
    Job job;
    job.ptx = bench_volume_ptx();
    job.primitives = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
    job.attributeValues = 2;
    job.raygen = "__raygen__smoke";
    job.misses = {"__miss__end"};
    job.hits = {{"__closesthit__march", nullptr, "__intersection__brick"}};
    job.records = {{0, Look()}};
    std::vector<float> grid;
    const auto across = unsigned(std::cbrt(settings.some(48.0 * 48 * 48, 400)));
    const std::vector<Item> bricks = bricksOf(across, grid);
    job.params.items = job.upload(bricks);
    job.params.grid = job.upload(grid);
    job.params.scene = addItems(context, job, bricks, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
    job.params.camera =
        makeCamera(vec(-1.8f, 1.2f, -2.2f), vec(0.0f), vec(0, 1, 0), 50, settings.aspect());
    job.params.light[0] = normalize(vec(0.4f, 0.8f, 0.2f));
    job.params.epsilon = 1e-5f;
    job.params.reach = 8; // density to extinction
    job.params.samples = 2;
    job.params.depth = 64;
    job.allocatePicture(settings.width, settings.height);
    return job;
}

Job photons(OptixDeviceContext context, const JobSettings& settings) {
    Job job;
    job.ptx = bench_lists_ptx();
    job.payloadValues = 4;
    job.primitives =
        unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) | unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
    job.raygen = "__raygen__photons";
    job.misses = {"__miss__none", "__miss__list"};
    job.hits = {{"__closesthit__surface"}, {nullptr, "__anyhit__photon", "__intersection__photon"}};
    const Mesh mesh = makeScene(SceneKind::kTerrain, settings.some(5e5, 500));
    const Triangles uploaded = uploadTriangles(job, mesh);
    job.params.scene = addMesh(context, job, uploaded);
    job.records = {{0, materialOf(uploaded, vec(0.5f))}, {1, Look()}};
    lightOutside(job, mesh, settings);
    // Photons on triangles.
    const unsigned count = settings.some(1e6, 500);
    const float radius = mesh.aoRadius * 2.0f / std::sqrt(float(count) / 1000.0f);
    std::vector<Item> items(count);
    for (unsigned i = 0; i < count; ++i) {
        const auto t = size_t(randomOf(i, 0) * float(mesh.numTriangles()));
        const float u = randomOf(i, 1), v = randomOf(i, 2) * (1 - u);
        const auto corner = [&](size_t k) {
            const float* p = &mesh.vertices[3 * size_t(mesh.indices[3 * t + k])];
            return vec(p[0], p[1], p[2]);
        };
        items[i] = {corner(0) * (1 - u - v) + corner(1) * u + corner(2) * v, radius};
    }
    job.params.items = job.upload(items);
    job.params.photons = addItems(context, job, items, OPTIX_GEOMETRY_FLAG_NONE);
    job.params.reach = 8 / (kPi * radius * radius);
    job.params.samples = 1;
    job.allocatePicture(settings.width, settings.height);
    return job;
}

Job multiHit(OptixDeviceContext context, const JobSettings& settings) {
    Job job;
    job.ptx = bench_lists_ptx();
    job.payloadValues = 4;
    job.raygen = "__raygen__layers";
    job.misses = {"__miss__none", "__miss__list"};
    job.hits = {{nullptr, "__anyhit__keep"}};
    const Mesh mesh = makeLeaves(settings.some(2e5, 400));
    const Triangles uploaded = uploadTriangles(job, mesh);
    job.params.scene =
        addMesh(context, job, uploaded, OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL);
    job.records = {{0, materialOf(uploaded, vec(0.5f))}};
    lightOutside(job, mesh, settings);
    job.params.samples = 2;
    job.allocatePicture(settings.width, settings.height);
    return job;
}

} // namespace

std::vector<JobKind> listJobs() {
    return {
        {"volume", "marching through bricks of smoke", volume, 0.002, 0.02},
        {"photons", "any-hit lists of the eight nearest of a million photons", photons, 0.002,
         0.02},
        {"multi_hit", "the eight nearest hits of a ray", multiHit, 0.002, 0.02},
    };
}

} // namespace bench
