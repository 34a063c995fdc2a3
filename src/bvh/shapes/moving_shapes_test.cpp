// SPDX-License-Identifier: Apache-2.0
// Curves and spheres with motion keys. The reference is a structure without motion of the points at
// that time.
#include "base/error.h"
#include "bvh/testing/moving_shapes.h"

#include <gtest/gtest.h>

#include <set>

namespace sunstone::bvh {
namespace {

using namespace testing;

std::set<uint32_t> offered(const void* block, Isa isa, const ShapeRay& ray) {
    std::set<uint32_t> seen;
    shapeKernels(isa).filtered(block, ray,
                               {[](void* context, const ShapeHit& hit) {
                                    static_cast<std::set<uint32_t>*>(context)->insert(
                                        hit.primitive);
                                    return ShapeFilter::kIgnore;
                                },
                                &seen});
    return seen;
}

// Rays that touch a surface may differ, because moving curves are always cut as finely as possible.
struct Tally {
    uint32_t rays = 0, hits = 0, wrong = 0;
};

void compare(const void* moving, const void* still, Isa isa, float time, Random& random,
             Tally& tally) {
    for (int i = 0; i < 150; ++i) {
        const ShapeRay ray = randomShapeRay(random, time);
        ShapeHit a{}, b{}, any{};
        const bool hitA = shapeKernels(isa).closest(moving, ray, a);
        const bool hitB = shapeKernels(isa).closest(still, ray, b);
        bool good = hitA == hitB && hitA == shapeKernels(isa).any(moving, ray, any);
        if (good && hitA)
            good = a.primitive == b.primitive && a.kind == b.kind &&
                   std::fabs(a.t - b.t) < 1e-4f && std::fabs(a.u - b.u) < 1e-2f;
        good = good && offered(moving, isa, ray) == offered(still, isa, ray);
        ++tally.rays;
        tally.hits += hitA;
        tally.wrong += !good;
    }
}

TEST(MovingShapes, AreThoseOfTheTime) {
    std::vector<BuildOptions> variants(3);
    variants[1].preferFastTrace = true;
    variants[2].preferFastBuild = true;
    for (const uint32_t shape : kMovingKinds)
        for (const uint32_t keys : {2u, 3u}) {
            const MovingShapes scene(shape, keys, shape + keys);
            for (BuildOptions& options : variants) {
                const Structure moving = scene.structure(options);
                ASSERT_EQ(withMotion(BlockType::kShapes), headerOf(moving.block())->type);
                Random random(shape ^ keys);
                Tally tally;
                for (const float time : {-2.0f, -1.0f, 0.3f, 1.0f, 2.2f, 3.0f, 7.0f}) {
                    const Structure still = scene.at(time).structure({});
                    for (Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512})
                        if (isaSupported(isa))
                            compare(moving.block(), still.block(), isa, time, random, tally);
                }
                EXPECT_GT(tally.hits, tally.rays / 15) << std::hex << shape;
                const uint32_t allowed =
                    isCurveBasis(shape) && shape != 0x2503 ? tally.rays / 100 : tally.rays / 1000;
                EXPECT_LE(tally.wrong, allowed) << std::hex << shape << std::dec << " of "
                                                << tally.rays << " hits " << tally.hits;
            }
        }
}

TEST(MovingShapes, VanishOutsideOfTheirTime) {
    for (const uint32_t shape : kMovingKinds) {
        MovingShapes scene(shape, 2, 77);
        for (const uint32_t flags :
             {0u, uint32_t(kStartVanish), uint32_t(kEndVanish),
              uint32_t(kStartVanish | kEndVanish)}) {
            scene.motion.flags = flags;
            const Structure s = scene.structure({});
            uint32_t before = 0, within = 0, after = 0;
            Random random(3);
            for (int i = 0; i < 200; ++i) {
                ShapeRay ray = randomShapeRay(random, -1.5f);
                ShapeHit hit{};
                before += shapeKernels(chosenIsa()).closest(s.block(), ray, hit);
                ray.time = 1;
                within += shapeKernels(chosenIsa()).closest(s.block(), ray, hit);
                ray.time = 3.5f;
                after += shapeKernels(chosenIsa()).closest(s.block(), ray, hit);
            }
            EXPECT_GT(within, 10u);
            EXPECT_EQ((flags & kStartVanish) == 0, before > 0);
            EXPECT_EQ((flags & kEndVanish) == 0, after > 0);
        }
    }
}

TEST(MovingShapes, UpdatesAndPointsOfATime) {
    for (const uint32_t shape : kMovingKinds) {
        BuildOptions options;
        options.allowUpdate = true;
        options.allowRandomVertexAccess = true;
        const MovingShapes first(shape, 3, 5), second(shape, 3, 6);
        const Structure s = first.structure(options);
        options.motion = second.motion;
        second.with([&](const BuildInputs& inputs) {
            const size_t size = computeMemoryUsage(inputs, options).tempUpdate;
            const auto temp = alignedBuffer(size);
            BuildOptions wrong = options;
            wrong.motion.end += 1;
            EXPECT_THROW(update(inputs, wrong, temp.get(), size, s.memory.get(), s.size), Error);
            update(inputs, options, temp.get(), size, s.memory.get(), s.size);
        });
        Tally tally;
        Random random(9);
        for (const float time : {-1.0f, 0.7f, 2.5f}) {
            const MovingShapes now = second.at(time, pointBetween);
            compare(s.block(), now.structure({}).block(), chosenIsa(), time, random, tally);
            float points[16];
            ASSERT_TRUE(shapePoints(s.block(), shape, 17, 0, time, points));
            EXPECT_EQ(now.positions[0][now.indices[17]].y, points[1]);
            EXPECT_EQ(now.radii[0][now.indices[17]], points[3]);
        }
        EXPECT_GT(tally.hits, tally.rays / 15);
        EXPECT_LE(tally.wrong, tally.rays / 100) << std::hex << shape;
    }
}

TEST(MovingShapes, GarbageAtOneKeyMakesNothing) {
    for (const uint32_t shape : kMovingKinds) {
        MovingShapes scene(shape, 2, 21);
        MovingShapes without = scene;
        for (uint32_t i = 0; i < kMovingCount; i += 2)
            scene.positions[1][scene.indices[i]].x = std::numeric_limits<float>::quiet_NaN();
        const Structure s = scene.structure({});
        EXPECT_EQ(kMovingCount / 2, headerOf(s.block())->numActive);
        Random random(4);
        uint32_t hits = 0;
        for (int i = 0; i < 1000; ++i) {
            const ShapeRay ray = randomShapeRay(random, 0.5f);
            for (const uint32_t primitive : offered(s.block(), chosenIsa(), ray)) {
                EXPECT_EQ(1u, primitive % 2);
                ++hits;
            }
        }
        EXPECT_GT(hits, 20u);
        for (auto& p : scene.positions[0])
            p.y = std::numeric_limits<float>::infinity();
        const Structure none = scene.structure({});
        ShapeHit hit{};
        for (const float time : {-1.0f, 1.0f, std::numeric_limits<float>::quiet_NaN()})
            EXPECT_FALSE(
                shapeKernels(chosenIsa()).closest(none.block(), randomShapeRay(random, time), hit));
    }
}

} // namespace
} // namespace sunstone::bvh
