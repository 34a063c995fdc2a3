// SPDX-License-Identifier: Apache-2.0
// Bounds of instances: they contain every transformed vertex, become tighter with the levels
// inspected, and stay conservative where coordinates leave the range of floats.
#include "bvh/build/instance_bounds.h"

#include "bvh/input/build_input.h"
#include "bvh/testing/meshes.h"
#include "math/affine.h"

#include <gtest/gtest.h>

namespace sunstone::bvh {
namespace {

using namespace testing;

struct Transform {
    float m[12];
};

Transform randomTransform(Random& random, float scale, float distance) {
    Transform t;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            t.m[4 * row + column] = random(-scale, scale);
        t.m[4 * row + 3] = random(-distance, distance);
    }
    return t;
}

float areaOf(const math::Box& b) {
    const float x = b.upper.x - b.lower.x, y = b.upper.y - b.lower.y, z = b.upper.z - b.lower.z;
    return x * y + y * z + z * x;
}

TEST(InstanceBounds, HoldAllVerticesAndGetTighter) {
    const Mesh meshes[] = {icosphere(4), soup(3000, 0.05f, 9), cube()};
    for (const Mesh& mesh : meshes) {
        const Structure s = makeStructure(mesh.input());
        const uint64_t handle = traversableHandle(s.block());
        Random random(41);
        double area[4] = {};
        for (int i = 0; i < 200; ++i) {
            const Transform t = randomTransform(random, i % 2 ? 2.0f : 1e-3f, 1000);
            for (unsigned levels = 0; levels < 4; ++levels) {
                const math::Box box = instanceBounds(t.m, handle, {levels});
                for (const Vec3& v : mesh.vertices) {
                    const math::Vec3 p = math::transformPoint(t.m, {v.x, v.y, v.z});
                    for (int a = 0; a < 3; ++a) {
                        ASSERT_LE(box.lower[a], p[a]) << levels;
                        ASSERT_GE(box.upper[a], p[a]) << levels;
                    }
                }
                if (i % 2)
                    area[levels] += areaOf(box);
            }
        }
        // Parts that fill the corners of a box give no tighter bounds, smaller ones do.
        for (int levels = 1; levels < 4; ++levels)
            EXPECT_LE(area[levels], area[levels - 1] * 1.001);
        if (&mesh == &meshes[0]) {
            EXPECT_LT(area[2], area[0] * 0.9);
            EXPECT_LT(area[3], area[0] * 0.8);
        }
    }
}

TEST(InstanceBounds, BuildFlagsChooseTheLevels) {
    EXPECT_EQ(OpenLevels::of(kOptionFastBuild).count, 0u);
    EXPECT_GT(OpenLevels::of(kOptionFastTrace).count, OpenLevels::of(0).count);
}

TEST(InstanceBounds, EmptyFarAndForeignChildren) {
    const Mesh mesh = soup(100, 0.1f, 3);
    const Structure s = makeStructure(mesh.input());
    const uint64_t handle = traversableHandle(s.block());
    const float far[12] = {1e30f, 0, 0, 0, 0, 1e30f, 0, 0, 0, 0, 1e30f, 0};
    const math::Box wide = instanceBounds(far, handle, {2});
    EXPECT_LT(wide.lower.x, -1e28f);
    EXPECT_GT(wide.upper.z, 1e28f);
    const float beyond[12] = {3e38f, 3e38f, 3e38f, 3e38f, 0, 1, 0, 0, 0, 0, 1, 0};
    const math::Box lost = instanceBounds(beyond, handle, {2});
    EXPECT_FALSE(std::abs(lost.lower.x) < 1e38f && std::abs(lost.upper.x) < 1e38f);
    const Mesh nothing = soup(0, 0.1f, 3);
    const Structure empty = makeStructure(nothing.input());
    EXPECT_TRUE(instanceBounds(far, traversableHandle(empty.block()), {2}).empty());
    EXPECT_TRUE(instanceBounds(far, 0, {2}).empty());
    EXPECT_TRUE(instanceBounds(far, 64 | devlib::kTagGas, {2}).empty());
}

} // namespace
} // namespace sunstone::bvh
