// SPDX-License-Identifier: Apache-2.0
// Motion through the API: keys of triangles and boxes, motion transforms, structures of moving
// instances, in random graphs against a reference in double precision; values that hit programs
// see; updates, compaction, relocation, emitted boxes; pipelines without motion blur.
#include "device/motion.h"
#include "moving_scene.h"
#include "rig.h"

#include <algorithm>
#include <cmath>
#include <deque>

namespace tests::api {
namespace {

OptixPipelineCompileOptions motionOptions(bool motionBlur) {
    OptixPipelineCompileOptions options = compileOptions(1);
    options.usesMotionBlur = motionBlur;
    return options;
}

class MotionTest : public DeviceTest {
protected:
    void SetUp() override {
        DeviceTest::SetUp();
        rig_ = makeRig(true);
    }
    void TearDown() override {
        rig_.reset();
        DeviceTest::TearDown();
    }
    std::unique_ptr<Rig> makeRig(bool motionBlur, bool debug = false, unsigned graphFlags = 0) {
        OptixPipelineCompileOptions options = motionOptions(motionBlur);
        options.traversableGraphFlags = graphFlags;
        options.exceptionFlags = debug ? OPTIX_EXCEPTION_FLAG_DEBUG : OPTIX_EXCEPTION_FLAG_NONE;
        auto r = rig("motion", options);
        r->raygenRecord(r->raygen("__raygen__motion"));
        r->missRecord(r->miss("__miss__motion"));
        r->hitRecord(r->hit("__closesthit__motion"));
        r->hitRecord(r->hit("__closesthit__motion", "__anyhit__motion"));
        r->hitRecord(r->hit("__closesthit__motion", nullptr, "__intersection__motion"));
        r->link();
        return r;
    }
    std::vector<MotionSeen> trace(Rig& rig, OptixTraversableHandle handle,
                                  const std::vector<MotionRay>& rays, MotionParams params = {}) {
        Buffer in(rays), out(rays.size() * sizeof(MotionSeen));
        params.handle = handle;
        params.rays = in.as<MotionRay>();
        params.seen = out.as<MotionSeen>();
        rig.run(params, unsigned(rays.size()));
        return {out.as<MotionSeen>(), out.as<MotionSeen>() + rays.size()};
    }
    MotionSeen traceOne(OptixTraversableHandle handle, float time, MotionParams params = {}) {
        return trace(*rig_, handle, {{{0.1f, 0.1f, -50}, {0, 0, 1}, time, 0}}, params)[0];
    }

    // Rays at random triangles of the graph, at random times.
    struct Shots {
        std::vector<MotionRay> rays;
        std::vector<Nearest> expected;
    };
    Shots shoot(SceneMaker& random, const MovingNode& scene, float reach) {
        Shots shots;
        for (int i = 0; i < 30; ++i) {
            MotionRay ray{};
            ray.time = i == 0 ? 0.0f : i == 1 ? 1.0f : random.number(-1.5f, 2.5f);
            std::vector<WorldTriangle> triangles;
            scene.collect(ray.time, {}, ~0u, triangles);
            for (int k = 0; k < 25; ++k) {
                double target[3] = {};
                if (!triangles.empty()) {
                    const WorldTriangle& t = triangles[random.below(unsigned(triangles.size()))];
                    for (int a = 0; a < 3; ++a)
                        target[a] = (t.v[0][a] + t.v[1][a] + t.v[2][a]) / 3;
                }
                for (int a = 0; a < 3; ++a) {
                    ray.origin[a] = float(target[a]) + random.number(-reach, reach);
                    ray.direction[a] =
                        float(target[a]) + random.number(-0.1f, 0.1f) - ray.origin[a];
                }
                shots.rays.push_back(ray);
                shots.expected.push_back(nearestOf(triangles, ray.origin, ray.direction));
            }
        }
        return shots;
    }
    unsigned compare(const Shots& shots, const std::vector<MotionSeen>& seen, uint32_t seed) {
        unsigned hits = 0, wrong = 0;
        for (size_t i = 0; i < seen.size(); ++i) {
            const Nearest& e = shots.expected[i];
            if (e.doubtful)
                continue;
            const bool hit = std::isfinite(e.t);
            bool good = hit == (seen[i].hit == 1);
            if (hit && good)
                good = std::fabs(seen[i].t - e.t) <= 1e-3 * (1 + e.t) &&
                       seen[i].primitive == e.primitive && seen[i].instanceId == e.instanceId;
            if (!good && wrong++ == 0)
                ADD_FAILURE() << "seed " << seed << " ray " << i << " time " << shots.rays[i].time
                              << ": expected t " << e.t << " primitive " << e.primitive
                              << " instance " << e.instanceId << ", got "
                              << (seen[i].hit == 1 ? seen[i].t : -1.0f) << " " << seen[i].primitive
                              << " " << seen[i].instanceId;
            hits += hit;
        }
        EXPECT_EQ(0u, wrong) << "seed " << seed;
        return hits;
    }

