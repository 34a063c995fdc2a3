// SPDX-License-Identifier: Apache-2.0
// Curves and spheres on the GPU's builder (run on the CPU device) and by its traversal: rays get
// the answers of the CPU's structures, for all build flags.
#include "bvh/gpu/testing/device.h"
#include "bvh/shapes/curves.h"
#include "bvh/shapes/shapes.h"
#include "bvh/shapes/spheres.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;

constexpr CurveBasis kBases[] = {CurveBasis::kLinear, CurveBasis::kQuadraticBSpline,
                                 CurveBasis::kCubicBSpline, CurveBasis::kCatmullRom};

struct Cloud {
    std::vector<Vec3> centres;
    std::vector<float> radii;
    uint32_t flags = 0;

    Cloud(uint32_t count, uint32_t seed) {
        Random random(seed);
        for (uint32_t i = 0; i < count; ++i) {
            centres.push_back(random.point(1));
            radii.push_back(random(0.01f, 0.12f));
        }
    }
    SphereInput input() const {
        SphereInput in;
        in.centres = centres.data();
        in.numSpheres = uint32_t(centres.size());
        in.radii = radii.data();
        in.sbt.flags = &flags;
        in.sbt.primitiveIndexOffset = 10;
        return in;
    }
};

BuildInputs inputsOf(const SphereInput& input) {
    BuildInputs inputs;
    inputs.spheres = {&input, 1};
    return inputs;
}

// Strands of several segments; the vertices of the next one follow.
struct Strands {
    CurveBasis basis;
    std::vector<Vec3> vertices;
    std::vector<float> radii;
    std::vector<uint32_t> indices;
    bool caps = false;
    uint32_t flags = 0;

    Strands(CurveBasis kind, uint32_t strands, uint32_t segments, float wildness, uint32_t seed)
        : basis(kind) {
        Random random(seed);
        for (uint32_t s = 0; s < strands; ++s) {
            Vec3 at = random.point(1), step = random.unit() * 0.15f;
            for (uint32_t i = 0; i < segments + degreeOf(kind); ++i) {
                if (i < segments)
                    indices.push_back(uint32_t(vertices.size()));
                vertices.push_back(at);
                radii.push_back(random(0.005f, 0.03f));
                step = step + random.point(wildness);
                at = at + step;
            }
        }
    }
    CurveInput input() const {
        CurveInput in;
        in.basis = uint32_t(basis);
        in.vertices = vertices.data();
        in.radii = radii.data();
        in.numVertices = uint32_t(vertices.size());
        in.indices = indices.data();
        in.numSegments = uint32_t(indices.size());
        in.caps = caps;
        in.sbt.flags = &flags;
        in.sbt.primitiveIndexOffset = 7;
        return in;
    }
};

BuildInputs inputsOf(const CurveInput& input) {
    BuildInputs inputs;
    inputs.curves = {&input, 1};
    return inputs;
}

ShapeRay randomRay(Random& random) {
    const Vec3 o = random.point(1.5f), d = (random.point(1) - o) * random(0.5f, 2);
    return {{o.x, o.y, o.z},
            random.below(3) ? 0 : random(0, 0.5f),
            {d.x, d.y, d.z},
            random.below(3) ? 1e30f : random(0.6f, 2),
            0};
}

// CPU and GPU must give equal hits. If two pieces are equally near (where segments join), either
// may be reported.
void compareRays(const BuildInputs& inputs, const BuildOptions& options, const GpuStructure& gpu,
                 uint32_t seed, int count, int leastHits) {
    const Structure cpu = makeStructure(inputs, options);
    EXPECT_EQ(gpu.header().numActive, headerOf(cpu.block())->numActive);
    for (int a = 0; a < 3; ++a) {
        EXPECT_EQ(gpu.header().lower[a], headerOf(cpu.block())->lower[a]);
        EXPECT_EQ(gpu.header().upper[a], headerOf(cpu.block())->upper[a]);
    }
    Random random(seed);
    int hits = 0, other = 0;
    for (int i = 0; i < count; ++i) {
        const ShapeRay ray = randomRay(random);
        ShapeHit a{}, b{};
        const bool found = shapeKernels(Isa::kBaseline).closest(cpu.block(), ray, a);
        ASSERT_EQ(found, nearestShape(gpu.handle(), ray, b)) << "ray " << i << " seed " << seed;
        if (!found)
            continue;
        ++hits;
        ASSERT_NEAR(a.t, b.t, 1e-5f * a.t) << "ray " << i << " seed " << seed;
        ASSERT_EQ(a.kind, b.kind) << "ray " << i;
        ASSERT_EQ(a.sbt, b.sbt) << "ray " << i;
        other += a.primitive != b.primitive;
        if (a.primitive == b.primitive)
            ASSERT_NEAR(a.u, b.u, 1e-3f) << "ray " << i;
    }
    EXPECT_GE(hits, leastHits);
    EXPECT_LE(other, hits / 20);
}

void expectSame(const BuildInputs& inputs, const BuildOptions& options, uint32_t seed, int count,
                int leastHits) {
    compareRays(inputs, options, buildOnDevice(inputs, options), seed, count, leastHits);
}

std::vector<BuildOptions> allOptions() {
    std::vector<BuildOptions> all(4);
    all[1].preferFastBuild = true;
    all[2].preferFastTrace = true;
    all[3].allowRandomVertexAccess = true;
    return all;
}

TEST(GpuShapes, Spheres) {
    for (const uint32_t count : {1u, 3u, 400u})
        for (const BuildOptions& options : allOptions()) {
            const Cloud cloud(count, 5 + count);
            const SphereInput in = cloud.input();
            expectSame(inputsOf(in), options, 91, 2000, count > 100 ? 500 : 0);
        }
}

