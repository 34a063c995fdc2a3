// SPDX-License-Identifier: Apache-2.0
// Builds in each frame: a thousand small structures under instances, and one large mesh that moves.
#include "scene.h"

#include <algorithm>
#include <cstring>
#include <memory>

std::string_view bench_surfaces_ptx();
std::string_view bench_instances_ptx();

namespace bench {
namespace {

Job gbufferJob(std::string_view ptx) {
    Job job;
    job.ptx = ptx;
    job.payloadValues = 7;
    job.raygen = "__raygen__gbuffer";
    job.misses = {"__miss__sky", "__miss__free"};
    job.hits = {{"__closesthit__surface"}};
    job.params.samples = 1;
    return job;
}

OptixAccelBuildOptions buildOptions(unsigned flags) {
    OptixAccelBuildOptions options = {};
    options.buildFlags = flags;
    options.operation = OPTIX_BUILD_OPERATION_BUILD;
    return options;
}

// Buffers that each frame reuses.
struct Rebuild {
    OptixDeviceContext context = nullptr;
    OptixAccelBuildOptions options = {};
    DeviceBuffer temporary, output, instanceOutput, instances;
    size_t stride = 0; // of one structure in the output
    Triangles triangles = {};
    std::vector<OptixTraversableHandle> handles;
    std::vector<OptixInstance> records;

    OptixAccelBufferSizes sizesOf(const OptixBuildInput& input) const {
        OptixAccelBufferSizes sizes = {};
        OPTIX_CHECK(optixAccelComputeMemoryUsage(context, &options, &input, 1, &sizes));
        return sizes;
    }
    OptixTraversableHandle build(const OptixBuildInput& input, CUdeviceptr to, size_t size) const {
        OptixTraversableHandle handle = 0;
        OPTIX_CHECK(optixAccelBuild(context, nullptr, &options, &input, 1, temporary.address(),
                                    temporary.size(), to, size, &handle, nullptr, 0));
        return handle;
    }
    OptixBuildInput instanceInput() const {
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
        input.instanceArray.instances = instances.address();
        input.instanceArray.numInstances = unsigned(records.size());
        return input;
    }
};
constexpr unsigned kFlags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;

// Builds all structures, each of a part of the vertices, then the structure of instances above
// them.
void buildThousand(Rebuild& r, Job& job) {
    for (size_t i = 0; i < r.records.size(); ++i) {
        Triangles part = r.triangles;
        part.vertices[0] += i * part.vertexCount * sizeof(float3);
        const OptixTraversableHandle handle =
            r.build(inputOf(part, kFlags), r.output.address() + i * r.stride, r.stride);
        r.records[i].traversableHandle = handle;
    }
    CUDA_CHECK(cudaMemcpyAsync(r.instances.data(), r.records.data(), r.instances.size(),
                               cudaMemcpyHostToDevice, nullptr));
    job.params.scene =
        r.build(r.instanceInput(), r.instanceOutput.address(), r.instanceOutput.size());
}

Job thousandBuilds(OptixDeviceContext context, const JobSettings& settings) {
    Job job = gbufferJob(bench_instances_ptx());
    job.graph = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
    job.graphDepth = 2;
    auto r = std::make_shared<Rebuild>();
    r->context = context;
    r->options = buildOptions(OPTIX_BUILD_FLAG_PREFER_FAST_BUILD);
    const unsigned count = settings.some(1000, 20);
    Mesh rock = makeRock(1000);
    const std::vector<float> one = rock.vertices;
    for (unsigned i = 1; i < count; ++i)
        for (const float x : one)
            rock.vertices.push_back(x * (0.8f + 0.4f * randomOf(i, 1)));
    r->triangles = uploadTriangles(job, rock);
    r->triangles.vertexCount = unsigned(one.size() / 3);
    const std::vector<float> matrices = scatter(count);
    r->records.resize(count);
    for (unsigned i = 0; i < count; ++i) {
        std::memcpy(r->records[i].transform, &matrices[12 * size_t(i)],
                    sizeof(r->records[i].transform));
        for (const unsigned k : {0u, 1u, 2u, 4u, 5u, 6u, 8u, 9u, 10u})
            r->records[i].transform[k] *= 3;
        r->records[i].instanceId = i;
        r->records[i].visibilityMask = 255;
    }
    r->instances.allocate(count * sizeof(OptixInstance));
    const OptixAccelBufferSizes small = r->sizesOf(inputOf(r->triangles, kFlags));
    const OptixAccelBufferSizes top = r->sizesOf(r->instanceInput());
    r->stride = (small.outputSizeInBytes + 127) / 128 * 128;
    r->output.allocate(r->stride * count);
    r->instanceOutput.allocate(top.outputSizeInBytes);
    r->temporary.allocate(std::max(small.tempSizeInBytes, top.tempSizeInBytes));
    job.records = {{0, materialOf(r->triangles, vec(0.5f))}};
    lightOutside(job, rock, settings);
    job.prepare = [r](Job& j) { buildThousand(*r, j); };
    job.allocatePicture(settings.width, settings.height);
    return job;
}

Job rebuildEachFrame(OptixDeviceContext context, const JobSettings& settings) {
    constexpr unsigned kSteps = 4;
    Job job = gbufferJob(bench_surfaces_ptx());
    auto r = std::make_shared<Rebuild>();
    r->context = context;
    r->options = buildOptions(OPTIX_BUILD_FLAG_PREFER_FAST_BUILD);
    Mesh mesh = makeScene(SceneKind::kTerrain, settings.some(1e6, 500));
    const std::vector<float> first = mesh.vertices, last = movedVertices(mesh);
    for (unsigned step = 1; step < kSteps; ++step)
        for (size_t i = 0; i < first.size(); ++i)
            mesh.vertices.push_back(first[i] + (last[i] - first[i]) * float(step) / kSteps);
    r->triangles = uploadTriangles(job, mesh);
    r->triangles.vertexCount = unsigned(first.size() / 3);
    const OptixAccelBufferSizes sizes = r->sizesOf(inputOf(r->triangles, kFlags));
    r->output.allocate(sizes.outputSizeInBytes);
    r->temporary.allocate(sizes.tempSizeInBytes);
    job.records = {{0, materialOf(r->triangles, vec(0.55f, 0.5f, 0.4f))}};
    lightOutside(job, mesh, settings);
    job.prepare = [r](Job& j) {
        Triangles now = r->triangles;
        now.vertices[0] += size_t(j.frame % kSteps) * now.vertexCount * sizeof(float3);
        j.params.scene = r->build(inputOf(now, kFlags), r->output.address(), r->output.size());
    };
    job.allocatePicture(settings.width, settings.height);
    return job;
}

} // namespace

std::vector<JobKind> buildJobs() {
    return {
        {"builds_1000", "1,000 builds of 1,000 triangles and one of instances", thousandBuilds,
         0.001, 0.01},
        {"rebuild", "a million triangles built again for each frame", rebuildEachFrame, 0.001,
         0.01},
    };
}

} // namespace bench
