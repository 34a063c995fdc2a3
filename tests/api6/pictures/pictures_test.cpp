// SPDX-License-Identifier: Apache-2.0
// The classic API and OptiX 7 render equal pictures of a scene, bit for bit: both traverse the same
// structures, and their programs have the same arithmetic (shade.h).
#include "scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>

namespace sunstone::pictures {
namespace {

Instance instanceAt(float x, float y, float z, float turn, float scale,
                    std::array<float, 3> albedo) {
    const float c = std::cos(turn) * scale, s = std::sin(turn) * scale;
    return {{c, 0, s, x, 0, scale * 1.25f, 0, y, -s, 0, c, z}, albedo};
}
std::vector<Instance> instances() {
    return {instanceAt(-1.4f, 0.4f, 0.2f, 0.3f, 0.9f, {0.8f, 0.3f, 0.2f}),
            instanceAt(0.4f, 0.1f, -0.7f, 1.1f, 1.1f, {0.3f, 0.7f, 0.4f}),
            instanceAt(1.7f, 0.6f, 0.5f, 2.5f, 0.6f, {0.3f, 0.4f, 0.9f}),
            instanceAt(0.0f, -1.2f, 0.0f, 0.0f, 1.9f, {0.7f, 0.7f, 0.6f})};
}

// A ball with bumps.
Scene mesh() {
    Scene scene;
    constexpr unsigned kRings = 24, kSides = 36;
    for (unsigned i = 0; i <= kRings; ++i)
        for (unsigned k = 0; k < kSides; ++k) {
            const float a = 3.1415926f * float(i) / kRings, b = 6.2831853f * float(k) / kSides;
            const float r = 0.8f + 0.12f * std::sin(5 * a) * std::cos(4 * b);
            scene.vertices.push_back(
                {r * std::sin(a) * std::cos(b), r * std::cos(a), r * std::sin(a) * std::sin(b)});
        }
    for (unsigned i = 0; i < kRings; ++i)
        for (unsigned k = 0; k < kSides; ++k) {
            const unsigned next = (k + 1) % kSides, row = i * kSides, below = row + kSides;
            scene.triangles.push_back({row + k, row + next, below + k});
            scene.triangles.push_back({row + next, below + next, below + k});
        }
    scene.instances = instances();
    return scene;
}

Scene spheres() {
    Scene scene;
    for (int i = 0; i < 40; ++i) {
        const float t = float(i) * 0.7f;
        scene.spheres.push_back({0.7f * std::cos(t), float(i) * 0.04f - 0.8f, 0.7f * std::sin(t),
                                 0.12f + 0.02f * float(i % 5)});
    }
    scene.instances = instances();
    return scene;
}

void expectSame(const Scene& scene) {
    const Picture classic = drawClassic(scene, SUNSTONE_CLASSIC_PTX);
    const Picture modern = drawModern(scene, SUNSTONE_MODERN_PTX);
    ASSERT_EQ(classic.size(), modern.size());
    size_t hits = 0, different = 0;
    std::set<float> colors;
    for (size_t i = 0; i < classic.size(); ++i) {
        hits += classic[i][3] > 0;
        colors.insert(classic[i][0]);
        if (std::memcmp(&classic[i], &modern[i], sizeof classic[i]) == 0)
            continue;
        if (++different <= 5)
            ADD_FAILURE() << "pixel " << i % kWidth << ", " << i / kWidth << ": " << classic[i][0]
                          << " " << classic[i][3] << " and " << modern[i][0] << " " << modern[i][3];
    }
    EXPECT_EQ(different, 0u);
    EXPECT_GT(hits, classic.size() / 5) << "the scene is in the picture";
    EXPECT_GT(colors.size(), 200u);
}

TEST(SamePicture, InstancesOfATriangleMesh) {
    expectSame(mesh());
}
TEST(SamePicture, CustomSpheresThatReflect) {
    expectSame(spheres());
}
TEST(SamePicture, TransparencyByAnyHitPrograms) {
    Scene scene = mesh();
    scene.isTransparent = true;
    expectSame(scene);
}

} // namespace
} // namespace sunstone::pictures