    std::unique_ptr<Rig> rig_;
};

TEST_P(MotionTest, RandomGraphsAreWhereTheReferenceSaysAtAllTimes) {
    unsigned hits = 0;
    for (uint32_t seed = 1; seed <= 60; ++seed) {
        SceneMaker maker(context_, log_, seed);
        SceneLimits limits;
        limits.depth = 1 + seed % 5;
        limits.buildFlags = seed % 3 == 0 ? OPTIX_BUILD_FLAG_PREFER_FAST_BUILD : 0;
        const NodePointer scene = maker.make(limits);
        const Shots shots = shoot(maker, *scene, 4);
        hits += compare(shots, trace(*rig_, scene->handle, shots.rays), seed);
    }
    EXPECT_GT(hits, 8000u);
}

TEST_P(MotionTest, ManyMovingInstances) {
    SceneLimits leaf;
    leaf.triangles = 6;
    leaf.vanish = false;
    for (uint32_t seed = 100; seed < 106; ++seed) {
        SceneMaker maker(context_, log_, seed);
        std::vector<NodePointer> children;
        for (int i = 0; i < 60; ++i) {
            NodePointer gas = maker.gas(leaf);
            children.push_back(i % 3 == 0   ? maker.matrixMotion(leaf, gas)
                               : i % 3 == 1 ? maker.srtMotion(leaf, gas)
                                            : gas);
        }
        const NodePointer scene = maker.instances(leaf, children);
        const Shots shots = shoot(maker, *scene, 6);
        EXPECT_GT(compare(shots, trace(*rig_, scene->handle, shots.rays), seed), 150u);
    }
}

TEST_P(MotionTest, AllTrianglesAreFoundByAllRayFlags) {
    SceneMaker maker(context_, log_, 7);
    SceneLimits limits;
    limits.triangles = 30;
    const NodePointer scene =
        maker.instances(limits, {maker.srtMotion(limits, maker.gas(limits)), maker.gas(limits)});
    Shots shots = shoot(maker, *scene, 4);
    const std::vector<MotionSeen> plain = trace(*rig_, scene->handle, shots.rays);
    for (unsigned flags :
         {unsigned(OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT),
          unsigned(OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT),
          unsigned(OPTIX_RAY_FLAG_DISABLE_ANYHIT), unsigned(OPTIX_RAY_FLAG_ENFORCE_ANYHIT)})
        for (unsigned record : {0u, 1u}) {
            for (MotionRay& ray : shots.rays)
                ray.rayFlags = flags;
            MotionParams params{};
            params.sbtIndex = record;
            const std::vector<MotionSeen> seen = trace(*rig_, scene->handle, shots.rays, params);
            for (size_t i = 0; i < seen.size(); ++i) {
                // Payload: 0 miss, 1 closest hit, 2 neither ran.
                const unsigned expected = plain[i].hit == 0                           ? 0u
                                          : flags & OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT ? 2u
                                                                                      : 1u;
                ASSERT_EQ(expected, seen[i].hit) << flags << " " << i;
                const bool runs = record == 1 && !(flags & OPTIX_RAY_FLAG_DISABLE_ANYHIT);
                ASSERT_EQ(runs && seen[i].hit != 0, seen[i].anyHits > 0 && seen[i].hit != 0) << i;
                if (!(flags & OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT)) {
                    ASSERT_EQ(plain[i].t, seen[i].t);
                    ASSERT_EQ(plain[i].primitive, seen[i].primitive);
                }
            }
        }
}

TEST_P(MotionTest, HelpersFollowTheTransformListAtRayTime) {
    unsigned hits = 0;
    for (uint32_t seed = 200; seed < 215; ++seed) {
        SceneMaker maker(context_, log_, seed);
        SceneLimits limits;
        limits.vanish = false;
        limits.buildFlags = OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;
        const NodePointer gas = maker.gas(limits), srt = maker.srtMotion(limits, gas),
                          matrix = maker.matrixMotion(limits, srt), still = maker.fixed(matrix),
                          scene = maker.instances(limits, {still});
        const Shots shots = shoot(maker, *scene, 3);
        MotionParams params{};
        params.sbtIndex = 1;
        const std::vector<MotionSeen> seen = trace(*rig_, scene->handle, shots.rays, params);
        for (size_t i = 0; i < seen.size(); ++i) {
            const MotionSeen& s = seen[i];
            EXPECT_EQ(s.rayTime, shots.rays[i].time);
            if (s.hit != 1)
                continue;
            ++hits;
            EXPECT_EQ(s.hitTime, shots.rays[i].time);
            ASSERT_EQ(4u, s.transforms);
            EXPECT_EQ(unsigned(OPTIX_TRANSFORM_TYPE_INSTANCE), s.types[0]);
            EXPECT_EQ(unsigned(OPTIX_TRANSFORM_TYPE_STATIC_TRANSFORM), s.types[1]);
            EXPECT_EQ(unsigned(OPTIX_TRANSFORM_TYPE_MATRIX_MOTION_TRANSFORM), s.types[2]);
            EXPECT_EQ(unsigned(OPTIX_TRANSFORM_TYPE_SRT_MOTION_TRANSFORM), s.types[3]);
            EXPECT_EQ(gas->handle, s.gas);
            EXPECT_EQ(gas->handle, s.motionChild);
            for (int a = 0; a < 6; ++a)
                EXPECT_NEAR(s.object[a], s.computed[a], 2e-4 * (1 + std::fabs(s.object[a]))) << a;
            for (int a = 0; a < 3; ++a)
                EXPECT_NEAR(s.back[a], shots.rays[i].origin[a], 1e-3);
            // The hit lies in the plane of the vertices that the structure returns.
            double e1[3], e2[3], off[3];
            for (int a = 0; a < 3; ++a) {
                e1[a] = s.vertices[3 + a] - s.vertices[a];
                e2[a] = s.vertices[6 + a] - s.vertices[a];
                off[a] = s.computed[a] + s.t * s.computed[3 + a] - s.vertices[a];
            }
            const double n[3] = {e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2],
                                 e1[0] * e2[1] - e1[1] * e2[0]};
            const double distance = n[0] * off[0] + n[1] * off[1] + n[2] * off[2];
            EXPECT_LT(std::fabs(distance),
                      1e-3 * std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]));
            // Matrices: inverse of one another; the normal is that of z = 0 in world space.
            for (int row = 0; row < 3; ++row)
                for (int column = 0; column < 3; ++column) {
                    double sum = 0;
                    for (int k = 0; k < 3; ++k)
                        sum += double(s.toWorld[4 * row + k]) * s.toObject[4 * k + column];
                    EXPECT_NEAR(sum, row == column, 1e-3);
                }
            for (int column = 0; column < 2; ++column) {
                double sum = 0;
                for (int a = 0; a < 3; ++a)
                    sum += double(s.normal[a]) * s.toWorld[4 * a + column];
                EXPECT_NEAR(sum, 0, 1e-3);
            }
        }
    }
    EXPECT_GT(hits, 500u);
}

