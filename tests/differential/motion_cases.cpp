// SPDX-License-Identifier: Apache-2.0
// Motion: of vertices, of instances through matrix and SRT transforms; times within the keys,
// between them and outside.
#include "lab.h"

#include <cstring>

namespace differential {
namespace {

Pipeline moving(unsigned graphFlags, unsigned depth) {
    Pipeline pipeline;
    pipeline.motion = true;
    pipeline.graphFlags = graphFlags;
    pipeline.graphDepth = depth;
    HitRecord hit;
    hit.data = {100, kAccept, nullptr};
    pipeline.hits = {hit};
    return pipeline;
}

// Times from before the first key to after the last.
std::vector<TestRay> raysAtTimes(size_t count, uint64_t seed) {
    std::vector<TestRay> rays = randomRays(count, 3, seed);
    Random random(seed + 1);
    for (size_t i = 0; i < rays.size(); ++i)
        rays[i].time = i % 5 == 0 ? float(i / 5 % 3) * 0.5f : -0.2f + 1.4f * random.unit();
    return rays;
}

OptixMotionOptions between(float begin, float end, unsigned keys, unsigned flags = 0) {
    OptixMotionOptions motion = {};
    motion.numKeys = (unsigned short)keys;
    motion.timeBegin = begin;
    motion.timeEnd = end;
    motion.flags = (unsigned short)flags;
    return motion;
}

void vertices(const Lab& lab, Answer& answer, unsigned keys, unsigned flags) {
    Mesh mesh = randomTriangles(200, 0.4f, 201);
    const std::vector<float> rest = mesh.vertices;
    Random random(202);
    for (unsigned k = 1; k < keys; ++k)
        for (const float x : rest)
            mesh.vertices.push_back(x + 0.3f * random.symmetric());
    mesh.keys = keys;
    const Accel accel = lab.triangles(mesh, between(0, 1, keys, flags));
    answer.seen = lab.trace(moving(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS, 1),
                            raysAtTimes(500, 203), accel.handle);
}

template <class Transform>
void traceTransform(const Lab& lab, Answer& answer, std::vector<unsigned char>& bytes,
                    OptixTraversableType type) {
    const Accel mesh = lab.triangles(randomTriangles(150, 0.4f, 204));
    reinterpret_cast<Transform*>(bytes.data())->child = mesh.handle;
    DeviceBuffer memory;
    memory.upload(bytes);
    OptixTraversableHandle handle = 0;
    OPTIX_CHECK(
        optixConvertPointerToTraversableHandle(lab.context(), memory.address(), type, &handle));
    std::vector<OptixInstance> instances = {makeInstance(handle, 205),
                                            makeInstance(mesh.handle, 206)};
    const Accel top = lab.instances(instances);
    answer.seen = lab.trace(moving(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY, 3),
                            raysAtTimes(500, 207), top.handle);
}

void matrices(const Lab& lab, Answer& answer, unsigned flags) {
    constexpr unsigned kKeys = 3;
    // The structure itself has room for two keys.
    std::vector<unsigned char> bytes(sizeof(OptixMatrixMotionTransform) +
                                     (kKeys - 2) * 12 * sizeof(float));
    auto* transform = reinterpret_cast<OptixMatrixMotionTransform*>(bytes.data());
    transform->motionOptions = between(0, 1, kKeys, flags);
    std::vector<float> keys(12 * kKeys);
    for (unsigned k = 0; k < kKeys; ++k)
        randomMatrix(&keys[12 * k], 208 + k);
    std::memcpy(transform->transform, keys.data(), keys.size() * sizeof(float));
    traceTransform<OptixMatrixMotionTransform>(lab, answer, bytes,
                                               OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM);
}

void rotations(const Lab& lab, Answer& answer) {
    constexpr unsigned kKeys = 2;
    std::vector<unsigned char> bytes(sizeof(OptixSRTMotionTransform));
    auto* transform = reinterpret_cast<OptixSRTMotionTransform*>(bytes.data());
    transform->motionOptions = between(0.25f, 0.75f, kKeys);
    // Half turns about z and x; a scale; a pivot.
    transform->srtData[0] = {1, 0, 0, 0.1f, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.2f, 0};
    transform->srtData[1] = {1.5f, 0.1f, 0, 0, 0.8f, 0.2f, 0, 1.2f,
                             0,    0.6f, 0, 0, 0.8f, 0.5f, 0, 0.3f};
    traceTransform<OptixSRTMotionTransform>(lab, answer, bytes,
                                            OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM);
}

} // namespace

std::vector<Case> motionCases() {
    const auto of = [](unsigned keys, unsigned flags) {
        return [=](const Lab& lab, Answer& answer) { vertices(lab, answer, keys, flags); };
    };
    constexpr unsigned kVanish = OPTIX_MOTION_FLAG_START_VANISH | OPTIX_MOTION_FLAG_END_VANISH;
    return {{"motion.vertices", of(2, 0)},
            {"motion.vertices_five_keys", of(5, 0)},
            {"motion.vertices_vanish", of(2, kVanish)},
            {"motion.matrix", [](const Lab& lab, Answer& a) { matrices(lab, a, 0); }},
            {"motion.matrix_vanish", [](const Lab& lab, Answer& a) { matrices(lab, a, kVanish); }},
            {"motion.srt", rotations}};
}

} // namespace differential
