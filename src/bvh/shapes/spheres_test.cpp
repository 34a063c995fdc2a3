// SPDX-License-Identifier: Apache-2.0
// Spheres: the kernels of all instruction sets against every sphere in double precision; faces,
// filters, updates, access to the points.
#include "base/error.h"
#include "bvh/shapes/shapes.h"
#include "bvh/shapes/spheres.h"
#include "bvh/testing/meshes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sunstone::bvh {
namespace {

using namespace testing;

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

struct Judged {
    double t = std::numeric_limits<double>::infinity();
    uint32_t primitive = ~0u;
    bool back = false;
    bool clear = true; // no rounding may decide otherwise
};

Judged judge(const Cloud& cloud, const ShapeRay& ray) {
    Judged best;
    for (uint32_t i = 0; i < cloud.centres.size(); ++i) {
        double aa = 0, bb = 0, cc = -double(cloud.radii[i]) * cloud.radii[i];
        for (int a = 0; a < 3; ++a) {
            const double o = double(ray.origin[a]) - cloud.centres[i][a], d = ray.direction[a];
            aa += d * d, bb += o * d, cc += o * o;
        }
        const double disc = bb * bb - aa * cc;
        if (std::fabs(disc) < 1e-5 * aa * cloud.radii[i] * cloud.radii[i])
            best.clear = false;
        if (disc < 0)
            continue;
        for (const bool back : {false, true}) {
            const double t = (-bb + (back ? 1 : -1) * std::sqrt(disc)) / aa;
            if (std::fabs(t - ray.tmin) < 1e-5 || std::fabs(t - ray.tmax) < 1e-5)
                best.clear = false;
            if (t < ray.tmin || t > ray.tmax)
                continue;
            if (std::fabs(t - best.t) < 1e-5)
                best.clear = false;
            if (t < best.t) {
                best.t = t;
                best.primitive = i + 10;
                best.back = back;
            }
            break;
        }
    }
    return best;
}

Structure makeSpheres(const SphereInput& input, const BuildOptions& options = {}) {
    BuildInputs inputs;
    inputs.spheres = {&input, 1};
    return makeStructure(inputs, options);
}

ShapeRay randomRay(Random& random) {
    const Vec3 o = random.point(1.5f), d = random.unit() * random(0.5f, 2);
    return {{o.x, o.y, o.z}, random.below(3) ? 0 : random(0, 0.5f), {d.x, d.y, d.z},
            random.below(3) ? 1e30f : random(0.6f, 2), 0};
}

uint32_t compare(const Cloud& cloud, const void* block, Isa isa, uint32_t seed) {
    Random random(seed);
    uint32_t hits = 0;
    for (int i = 0; i < 3000; ++i) {
        const ShapeRay ray = randomRay(random);
        const Judged expected = judge(cloud, ray);
        if (!expected.clear)
            continue;
        ShapeHit hit{}, any{};
        const bool found = shapeKernels(isa).closest(block, ray, hit);
        EXPECT_EQ(expected.primitive != ~0u, found) << i;
        EXPECT_EQ(found, shapeKernels(isa).any(block, ray, any)) << i;
        if (!found || expected.primitive == ~0u)
            continue;
        ++hits;
        EXPECT_NEAR(expected.t, hit.t, 2e-5) << i;
        EXPECT_EQ(expected.primitive, hit.primitive) << i;
        EXPECT_EQ(expected.back ? 0x96u : 0x86u, hit.kind) << i;
    }
    return hits;
}

TEST(Spheres, AgreeWithEverySphere) {
    for (Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}) {
        if (!isaSupported(isa))
            continue;
        for (uint32_t count : {1u, 3u, 5u, 400u}) {
            const Cloud cloud(count, 5 + count);
            for (const bool fast : {false, true}) {
                BuildOptions options;
                options.preferFastBuild = fast;
                const Structure s = makeSpheres(cloud.input(), options);
                const uint32_t hits = compare(cloud, s.block(), isa, 91);
                EXPECT_GE(hits, count > 100 ? 500u : 0u) << isaName(isa) << " " << count;
            }
        }
    }
}

TEST(Spheres, OneRadiusAndInactiveOnes) {
    Cloud cloud(50, 4);
    cloud.radii.assign(50, 0.07f);
    SphereInput in = cloud.input();
    const float radius = 0.07f;
    in.radii = &radius;
    in.oneRadius = true;
    const Structure s = makeSpheres(in);
    EXPECT_GT(compare(cloud, s.block(), chosenIsa(), 92), 50u);
    // NaN, zero radius, negative radius.
    Cloud holes(50, 4);
    holes.centres[3].y = std::numeric_limits<float>::quiet_NaN();
    holes.radii[7] = 0;
    holes.radii[8] = -1;
    const Structure t = makeSpheres(holes.input());
    EXPECT_EQ(47u, headerOf(t.block())->numActive);
    holes.centres[3] = {100, 100, 100};
    holes.radii[3] = 1e-3f;
    holes.centres[7] = holes.centres[8] = {100, 101, 100};
    holes.radii[7] = holes.radii[8] = 1e-3f;
    EXPECT_GT(compare(holes, t.block(), chosenIsa(), 93), 50u);
}

TEST(Spheres, UpdatesFollow) {
    Cloud cloud(300, 6);
    BuildOptions options;
    options.allowUpdate = true;
    options.allowRandomVertexAccess = true;
    const SphereInput in = cloud.input();
    const Structure s = makeSpheres(in, options);
    Random random(7);
    for (Vec3& c : cloud.centres)
        c = random.point(1);
    cloud.radii[5] = 0.3f;
    BuildInputs inputs;
    inputs.spheres = {&in, 1};
    const auto temp = alignedBuffer(computeMemoryUsage(inputs, options).tempUpdate);
    update(inputs, options, temp.get(), computeMemoryUsage(inputs, options).tempUpdate,
           s.memory.get(), s.size);
    EXPECT_GT(compare(cloud, s.block(), chosenIsa(), 94), 400u);
    float point[4];
    ASSERT_TRUE(shapePoints(s.block(), kSphereShape, 15, 0, 0, point));
    EXPECT_EQ(0.3f, point[3]);
    EXPECT_EQ(cloud.centres[5].y, point[1]);
    EXPECT_FALSE(shapePoints(s.block(), kSphereShape, 9, 0, 0, point));
    EXPECT_FALSE(shapePoints(s.block(), kSphereShape, 15, 1, 0, point));
    EXPECT_FALSE(shapePoints(s.block(), 0x2503, 15, 0, 0, point));
    SphereInput fewer = in;
    fewer.numSpheres = 299;
    inputs.spheres = {&fewer, 1};
    EXPECT_THROW(checkUpdate(inputs, options, s.memory.get(), s.size), Error);
}

TEST(Spheres, FilterSeesEachOnce) {
    Cloud cloud(200, 8);
    const Structure s = makeSpheres(cloud.input());
    Random random(9);
    for (int i = 0; i < 300; ++i) {
        const ShapeRay ray = randomRay(random);
        std::map<uint32_t, int> seen;
        shapeKernels(chosenIsa())
            .filtered(s.block(), ray,
                      {[](void* context, const ShapeHit& hit) {
                           ++(*static_cast<std::map<uint32_t, int>*>(context))[hit.primitive];
                           return ShapeFilter::kIgnore;
                       },
                       &seen});
        ShapeHit hit{};
        EXPECT_EQ(!seen.empty(), shapeKernels(chosenIsa()).closest(s.block(), ray, hit));
        for (const auto& [primitive, times] : seen)
            EXPECT_EQ(1, times);
    }
}

} // namespace
} // namespace sunstone::bvh