TEST_P(MotionTest, GettersTellTheOptionsOfTheBuild) {
    TriangleMesh a({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    Buffer later(std::vector<Vec3>{{-1, -1, 4}, {1, -1, 4}, {0, 1, 4}});
    const CUdeviceptr keys[2] = {a.vertexAddress, later.address()};
    const Accel still = buildAccel(context_, log_, {a.input});
    MotionSeen s = traceOne(still.handle, 0.5f);
    EXPECT_EQ(1u, s.hit);
    EXPECT_EQ(1u, s.steps);
    EXPECT_EQ(0, s.begin);
    EXPECT_EQ(0, s.end);
    a.input.triangleArray.vertexBuffers = keys;
    const Accel moving = buildMoving(context_, log_, {a.input}, {2, 0, -3.0f, 5.0f},
                                     OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    s = traceOne(moving.handle, 3.0f);
    EXPECT_EQ(1u, s.hit);
    EXPECT_EQ(2u, s.steps);
    EXPECT_EQ(-3, s.begin);
    EXPECT_EQ(5, s.end);
    EXPECT_FLOAT_EQ(53, s.t); // three quarters of the way to z = 4
    EXPECT_EQ(3, s.vertices[2]);
    EXPECT_EQ(50, traceOne(moving.handle, -9.0f).t);
    EXPECT_EQ(54, traceOne(moving.handle, 9.0f).t);
    for (unsigned short flags = 0; flags < 4; ++flags) {
        const Accel vanishing = buildMoving(context_, log_, {a.input}, {2, flags, 0.25f, 0.75f});
        EXPECT_EQ(flags & OPTIX_MOTION_FLAG_START_VANISH ? 0u : 1u,
                  traceOne(vanishing.handle, 0.24f).hit);
        EXPECT_EQ(flags & OPTIX_MOTION_FLAG_END_VANISH ? 0u : 1u,
                  traceOne(vanishing.handle, 0.76f).hit);
        for (float time : {0.25f, 0.5f, 0.75f})
            EXPECT_EQ(1u, traceOne(vanishing.handle, time).hit);
    }
}

// One structure or transform of each kind with motion, all with the same triangle.
struct WhatMoves {
    WhatMoves(OptixDeviceContext context, const LogRecord& log)
        : mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2}), boxes({{-1, -1, 0, 1, 1, 2}}),
          still(buildAccel(context, log, {mesh.input})) {
        const CUdeviceptr corners[2] = {mesh.vertexAddress, mesh.vertexAddress},
                          bounds[2] = {boxes.address, boxes.address};
        OptixBuildInput triangles = mesh.input, customs = boxes.input;
        triangles.triangleArray.vertexBuffers = corners;
        customs.customPrimitiveArray.aabbBuffers = bounds;
        const Motion motion = {2, 0, 0, 1};
        keep(buildMoving(context, log, {triangles}, motion));
        keep(buildMoving(context, log, {customs}, motion));
        SceneMaker maker(context, log, 3);
        const NodePointer child = std::make_shared<Fixed>(still.handle);
        nodes = {maker.matrixMotion({}, child), maker.srtMotion({}, child)};
        for (const NodePointer& node : nodes)
            handles.push_back(node->handle);
        lists.emplace_back(std::vector{instanceOf(still.handle, identity())});
        keep(buildMoving(context, log, {lists.back().input}, motion));
        for (const OptixTraversableHandle child : std::vector(handles)) {
            lists.emplace_back(std::vector{instanceOf(child, identity())});
            keep(buildAccel(context, log, {lists.back().input}));
        }
    }
    void keep(Accel accel) {
        handles.push_back(accel.handle);
        accels.push_back(std::move(accel));
    }
    struct Fixed : MovingNode {
        explicit Fixed(OptixTraversableHandle at) { handle = at; }
        void collect(double, const Matrix64&, unsigned,
                     std::vector<WorldTriangle>&) const override {}
    };

    TriangleMesh mesh;
    CustomBoxes boxes;
    Accel still;
    std::vector<Accel> accels;
    std::vector<NodePointer> nodes;
    std::deque<InstanceList> lists;
    std::vector<OptixTraversableHandle> handles;
};

// A pipeline without motion blur declares that nothing moves. Its rays miss objects with motion,
// and the log notes this; with debug exceptions such objects are invalid traversables.
TEST_P(MotionTest, WithoutMotionBlurRaysPassByWhatMoves) {
    const std::unique_ptr<Rig> still = makeRig(false), checked = makeRig(false, true);
    const WhatMoves scene(context_, log_);
    const std::vector<MotionRay> ray = {{{0.1f, 0.1f, -50}, {0, 0, 1}, 0.5f, 0}};
    for (const OptixTraversableHandle handle : scene.handles) {
        SCOPED_TRACE(&handle - scene.handles.data());
        log_.clear();
        const MotionSeen seen = trace(*still, handle, ray)[0];
        EXPECT_EQ(0u, seen.hit);
        EXPECT_EQ(0, seen.rayTime);
        EXPECT_NE(std::string::npos, log_.all().find("without usesMotionBlur")) << log_.all();
        log_.clear();
        trace(*checked, handle, ray);
        EXPECT_NE(std::string::npos, log_.all().find("invalid traversable")) << log_.all();
    }
    // The ray hits the static object beside the moving one.
    const InstanceList both({instanceOf(scene.handles[0], identity(), 1),
                             instanceOf(scene.still.handle, translation(0, 0, 3), 2)});
    const Accel top = buildAccel(context_, log_, {both.input});
    const MotionSeen seen = trace(*still, top.handle, ray)[0];
    EXPECT_EQ(1u, seen.hit);
    EXPECT_EQ(53, seen.t);
    EXPECT_EQ(2u, seen.instanceId);
    log_.clear();
    EXPECT_EQ(1u, trace(*still, scene.still.handle, ray)[0].hit);
    EXPECT_EQ(std::string::npos, log_.all().find("usesMotionBlur")) << log_.all();
}

// With SINGLE_LEVEL_INSTANCING a ray enters one transform or instance, and none below it.
TEST_P(MotionTest, GraphFlagsRuleOutASecondTransform) {
    const TriangleMesh mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    Buffer fixed(sizeof(OptixStaticTransform), 64), moving(sizeof(OptixMatrixMotionTransform), 64);
    auto* still = fixed.as<OptixStaticTransform>();
    auto* motion = moving.as<OptixMatrixMotionTransform>();
    still->child = motion->child = gas.handle;
    motion->motionOptions = {2, 0, 0, 1};
    for (float* to :
         {still->transform, still->invTransform, motion->transform[0], motion->transform[1]})
        std::ranges::copy(identity(), to);
    OptixTraversableHandle handles[2] = {};
    ASSERT_OK(optixConvertPointerToTraversableHandle(
        context_, fixed.address(), OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, &handles[0]));
    ASSERT_OK(optixConvertPointerToTraversableHandle(
        context_, moving.address(), OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM, &handles[1]));
    const std::unique_ptr<Rig> single =
        makeRig(true, false, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING);
    const std::vector<MotionRay> ray = {{{0, 0, -50}, {0, 0, 1}, 0.5f, 0}};
    for (const OptixTraversableHandle handle : handles) {
        const InstanceList list({instanceOf(handle, identity())});
        const Accel top = buildAccel(context_, log_, {list.input});
        EXPECT_EQ(1u, trace(*rig_, top.handle, ray)[0].hit);
        EXPECT_EQ(1u, trace(*single, handle, ray)[0].hit);
        log_.clear();
        EXPECT_EQ(0u, trace(*single, top.handle, ray)[0].hit);
        EXPECT_NE(std::string::npos, log_.all().find("traversableGraphFlags")) << log_.all();
    }
}

TEST_P(MotionTest, WithoutMotionBlurTimeIsZero) {
    const std::unique_ptr<Rig> still = makeRig(false);
    const TriangleMesh mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    for (const float time : {0.0f, 0.5f, -3.0f}) {
        const MotionSeen seen = trace(*still, gas.handle, {{{0, 0, -50}, {0, 0, 1}, time, 0}})[0];
        EXPECT_EQ(1u, seen.hit);
        EXPECT_EQ(0, seen.rayTime);
        EXPECT_EQ(0, seen.hitTime);
    }
}

TEST_P(MotionTest, CustomPrimitivesAreAskedWhereTheirBoxesAre) {
    std::mt19937 engine(5);
    const auto number = [&](float low, float high) {
        return low + (high - low) * float(engine() >> 8) * 0x1p-24f;
    };
    for (const unsigned count : {1u, 2u, 50u}) {
        constexpr unsigned kKeys = 3;
        std::vector<OptixAabb> boxes(kKeys * count);
        for (OptixAabb& b : boxes) {
            float* low = &b.minX;
            for (int a = 0; a < 3; ++a) {
                low[a] = number(-2, 2);
                low[3 + a] = low[a] + number(0.05f, 0.5f);
            }
        }
        Buffer memory(boxes);
        std::vector<CUdeviceptr> keys;
        for (unsigned k = 0; k < kKeys; ++k)
            keys.push_back(memory.address() + k * count * sizeof(OptixAabb));
        const unsigned flags[1] = {0};
        OptixBuildInput input{};
        input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        input.customPrimitiveArray.aabbBuffers = keys.data();
        input.customPrimitiveArray.numPrimitives = count;
        input.customPrimitiveArray.flags = flags;
        input.customPrimitiveArray.numSbtRecords = 1;
        const Accel gas = buildMoving(context_, log_, {input}, {kKeys, 0, 1.0f, 3.0f});
        MotionParams params{};
        params.boxes = memory.as<float>();
        params.boxCount = count;
        params.boxKeys = kKeys;
        params.boxBegin = 1;
        params.boxEnd = 3;
        params.sbtIndex = 2;
        std::vector<MotionRay> rays(3000);
        for (MotionRay& ray : rays) {
            ray.time = number(0, 4);
            const double place = std::clamp(double(ray.time) - 1, 0.0, 2.0);
            const unsigned key = std::min(unsigned(place), 1u), i = engine() % count;
            const OptixAabb &a = boxes[key * count + i], &b = boxes[(key + 1) * count + i];
            for (int axis = 0; axis < 3; ++axis) {
                const float x = float(place - key);
                const float middle = ((&a.minX)[axis] + (&a.maxX)[axis]) / 2 * (1 - x) +
                                     ((&b.minX)[axis] + (&b.maxX)[axis]) / 2 * x;
                ray.origin[axis] = middle + number(-3, 3);
                ray.direction[axis] = middle + number(-0.3f, 0.3f) - ray.origin[axis];
            }
        }
        const std::vector<MotionSeen> seen = trace(*rig_, gas.handle, rays, params);
        unsigned hits = 0, asked = 0;
        for (size_t r = 0; r < rays.size(); ++r) {
            const double place = std::clamp(double(rays[r].time) - 1, 0.0, 2.0);
            const unsigned key = std::min(unsigned(place), 1u);
            double nearest = INFINITY;
            bool doubtful = false;
            for (unsigned i = 0; i < count; ++i) {
                const OptixAabb &a = boxes[key * count + i], &b = boxes[(key + 1) * count + i];
                double enter = 0, leave = 1e16;
                for (int axis = 0; axis < 3; ++axis) {
                    const double x = place - key;
                    const double low = (&a.minX)[axis] * (1 - x) + (&b.minX)[axis] * x;
                    const double high = (&a.maxX)[axis] * (1 - x) + (&b.maxX)[axis] * x;
                    const double t0 = (low - rays[r].origin[axis]) / rays[r].direction[axis];
                    const double t1 = (high - rays[r].origin[axis]) / rays[r].direction[axis];
                    enter = std::max(enter, std::min(t0, t1));
                    leave = std::min(leave, std::max(t0, t1));
                }
                doubtful = doubtful || std::fabs(enter - leave) < 1e-4;
                if (enter <= leave)
                    nearest = std::min(nearest, enter);
            }
            asked += seen[r].anyHits;
            if (doubtful)
                continue;
            ASSERT_EQ(std::isfinite(nearest), seen[r].hit == 1) << r;
            if (seen[r].hit == 1) {
                ASSERT_NEAR(nearest, seen[r].t, 1e-4);
            }
            hits += seen[r].hit;
        }
        EXPECT_GT(hits, 500u);
        EXPECT_LT(asked, rays.size() * (count == 50 ? 5 : 2)); // not all boxes at all rays
        if (count == 1) { // its box is alone, and still decides
            EXPECT_LT(asked, rays.size());
        }
    }
}

TEST_P(MotionTest, UpdatesCompactionAndRelocationKeepMotion) {
    constexpr unsigned kFlags = OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
    TriangleMesh mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    std::vector<Vec3> end = {{-1, -1, 4}, {1, -1, 4}, {0, 1, 4}};
    Buffer later(end);
    const CUdeviceptr keys[2] = {mesh.vertexAddress, later.address()};
    mesh.input.triangleArray.vertexBuffers = keys;
    const Motion motion = {2, 0, 0, 1};
    Buffer boxes(2 * sizeof(OptixAabb)), size(8);
    const Accel gas = buildMoving(context_, log_, {mesh.input}, motion, kFlags,
                                  {{boxes.address(), OPTIX_PROPERTY_TYPE_AABBS},
                                   {size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
    EXPECT_EQ(0, boxes.as<OptixAabb>()[0].maxZ);
    EXPECT_EQ(4, boxes.as<OptixAabb>()[1].minZ);
    EXPECT_EQ(-1, boxes.as<OptixAabb>()[1].minX);
    Buffer small(*size.as<uint64_t>());
    OptixTraversableHandle compacted = 0;
    ASSERT_OK(optixAccelCompact(context_, nullptr, gas.handle, small.address(), small.size(),
                                &compacted));
    waitForDevice();
    EXPECT_EQ(52, traceOne(compacted, 0.5f).t);
    // Update the compacted one.
    for (Vec3& v : end)
        v.z = 8;
    std::memcpy(later.as<Vec3>(), end.data(), end.size() * sizeof(Vec3));
    OptixAccelBuildOptions options = buildOptions(kFlags);
    options.motionOptions = motion.options();
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &sizes));
    Buffer temp(sizes.tempUpdateSizeInBytes);
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    OptixTraversableHandle updated = 0;
    ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &mesh.input, 1, temp.address(),
                              temp.size(), small.address(), small.size(), &updated, nullptr, 0));
    waitForDevice();
    EXPECT_EQ(compacted, updated);
    EXPECT_EQ(54, traceOne(compacted, 0.5f).t);
    OptixAccelBuildOptions other = options;
    other.motionOptions.timeEnd = 2;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "motion range",
                    optixAccelBuild(context_, nullptr, &other, &mesh.input, 1, temp.address(),
                                    temp.size(), small.address(), small.size(), &updated, nullptr,
                                    0));
    log_.clear();
    // Relocate.
    OptixAccelRelocationInfo info{};
    ASSERT_OK(optixAccelGetRelocationInfo(context_, compacted, &info));
    Buffer copy(small.size());
    std::memcpy(copy.as<char>(), small.as<char>(), small.size());
    small.fill(0);
    OptixTraversableHandle moved = 0;
    ASSERT_OK(
        optixAccelRelocate(context_, nullptr, &info, 0, 0, copy.address(), copy.size(), &moved));
    waitForDevice();
    EXPECT_EQ(58, traceOne(moved, 1).t);
    // A structure of moving instances: its update follows a transform that changed.
    Buffer memory(sizeof(OptixSRTMotionTransform), 64);
    auto* srt = memory.as<OptixSRTMotionTransform>();
    srt->child = moved;
    srt->motionOptions = {2, 0, 0, 1};
    for (OptixSRTData& key : srt->srtData)
        key = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0};
    srt->srtData[1].tz = 2;
    OptixTraversableHandle transform = 0;
    ASSERT_OK(optixConvertPointerToTraversableHandle(
        context_, memory.address(), OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM, &transform));
    InstanceList list({instanceOf(transform, identity())});
    const Accel top =
        buildMoving(context_, log_, {list.input}, {3, 0, 0, 1}, OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    EXPECT_FLOAT_EQ(55, traceOne(top.handle, 0.5f).t);
    for (OptixSRTData& key : srt->srtData)
        key.tz += 100;
    options = buildOptions(OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    options.motionOptions = {3, 0, 0, 1};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &list.input, 1, &sizes));
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    Buffer scratch(sizes.tempUpdateSizeInBytes);
    ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &list.input, 1, scratch.address(),
                              scratch.size(), top.memory.address(), top.memory.size(), &updated,
                              nullptr, 0));
    waitForDevice();
    EXPECT_FLOAT_EQ(155, traceOne(top.handle, 0.5f).t);
}

