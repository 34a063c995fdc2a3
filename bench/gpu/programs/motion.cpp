// SPDX-License-Identifier: Apache-2.0
// Motion blur: vertices with keys, motion transforms under instances, and a structure of instances
// with keys above them.
#include "scene.h"

#include <cstring>

std::string_view bench_moving_ptx();
std::string_view bench_moving_instances_ptx();

namespace bench {
namespace {

constexpr OptixMotionOptions kExposure = {2, OPTIX_MOTION_FLAG_NONE, 0, 1};

Job moving(std::string_view ptx) {
    Job job;
    job.ptx = ptx;
    job.payloadValues = 7;
    job.moves = true;
    job.raygen = "__raygen__direct";
    job.misses = {"__miss__sky", "__miss__free"};
    job.hits = {{"__closesthit__surface"}};
    job.params.samples = 4;
    return job;
}

Job triangles(OptixDeviceContext context, const JobSettings& settings) {
    Job job = moving(bench_moving_ptx());
    const Mesh mesh = makeScene(SceneKind::kTerrain, settings.some(1e6, 500));
    const std::vector<float> later = movedVertices(mesh);
    const Triangles uploaded = uploadTriangles(job, mesh, &later);
    job.params.scene = addMesh(context, job, uploaded);
    job.records = {{0, materialOf(uploaded, vec(0.55f, 0.5f, 0.4f))}};
    lightOutside(job, mesh, settings);
    job.allocatePicture(settings.width, settings.height);
    return job;
}

// Alternates between a matrix transform that shifts the child and an SRT transform that rotates it
// by 30 degrees.
std::vector<OptixTraversableHandle> transforms(OptixDeviceContext context, Job& job,
                                               OptixTraversableHandle child, size_t count) {
    constexpr size_t kStride = (sizeof(OptixSRTMotionTransform) + 63) / 64 * 64;
    std::vector<unsigned char> bytes(count * kStride);
    constexpr float kSine = 0.258819f, kCosine = 0.965926f; // of half the angle
    for (size_t i = 0; i < count; ++i) {
        unsigned char* const to = bytes.data() + i * kStride;
        if (i % 2 == 0) {
            OptixMatrixMotionTransform matrix = {};
            matrix.child = child;
            matrix.motionOptions = kExposure;
            for (auto& key : matrix.transform)
                key[0] = key[5] = key[10] = 1;
            matrix.transform[1][3 + 4 * (i / 2 % 3)] = 0.5f;
            std::memcpy(to, &matrix, sizeof(matrix));
        } else {
            OptixSRTMotionTransform srt = {};
            srt.child = child;
            srt.motionOptions = kExposure;
            srt.srtData[0] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0};
            srt.srtData[1] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, kSine, 0, kCosine, 0.5f, 0, 0};
            std::memcpy(to, &srt, sizeof(srt));
        }
    }
    job.upload(bytes);
    std::vector<OptixTraversableHandle> handles(count);
    for (size_t i = 0; i < count; ++i)
        OPTIX_CHECK(optixConvertPointerToTraversableHandle(
            context, job.buffers.back().address() + i * kStride,
            i % 2 ? OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM
                  : OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM,
            &handles[i]));
    return handles;
}

} // namespace

void addMovingRocks(OptixDeviceContext context, Job& job, const JobSettings& settings,
                    unsigned count, const OptixMotionOptions& keys) {
    job.moves = true;
    job.graph = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
    job.graphDepth = 3;
    const Mesh rock = makeRock(settings.some(4000, 200));
    const Triangles uploaded = uploadTriangles(job, rock);
    const std::vector<float> matrices = scatter(count);
    std::vector<OptixInstance> records(matrices.size() / 12);
    const auto children = transforms(context, job, addMesh(context, job, uploaded), records.size());
    for (size_t i = 0; i < records.size(); ++i) {
        std::memcpy(records[i].transform, &matrices[12 * i], sizeof(records[i].transform));
        records[i].instanceId = unsigned(i);
        records[i].visibilityMask = 255;
        records[i].traversableHandle = children[i];
    }
    job.structures.push_back(buildInstances(context, records, keys));
    job.params.scene = job.structures.back().handle;
    job.records = {{0, materialOf(uploaded, vec(0.5f))}};
    lightOutside(job, rock, settings);
    job.allocatePicture(settings.width, settings.height);
}

namespace {

Job movingInstances(OptixDeviceContext context, const JobSettings& settings, double count,
                    const OptixMotionOptions& keys) {
    Job job = moving(bench_moving_instances_ptx());
    addMovingRocks(context, job, settings, settings.some(count, 50), keys);
    return job;
}
Job underTransforms(OptixDeviceContext context, const JobSettings& settings) {
    return movingInstances(context, settings, 1e4, {});
}
Job withKeys(OptixDeviceContext context, const JobSettings& settings) {
    return movingInstances(context, settings, 5e4, kExposure);
}

} // namespace

std::vector<JobKind> motionJobs() {
    return {
        {"motion_triangles", "vertices with two motion keys", triangles, 0.002, 0.02},
        {"motion_transforms", "10,000 instances under motion transforms", underTransforms, 0.002,
         0.02},
        {"motion_instances", "50,000, and a structure with motion keys", withKeys, 0.002, 0.02},
    };
}

} // namespace bench
