// SPDX-License-Identifier: Apache-2.0
// Instances of one and of several levels, and static transforms.
#include "lab.h"

#include <algorithm>
#include <cstring>

namespace differential {
namespace {

Pipeline withInstances(unsigned depth, unsigned records = 1, const char* anyHit = nullptr) {
    Pipeline pipeline;
    pipeline.graphFlags = depth == 2 ? OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING
                                     : OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
    pipeline.graphDepth = depth;
    for (unsigned i = 0; i < records; ++i) {
        HitRecord hit;
        hit.anyHit = anyHit;
        hit.data = {100 + i, kIgnoreOdd, nullptr};
        pipeline.hits.push_back(hit);
    }
    return pipeline;
}

void oneLevel(const Lab& lab, Answer& answer) {
    const Accel mesh = lab.triangles(randomTriangles(60, 0.3f, 31));
    const Accel other = lab.triangles(randomTriangles(40, 0.5f, 32));
    std::vector<OptixInstance> instances;
    for (unsigned i = 0; i < 30; ++i)
        instances.push_back(makeInstance(i % 3 ? mesh.handle : other.handle, i));
    const Accel top = lab.instances(instances);
    answer.seen = lab.trace(withInstances(2), randomRays(500, 4, 33), top.handle);
}

void masks(const Lab& lab, Answer& answer) {
    const Accel mesh = lab.triangles(randomTriangles(60, 0.3f, 34));
    std::vector<OptixInstance> instances;
    for (unsigned i = 0; i < 24; ++i) {
        instances.push_back(makeInstance(mesh.handle, 40 + i));
        instances.back().visibilityMask = 1u << i % 8;
    }
    const Accel top = lab.instances(instances);
    std::vector<TestRay> rays = randomRays(400, 4, 35);
    for (size_t i = 0; i < rays.size(); ++i)
        rays[i].mask = unsigned(i * 37 % 256);
    answer.seen = lab.trace(withInstances(2), rays, top.handle);
}

void flags(const Lab& lab, Answer& answer) {
    const unsigned instanceFlags[] = {
        OPTIX_INSTANCE_FLAG_NONE, OPTIX_INSTANCE_FLAG_DISABLE_TRIANGLE_FACE_CULLING,
        OPTIX_INSTANCE_FLAG_FLIP_TRIANGLE_FACING, OPTIX_INSTANCE_FLAG_DISABLE_ANYHIT,
        OPTIX_INSTANCE_FLAG_ENFORCE_ANYHIT};
    const unsigned rayFlags[] = {OPTIX_RAY_FLAG_NONE, OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES,
                                 OPTIX_RAY_FLAG_CULL_FRONT_FACING_TRIANGLES,
                                 OPTIX_RAY_FLAG_DISABLE_ANYHIT, OPTIX_RAY_FLAG_ENFORCE_ANYHIT};
    Mesh source = randomTriangles(60, 0.3f, 36);
    source.flags = {OPTIX_GEOMETRY_FLAG_NONE, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT};
    for (unsigned i = 0; i < 60; ++i)
        source.sbt.push_back(i / 3 % 2);
    const Accel mesh = lab.triangles(source);
    std::vector<OptixInstance> instances;
    for (unsigned i = 0; i < 30; ++i) {
        instances.push_back(makeInstance(mesh.handle, 70 + i));
        instances.back().flags = instanceFlags[i % 5];
        instances.back().sbtOffset = i % 4;
        if (i % 2) // mirrored
            for (int k = 0; k < 12; k += 4)
                instances.back().transform[k] *= -1;
    }
    const Accel top = lab.instances(instances);
    std::vector<TestRay> rays = randomRays(500, 4, 37);
    for (size_t i = 0; i < rays.size(); ++i)
        rays[i].flags = rayFlags[i % 5];
    answer.seen = lab.trace(withInstances(2, 6, "__anyhit__rule"), rays, top.handle);
}

// The 112 bytes of a static transform in device memory.
struct Transform {
    DeviceBuffer memory;
    OptixTraversableHandle handle = 0;
};
Transform makeTransform(const Lab& lab, OptixTraversableHandle child, uint64_t seed) {
    OptixStaticTransform transform = {};
    transform.child = child;
    randomMatrix(transform.transform, seed);
    // The application provides the inverse: here by cofactors of the upper 3 x 3, in double
    // precision.
    const float* m = transform.transform;
    const auto at = [&](int r, int c) { return double(m[4 * r + c]); };
    double inverse[9], det = 0;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            inverse[3 * c + r] = at((r + 1) % 3, (c + 1) % 3) * at((r + 2) % 3, (c + 2) % 3) -
                                 at((r + 1) % 3, (c + 2) % 3) * at((r + 2) % 3, (c + 1) % 3);
    for (int c = 0; c < 3; ++c)
        det += at(0, c) * inverse[3 * c];
    for (int r = 0; r < 3; ++r) {
        double shift = 0;
        for (int c = 0; c < 3; ++c) {
            inverse[3 * r + c] /= det;
            shift -= inverse[3 * r + c] * at(c, 3);
            transform.invTransform[4 * r + c] = float(inverse[3 * r + c]);
        }
        transform.invTransform[4 * r + 3] = float(shift);
    }
    Transform result;
    result.memory.upload(&transform, sizeof(transform));
    OPTIX_CHECK(optixConvertPointerToTraversableHandle(lab.context(), result.memory.address(),
                                                       OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM,
                                                       &result.handle));
    return result;
}

void staticTransform(const Lab& lab, Answer& answer) {
    const Accel mesh = lab.triangles(randomTriangles(200, 0.4f, 51));
    const Transform inner = makeTransform(lab, mesh.handle, 52);
    const Transform outer = makeTransform(lab, inner.handle, 53);
    answer.seen = lab.trace(withInstances(3), randomRays(400, 4, 54), outer.handle);
}

void twoLevels(const Lab& lab, Answer& answer) {
    const Accel mesh = lab.triangles(randomTriangles(60, 0.3f, 55));
    const Transform moved = makeTransform(lab, mesh.handle, 56);
    std::vector<OptixInstance> instances;
    for (unsigned i = 0; i < 6; ++i)
        instances.push_back(makeInstance(i % 2 ? mesh.handle : moved.handle, 57 + i));
    const Accel inner = lab.instances(instances);
    instances.clear();
    for (unsigned i = 0; i < 6; ++i)
        instances.push_back(makeInstance(i == 3 ? mesh.handle : inner.handle, 67 + i));
    const Accel top = lab.instances(instances);
    answer.seen = lab.trace(withInstances(4), randomRays(500, 4, 77), top.handle);
}

void fiveLevels(const Lab& lab, Answer& answer) {
    std::vector<Accel> levels;
    levels.push_back(lab.triangles(randomTriangles(60, 0.3f, 78)));
    for (unsigned level = 0; level < 5; ++level) {
        std::vector<OptixInstance> instances;
        for (unsigned i = 0; i < 2; ++i)
            instances.push_back(makeInstance(levels.back().handle, 80 + 2 * level + i));
        levels.push_back(lab.instances(instances));
    }
    answer.seen = lab.trace(withInstances(6), randomRays(400, 6, 91), levels.back().handle);
}

void nothing(const Lab& lab, Answer& answer) {
    std::vector<TestRay> rays = randomRays(50, 4, 92);
    answer.seen = lab.trace(withInstances(2), rays, 0);
    const Accel empty = lab.instances({});
    const std::vector<Seen> more = lab.trace(withInstances(2), rays, empty.handle);
    answer.seen.insert(answer.seen.end(), more.begin(), more.end());
}

} // namespace

std::vector<Case> instanceCases() {
    return {{"instances.one_level", oneLevel},   {"instances.masks", masks},
            {"instances.flags", flags},          {"instances.static_transforms", staticTransform},
            {"instances.two_levels", twoLevels}, {"instances.five_levels", fiveLevels},
            {"instances.nothing", nothing}};
}

} // namespace differential