TEST_P(MotionTest, TransformsInMemoryMayHoldAnything) {
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
    // Transforms that claim more keys than their buffer holds are read as far as memory is mapped.
    GTEST_SKIP() << "reads what is mapped, which address sanitizers refuse";
#endif
#endif
    TriangleMesh mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    std::mt19937 random(9);
    Buffer memory(4096, 64);
    std::vector<MotionRay> rays;
    for (float time : {0.0f, 0.5f, NAN, INFINITY, -1e38f})
        rays.push_back({{0.1f, 0.1f, -50}, {0, 0, 1}, time, 0});
    for (int i = 0; i < 42; ++i) {
        for (size_t k = 0; k < 1024; ++k)
            memory.as<uint32_t>()[k] = random();
        auto* transform = memory.as<OptixMatrixMotionTransform>();
        if (i % 3)
            transform->child = gas.handle;
        if (i % 2)
            transform->motionOptions.numKeys = (unsigned short)(random() % 5);
        if (i % 5 == 0)
            transform->child = memory.address() | (i % 2 ? 4 : 5); // itself
        if (i % 7 == 0) {
            transform->motionOptions.timeBegin = 1;
            transform->motionOptions.timeEnd = i % 2 ? 1.0f : -INFINITY;
        }
        OptixTraversableHandle handle = 0;
        ASSERT_OK(optixConvertPointerToTraversableHandle(
            context_, memory.address(),
            i % 2 ? OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM
                  : OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM,
            &handle));
        trace(*rig_, handle, rays);
        InstanceList list({instanceOf(handle, identity())});
        const Accel top =
            buildMoving(context_, log_, {list.input}, {(unsigned short)(1 + i % 3), 0, 0, 1});
        trace(*rig_, top.handle, rays);
    }
}

