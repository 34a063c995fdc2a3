// SPDX-License-Identifier: Apache-2.0
// Bounds of instances: they contain every transformed vertex, become tighter with the levels
// inspected, and stay conservative where coordinates leave the range of floats.
#include "bvh/build/instance_bounds.h"

#include "bvh/input/build_input.h"
#include "bvh/motion/transforms.h"
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

// A transform with three keys in memory.
struct alignas(64) Moving {
    union {
        SrtMotionTransform srt;
        MatrixMotionTransform matrix;
        uint8_t bytes[sizeof(SrtMotionTransform) + sizeof(SrtKey)];
    };
    bool isSrt;

    Moving(Random& random, uint64_t child, bool asSrt, float turn) : bytes{}, isSrt(asSrt) {
        srt.child = child;
        srt.motion = {3, 0, 0.0f, 1.0f};
        for (int k = 0; k < 3; ++k) {
            const float t = float(k) * turn;
            if (isSrt) {
                const float sine = std::sin(t), s = random(0.5f, 1.5f);
                const float x = random(-1, 1), y = random(-1, 1), z = random(-1, 1);
                const float n = sine / std::sqrt(x * x + y * y + z * z);
                srt.keys[k] = {s,
                               random(-0.1f, 0.1f),
                               0,
                               random(-3, 3),
                               s,
                               0,
                               random(-3, 3),
                               s,
                               0,
                               n * x,
                               n * y,
                               n * z,
                               std::cos(t),
                               random(-5, 5),
                               random(-5, 5),
                               0};
            } else {
                const Transform m = randomTransform(random, 1, 5);
                std::copy(m.m, m.m + 12, matrix.matrices[k]);
            }
        }
    }
    uint64_t handle() const {
        return reinterpret_cast<uint64_t>(bytes) |
               (isSrt ? devlib::kTagSrtMotion : devlib::kTagMatrixMotion);
    }
    KeySegment at(float time) const { return keySegment(3, 0.0f, 1.0f, time); }
};

void expectInside(const math::Box& box, const float m[12], const float inner[12],
                  const Mesh& mesh) {
    for (const Vec3& v : mesh.vertices) {
        const math::Vec3 p = math::transformPoint(m, math::transformPoint(inner, {v.x, v.y, v.z}));
        for (int a = 0; a < 3; ++a) {
            ASSERT_LE(box.lower[a], p[a]);
            ASSERT_GE(box.upper[a], p[a]);
        }
    }
}

TEST(InstanceBounds, BelowMotionTransformsHoldAllVerticesAndGetTighter) {
    const Mesh mesh = icosphere(3);
    const Structure s = makeStructure(mesh.input());
    const uint64_t structure = traversableHandle(s.block());
    Random random(43);
    double area[2][2] = {};
    for (int i = 0; i < 100; ++i) {
        const bool isSrt = i % 2;
        const Moving moving(random, structure, isSrt, random(0, 1.2f));
        const Transform t = randomTransform(random, 2, 100);
        const math::Box loose = instanceBounds(t.m, moving.handle(), {0}),
                        tight = instanceBounds(t.m, moving.handle(), {2});
        area[isSrt][0] += areaOf(loose);
        area[isSrt][1] += areaOf(tight);
        for (int k = 0; k <= 40; ++k) {
            float inner[12];
            transformAt(moving.handle(), moving.at(float(k) / 40), inner);
            expectInside(tight, t.m, inner, mesh);
            if (HasFatalFailure())
                return;
        }
    }
    EXPECT_LT(area[0][1], area[0][0] * 0.75);
    EXPECT_LT(area[1][1], area[1][0] * 0.75);
}

TEST(InstanceBounds, ChainsOfTransforms) {
    const Mesh mesh = icosphere(3);
    const Structure s = makeStructure(mesh.input());
    Random random(44);
    const Moving inner(random, traversableHandle(s.block()), true, 0.5f);
    alignas(64) StaticTransform still = {};
    still.child = traversableHandle(s.block());
    const Transform t = randomTransform(random, 2, 10), own = randomTransform(random, 2, 10);
    std::copy(own.m, own.m + 12, still.transform);
    const uint64_t handle = reinterpret_cast<uint64_t>(&still) | devlib::kTagStatic;
    const math::Box loose = instanceBounds(t.m, handle, {0}),
                    tight = instanceBounds(t.m, handle, {2});
    expectInside(tight, t.m, own.m, mesh);
    EXPECT_LT(areaOf(tight), areaOf(loose) * 0.75f);
    // The bounds of two motion transforms in a row are those of boxes in boxes.
    const Moving outer(random, inner.handle(), true, 0.5f);
    EXPECT_EQ(areaOf(instanceBounds(t.m, outer.handle(), {2})),
              areaOf(instanceBounds(t.m, outer.handle(), {0})));
    // A static transform between an instance and a motion transform.
    still.child = inner.handle();
    const math::Box both = instanceBounds(t.m, handle, {2});
    for (int k = 0; k <= 10; ++k) {
        float moved[12];
        transformAt(inner.handle(), inner.at(float(k) / 10), moved);
        expectInside(both, math::multiply(t.m, own.m).m, moved, mesh);
    }
    EXPECT_LT(areaOf(both), areaOf(instanceBounds(t.m, handle, {0})) * 0.75f);
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
