// SPDX-License-Identifier: Apache-2.0
// Path tracers outdoors, with recursion: through instances of instances, and through instances
// under motion transforms.
#include "scene.h"

#include <cstring>

std::string_view bench_outdoors_ptx();
std::string_view bench_outdoors_moving_ptx();

namespace bench {
namespace {

Job outdoors(std::string_view ptx, unsigned samples) {
    Job job;
    job.ptx = ptx;
    job.payloadValues = 5;
    job.traceDepth = 4; // camera, two bounces, shadow
    job.graph = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
    job.raygen = "__raygen__camera";
    job.misses = {"__miss__sky", "__miss__free"};
    job.hits = {{"__closesthit__outdoors"}};
    job.params.samples = samples;
    job.params.depth = 3;
    return job;
}

OptixInstance place(const Accel& child, float scale, float3 at, unsigned id) {
    OptixInstance instance = {};
    const float matrix[12] = {scale, 0, 0, at.x, 0, scale, 0, at.y, 0, 0, scale, at.z};
    std::memcpy(instance.transform, matrix, sizeof(matrix));
    instance.instanceId = id;
    instance.visibilityMask = 255;
    instance.traversableHandle = child.handle;
    return instance;
}

Mesh makeCube() {
    Mesh mesh;
    for (unsigned i = 0; i < 8; ++i)
        for (unsigned axis = 0; axis < 3; ++axis)
            mesh.vertices.push_back(i >> axis & 1 ? 0.5f : -0.5f);
    for (unsigned axis = 0; axis < 3; ++axis)
        for (unsigned side = 0; side < 2; ++side) {
            const unsigned u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3, a = side << axis;
            const unsigned quad[6] = {a, a | u, a | u | v, a, a | u | v, a | v};
            mesh.indices.insert(mesh.indices.end(), quad, quad + 6);
        }
    return mesh;
}

// A cube of cubes of cubes, without the middles: each level has 20 instances of the one below.
Job sponge(OptixDeviceContext context, const JobSettings& settings) {
    constexpr unsigned kLevels = 5;
    Job job = outdoors(bench_outdoors_ptx(), 8);
    job.graphDepth = kLevels + 2;
    const Triangles cube = uploadTriangles(job, makeCube());
    addMesh(context, job, cube);
    const auto addLevel = [&](unsigned count, auto at, float scale) {
        std::vector<OptixInstance> copies;
        for (unsigned i = 0; i < count; ++i)
            if (const float3 to = at(i); to.x < 1e3f)
                copies.push_back(place(job.structures.back(), scale, to, unsigned(copies.size())));
        job.structures.push_back(buildInstances(context, copies));
    };
    const auto inCube = [](unsigned i) {
        const int x = int(i % 3) - 1, y = int(i / 3 % 3) - 1, z = int(i / 9) - 1;
        const bool isMiddle = (x == 0) + (y == 0) + (z == 0) >= 2;
        return isMiddle ? vec(1e4f) : vec(float(x), float(y), float(z)) / 3.0f;
    };
    for (unsigned level = 0; level < kLevels; ++level)
        addLevel(27, inCube, 1.0f / 3.0f);
    addLevel(
        25,
        [](unsigned i) { return vec(1.4f * float(i % 5) - 2.8f, 0, 1.4f * float(i / 5) - 2.8f); },
        1.0f);
    job.params.scene = job.structures.back().handle;
    job.records = {{0, materialOf(cube, vec(0.8f, 0.6f, 0.4f))}};
    job.params.camera =
        makeCamera(vec(3.6f, 2.2f, 4.6f), vec(0, -0.2f, 0), vec(0, 1, 0), 45.0f, settings.aspect());
    job.params.light[0] = normalize(vec(0.75f, 0.8f, 0.35f));
    job.params.emission = vec(1.9f, 1.6f, 1.2f);
    job.params.epsilon = 2e-5f;
    job.allocatePicture(settings.width, settings.height);
    return job;
}

Job movingPaths(OptixDeviceContext context, const JobSettings& settings) {
    Job job = outdoors(bench_outdoors_moving_ptx(), 8);
    addMovingRocks(context, job, settings, settings.some(1e4, 50), {});
    return job;
}

} // namespace

std::vector<JobKind> outdoorJobs() {
    return {
        {"sponge", "paths through instances of instances, seven levels", sponge, 0.01, 0.1},
        {"moving_paths", "paths through 10,000 instances under motion transforms", movingPaths, 0.01,
         0.1},
    };
}

} // namespace bench