TEST_P(MotionTest, HitsCanPrintTheirTransforms) {
    SceneMaker maker(context_, log_, 1);
    SceneLimits limits;
    limits.vanish = false;
    TriangleMesh mesh({{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {0, 1, 2});
    const Accel gas = buildAccel(context_, log_, {mesh.input});
    Buffer memory(sizeof(OptixSRTMotionTransform), 64),
        second(sizeof(OptixMatrixMotionTransform), 64);
    auto* srt = memory.as<OptixSRTMotionTransform>();
    srt->child = gas.handle;
    srt->motionOptions = {2, OPTIX_MOTION_FLAG_NONE, 0, 1};
    for (OptixSRTData& key : srt->srtData) {
        key.sx = key.sy = key.sz = 1;
        key.a = key.b = key.c = key.pvx = key.pvy = key.pvz = 0;
        key.qx = key.qy = key.qz = 0;
        key.qw = 1;
        key.tx = key.ty = key.tz = 0;
    }
    OptixTraversableHandle handle = 0;
    ASSERT_OK(optixConvertPointerToTraversableHandle(
        context_, memory.address(), OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM, &handle));
    auto* matrix = second.as<OptixMatrixMotionTransform>();
    matrix->child = handle;
    matrix->motionOptions = {2, 0, 0, 1};
    matrix->pad[0] = 0;
    const Matrix one = identity();
    for (float* key : {matrix->transform[0], matrix->transform[1]})
        std::copy(one.begin(), one.end(), key);
    ASSERT_OK(optixConvertPointerToTraversableHandle(
        context_, second.address(), OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM, &handle));
    MotionParams params{};
    params.dump = 1;
    testing::internal::CaptureStdout();
    const MotionSeen s = traceOne(handle, 0.5f, params);
    const std::string text = testing::internal::GetCapturedStdout();
    EXPECT_EQ(1u, s.hit);
    EXPECT_EQ(2u, s.motionKeys);
    EXPECT_NE(std::string::npos, text.find("matrix motion transform")) << text;
    EXPECT_NE(std::string::npos, text.find("SRT motion transform")) << text;
}

INSTANTIATE_DEVICE_TEST(MotionTest);

// ---- Arguments
// -----------------------------------------------------------------------------------

class MotionArguments : public ApiTest {
protected:
    OptixResult usage(const OptixBuildInput& input, const OptixMotionOptions& motion) {
        OptixAccelBuildOptions options = buildOptions();
        options.motionOptions = motion;
        return optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes_);
    }
    OptixResult build(const OptixBuildInput& input, const OptixMotionOptions& motion) {
        OptixAccelBuildOptions options = buildOptions();
        options.motionOptions = motion;
        Buffer temp(1 << 16), output(1 << 16);
        OptixTraversableHandle handle = 0;
        const OptixResult result =
            optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(), temp.size(),
                            output.address(), output.size(), &handle, nullptr, 0);
        waitForDevice();
        return result;
    }
    OptixAccelBufferSizes sizes_{};
};