TEST(GpuShapes, SpheresOfOneRadiusAndInactiveOnes) {
    Cloud cloud(80, 4);
    const float radius = 0.07f;
    SphereInput in = cloud.input();
    in.radii = &radius;
    in.oneRadius = true;
    expectSame(inputsOf(in), {}, 3, 2000, 50);
    in = cloud.input();
    cloud.centres[3].y = NAN;
    cloud.radii[7] = 0;
    cloud.radii[8] = -1;
    expectSame(inputsOf(in), {}, 3, 2000, 50);
    for (float& r : cloud.radii)
        r = 0;
    expectSame(inputsOf(in), {}, 3, 100, 0);
    in.numSpheres = 0;
    expectSame(inputsOf(in), {}, 3, 100, 0);
}

TEST(GpuShapes, SeveralInputsWithStrides) {
    const Cloud a(100, 4), b(60, 5);
    std::vector<float> packed;
    for (size_t i = 0; i < b.centres.size(); ++i)
        packed.insert(packed.end(), {b.centres[i].x, b.centres[i].y, b.centres[i].z, b.radii[i]});
    const uint32_t flags[2] = {1, 0};
    SphereInput inputs[2] = {a.input(), b.input()};
    inputs[1].centres = packed.data();
    inputs[1].centreStride = inputs[1].radiusStride = 16;
    inputs[1].radii = packed.data() + 3;
    std::vector<uint8_t> offsets(60);
    for (size_t i = 0; i < offsets.size(); ++i)
        offsets[i] = i % 2;
    inputs[1].sbt = {flags, 2, offsets.data(), 1, 0, 500};
    BuildInputs all;
    all.spheres = inputs;
    expectSame(all, {}, 8, 2000, 500);
}

TEST(GpuShapes, Curves) {
    for (const CurveBasis basis : kBases)
        for (const BuildOptions& options : allOptions()) {
            SCOPED_TRACE(uint32_t(basis));
            const Strands strands(basis, 60, 5, 0.05f, 3);
            const CurveInput in = strands.input();
            expectSame(inputsOf(in), options, 17, 1200, 200);
        }
}

TEST(GpuShapes, BentCurvesWithCaps) {
    for (const CurveBasis basis : kBases) {
        SCOPED_TRACE(uint32_t(basis));
        Strands strands(basis, 60, 3, 0.3f, 4);
        for (float& r : strands.radii)
            r *= 4;
        strands.caps = basis != CurveBasis::kLinear;
        const CurveInput in = strands.input();
        expectSame(inputsOf(in), {}, 18, 1200, 300);
    }
}

// An updated structure gives the hits of a structure built from the new input.
void expectFollows(const BuildInputs& inputs, const std::function<void()>& change, uint32_t seed) {
    BuildOptions options;
    options.allowUpdate = options.allowRandomVertexAccess = true;
    const Device& device = Device::get();
    const GpuStructure s = buildOnDevice(inputs, options);
    change();
    Buffer temp(Builder::computeMemoryUsage(inputs, options).tempUpdate);
    device.builder().update(nullptr, inputs, options, temp.address(), temp.size(),
                            s.memory->address(), s.memory->size());
    ASSERT_EQ(device.driver().ctxSynchronize(), CUDA_SUCCESS);
    EXPECT_TRUE(device.builder().takeFailures().empty());
    compareRays(inputs, {}, s, seed, 1000, 100);
}

TEST(GpuShapes, UpdatesFollow) {
    Cloud cloud(300, 6);
    cloud.radii[9] = 0; // becomes active
    const SphereInput in = cloud.input();
    expectFollows(
        inputsOf(in),
        [&] {
            Random random(7);
            for (Vec3& c : cloud.centres)
                c = random.point(1);
            cloud.radii[9] = 0.1f;
            cloud.radii[20] = -1;
        },
        31);
    for (const CurveBasis basis : kBases) {
        SCOPED_TRACE(uint32_t(basis));
        Strands strands(basis, 60, 4, 0.05f, 8);
        strands.radii[3] = NAN;
        const CurveInput curves = strands.input();
        expectFollows(
            inputsOf(curves),
            [&] {
                const Strands others(basis, 60, 4, 0.1f, 9);
                std::copy(others.vertices.begin(), others.vertices.end(), strands.vertices.begin());
                strands.radii[3] = 0.02f;
                strands.vertices[30].z = INFINITY;
            },
            32);
    }
}

TEST(GpuShapes, CurvesThatAreInactive) {
    Strands strands(CurveBasis::kCubicBSpline, 30, 3, 0.05f, 5);
    strands.indices[5] = 100000;
    strands.vertices[20].x = INFINITY;
    for (int i = 40; i < 50; ++i)
        strands.radii[size_t(i)] = 0;
    CurveInput in = strands.input();
    expectSame(inputsOf(in), {}, 19, 1000, 20);
    in.indices = nullptr;
    expectSame(inputsOf(in), {}, 19, 100, 0);
}

TEST(GpuShapes, MixedInputsAreRefused) {
    CurveInput curves[2];
    curves[1].basis = 0x2501;
    BuildInputs inputs;
    inputs.curves = curves;
    EXPECT_THROW(Builder::computeMemoryUsage(inputs, {}), Error);
    curves[1].basis = curves[0].basis = 0x2505;
    EXPECT_THROW(Builder::computeMemoryUsage(inputs, {}), Error);
    curves[1].basis = curves[0].basis = 0x2503;
    EXPECT_NO_THROW(Builder::computeMemoryUsage(inputs, {}));
    const SphereInput spheres;
    inputs.spheres = {&spheres, 1};
    EXPECT_THROW(Builder::computeMemoryUsage(inputs, {}), Error);
}

} // namespace
} // namespace sunstone::bvh::gpu