TEST_F(MotionArguments, OptionsOfBuilds) {
    TriangleMesh mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    const CUdeviceptr keys[2] = {mesh.vertexAddress, mesh.vertexAddress};
    mesh.input.triangleArray.vertexBuffers = keys;
    const char* const kUsage = "optixAccelComputeMemoryUsage";
    for (unsigned short flags : {4, 8, 0x8000, 0xFFFF})
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "motionOptions.flags",
                        usage(mesh.input, {2, flags, 0, 1}));
    for (float bad : {NAN, INFINITY, -INFINITY}) {
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "timeBegin",
                        usage(mesh.input, {2, 0, bad, 1}));
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "timeEnd",
                        usage(mesh.input, {2, 0, 0, bad}));
    }
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "timeBegin",
                    usage(mesh.input, {2, 0, 1, 0.5f}));
    log_.clear();
    EXPECT_OK(usage(mesh.input, {2, OPTIX_MOTION_FLAG_NONE, 1, 1}));
    EXPECT_OK(usage(mesh.input, {0xFFFF, 3, -1, 1}));
    EXPECT_OK(build(mesh.input, {2, 3, -1, 1}));
}

TEST_F(MotionArguments, BuffersOfKeys) {
    TriangleMesh mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    CUdeviceptr keys[3] = {mesh.vertexAddress, 0, mesh.vertexAddress};
    mesh.input.triangleArray.vertexBuffers = keys;
    const OptixMotionOptions motion = {3, 0, 0, 1};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "vertexBuffers[1]",
                    build(mesh.input, motion));
    keys[1] = mesh.vertexAddress + 2;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "vertexBuffers[1]",
                    build(mesh.input, motion));
    keys[1] = mesh.vertexAddress;
    keys[2] = 0x1000;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "vertexBuffers[2]",
                    build(mesh.input, motion));
    mesh.input.triangleArray.vertexBuffers = nullptr;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "vertexBuffers",
                    build(mesh.input, motion));
    CustomBoxes boxes({{0, 0, 0, 1, 1, 1}});
    CUdeviceptr boxKeys[2] = {boxes.address, 0};
    boxes.input.customPrimitiveArray.aabbBuffers = boxKeys;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "aabbBuffers[1]",
                    build(boxes.input, {2, 0, 0, 1}));
    boxKeys[1] = boxes.address + 4;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "aabbBuffers[1]",
                    build(boxes.input, {2, 0, 0, 1}));
    boxKeys[1] = boxes.address;
    log_.clear();
    EXPECT_OK(build(boxes.input, {2, 0, 0, 1}));
}

TEST_F(MotionArguments, PrimitivesTimesKeysAreLimited) {
    unsigned limit = 0;
    ASSERT_OK(optixDeviceContextGetProperty(
        context_, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_PRIMITIVES_PER_GAS, &limit, sizeof(limit)));
    const unsigned flags[1] = {0};
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    input.customPrimitiveArray.numPrimitives = limit / 4 + 1;
    input.customPrimitiveArray.flags = flags;
    input.customPrimitiveArray.numSbtRecords = 1;
    EXPECT_OK(usage(input, {3, 0, 0, 1}));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelComputeMemoryUsage", "motion keys",
                    usage(input, {4, 0, 0, 1}));
}

TEST_F(MotionArguments, EmittedBoxesNeedRoomForAllKeys) {
    TriangleMesh mesh({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {0, 1, 2});
    const CUdeviceptr keys[2] = {mesh.vertexAddress, mesh.vertexAddress};
    mesh.input.triangleArray.vertexBuffers = keys;
    OptixAccelBuildOptions options = buildOptions();
    options.motionOptions = {2, 0, 0, 1};
    Buffer temp(1 << 16), output(1 << 16);
    OptixTraversableHandle handle = 0;
    const OptixAccelEmitDesc emit = {0x1000, OPTIX_PROPERTY_TYPE_AABBS};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "emittedProperties[0]",
                    optixAccelBuild(context_, nullptr, &options, &mesh.input, 1, temp.address(),
                                    temp.size(), output.address(), output.size(), &handle, &emit,
                                    1));
}

} // namespace
} // namespace tests::api
