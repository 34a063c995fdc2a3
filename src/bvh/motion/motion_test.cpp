// SPDX-License-Identifier: Apache-2.0
// Triangles with motion keys. The references are a structure without motion of the triangles at
// that time, whose hits must be equal bit for bit, and a loop over all triangles in double
// precision.
#include "base/error.h"
#include "bvh/layout.h"
#include "bvh/motion/motion.h"
#include "bvh/testing/meshes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace sunstone::bvh {
namespace {

using namespace testing;

std::vector<Isa> machineIsas() {
    std::vector<Isa> isas;
    for (Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512})
        if (isaSupported(isa))
            isas.push_back(isa);
    return isas;
}

// One mesh for each key, all with the same triangles.
struct MovingMesh {
    std::vector<Mesh> keys;
    std::vector<const void*> pointers;
    MotionOptions motion;

    explicit MovingMesh(std::vector<Mesh> meshes, float begin = 0, float end = 1)
        : keys(std::move(meshes)) {
        for (const Mesh& key : keys)
            pointers.push_back(key.vertices.data());
        motion = {uint32_t(keys.size()), 0, begin, end};
    }

    TriangleInput input() const {
        TriangleInput in = keys[0].input();
        in.keyVertices = pointers.data();
        return in;
    }
    BuildOptions options() const {
        BuildOptions o;
        o.motion = motion;
        return o;
    }
    Mesh at(float time, float (*interpolate)(float, float, float) = between) const {
        const KeySegment s = keySegment(motion.keys, motion.begin, motion.end, time);
        Mesh m = keys[s.key];
        for (size_t i = 0; i < m.vertices.size(); ++i)
            for (int a = 0; a < 3; ++a)
                m.vertices[i][a] =
                    interpolate(m.vertices[i][a], keys[s.key + 1].vertices[i][a], s.fraction);
        return m;
    }
};

MovingMesh randomMotion(uint32_t triangles, uint32_t keys, float size, float speed, uint32_t seed,
                        float begin = 0, float end = 1) {
    std::vector<Mesh> meshes = {soup(triangles, size, seed)};
    Random random(seed + 1);
    for (uint32_t k = 1; k < keys; ++k) {
        meshes.push_back(meshes.back());
        for (Vec3& v : meshes.back().vertices)
            v = v + random.point(speed);
    }
    return MovingMesh(std::move(meshes), begin, end);
}

QueryRay randomRay(Random& random, float extent) {
    const Vec3 o = random.point(extent);
    Vec3 d = random.below(3) ? random.point(1) - o : random.unit();
    switch (random.below(12)) {
    case 0:
        d = {0, 0, random.below(2) ? 1.0f : -1.0f};
        break;
    case 1:
        d = {random.below(2) ? 2.0f : -0.5f, 0, 0};
        break;
    case 2:
        d.y = 0;
        break;
    case 3:
        d = d * 1e-6f;
        break;
    case 4:
        d.x *= 1e-9f;
        break;
    }
    if (math::length(d) == 0)
        d = {0, 1, 0};
    return {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
}

// Compares the structure with one of the triangles at that time; returns the hits.
uint32_t compareAt(const Structure& moving, const MovingMesh& mesh, float time, uint32_t seed,
                   int rays, float extent = 2) {
    const Mesh still = mesh.at(time);
    const Structure judge = makeStructure(still.input());
    Random random(seed);
    uint32_t hits = 0, wrong = 0;
    for (int i = 0; i < rays; ++i) {
        const QueryRay ray = randomRay(random, extent);
        QueryHit expected{};
        const bool hit = kernels(Isa::kBaseline).closest(judge.block(), ray, expected);
        hits += hit;
        for (Isa isa : machineIsas()) {
            QueryHit found{};
            const bool other = kernels(isa).closestAt(moving.block(), ray, time, found);
            if (hit != other || expected.t != found.t || expected.u != found.u ||
                expected.v != found.v || expected.primitive != found.primitive ||
                expected.front != found.front ||
                kernels(isa).occludedAt(moving.block(), ray, time) != hit)
                ++wrong;
        }
    }
    EXPECT_EQ(wrong, 0u) << "time " << time << ", seed " << seed;
    return hits;
}

constexpr float kTimes[] = {0, 1, 0.5f, 0.25f, 1.0f / 3, 0.999999f, 1e-30f, 0.1f, 0.77f};

TEST(MotionTriangles, AreWhereTheyAreAtTheTime) {
    for (uint32_t keys : {2u, 3u, 7u})
        for (uint32_t count : {1u, 3u, 8u, 9u, 40u, 3000u}) {
            const MovingMesh mesh = randomMotion(count, keys, 0.1f, 0.3f, count + keys);
            for (bool fast : {false, true}) {
                BuildOptions options = mesh.options();
                options.preferFastBuild = fast;
                const TriangleInput in = mesh.input();
                const Structure s = makeStructure(in, options);
                uint32_t hits = 0;
                for (float time : kTimes)
                    hits += compareAt(s, mesh, time, keys, 500);
                EXPECT_TRUE(count != 3000 || hits > 1000);
            }
        }
}

// Distances to planes overflow on all axes; unused children must still be culled.
TEST(MotionTriangles, OriginsThatAreTooFarOff) {
    const MovingMesh mesh = randomMotion(83, 3, 0.5f, 0.3f, 9);
    const Structure s = makeStructure(mesh.input(), mesh.options());
    Random random(31);
    for (int i = 0; i < 4000; ++i) {
        const Vec3 d = random.unit();
        QueryRay ray = {{}, 0, {d.x, d.y, d.z}, random.below(2) ? INFINITY : 1e30f};
        for (float& o : ray.origin)
            o = random.below(4) == 0 ? 0.5f : random.below(2) ? 1e38f : -1e38f;
        ray.origin[random.below(3)] = 1e38f;
        const float time = kTimes[random.below(std::size(kTimes))];
        for (Isa isa : machineIsas()) {
            QueryHit hit{};
            EXPECT_FALSE(kernels(isa).closestAt(s.block(), ray, time, hit)) << i;
            EXPECT_FALSE(kernels(isa).occludedAt(s.block(), ray, time)) << i;
        }
    }
}

TEST(MotionTriangles, FarFromTheOriginAndFast) {
    for (const float offset : {1000.0f, 1e6f})
        for (const float speed : {0.001f, 50.0f}) {
            MovingMesh mesh = randomMotion(500, 3, 0.2f, speed, 77);
            for (Mesh& key : mesh.keys)
                for (Vec3& v : key.vertices)
                    v = v + Vec3{offset, -offset, offset * 0.5f};
            const TriangleInput in = mesh.input();
            const Structure s = makeStructure(in, mesh.options());
            for (const float time : {0.1f, 0.5f, 0.83f}) {
                const Mesh still = mesh.at(time);
                const Structure judge = makeStructure(still.input());
                Random random(5);
                uint32_t hits = 0;
                for (int i = 0; i < 1500; ++i) {
                    const Vec3 target = still.vertices[random.below(1500)];
                    const Vec3 o = target + random.point(3);
                    const Vec3 d = target + random.point(0.1f) - o;
                    const QueryRay ray = {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
                    QueryHit a{}, b{};
                    const bool hit = kernels(chosenIsa()).closest(judge.block(), ray, a);
                    ASSERT_EQ(hit, kernels(chosenIsa()).closestAt(s.block(), ray, time, b)) << i;
                    ASSERT_EQ(a.t, b.t);
                    ASSERT_EQ(a.primitive, b.primitive);
                    hits += hit;
                }
                EXPECT_GT(hits, 100u);
            }
        }
}

// All arithmetic, including the interpolation of vertices, is in double precision.
TEST(MotionTriangles, AgreeWithALoopOverAllInDoublePrecision) {
    const MovingMesh mesh = randomMotion(300, 4, 0.25f, 0.4f, 11, -2, 3);
    const TriangleInput in = mesh.input();
    const Structure s = makeStructure(in, mesh.options());
    Random random(12);
    uint32_t hits = 0;
    for (int i = 0; i < 4000; ++i) {
        const float time = random(-3, 4);
        const double place = std::clamp((double(time) + 2) / 5, 0.0, 1.0) * 3;
        const uint32_t key = std::min(uint32_t(place), 2u);
        const QueryRay ray = randomRay(random, 2);
        double nearest = INFINITY;
        bool doubtful = false;
        for (uint32_t t = 0; t < 300; ++t) {
            Vec3 v[3];
            for (int c = 0; c < 3; ++c)
                for (int a = 0; a < 3; ++a) {
                    const uint32_t index = 3 * t + uint32_t(c);
                    const double from = mesh.keys[key].vertices[index][a];
                    const double to = mesh.keys[key + 1].vertices[index][a];
                    v[c][a] = float(from + (to - from) * (place - key));
                }
            const ExactHit e = exactHit(ray, v);
            if (e.t < 0 || e.margin < -1e-4)
                continue;
            doubtful = doubtful || e.margin < 1e-4;
            nearest = std::min(nearest, e.t);
        }
        QueryHit hit{};
        const bool found = kernels(chosenIsa()).closestAt(s.block(), ray, time, hit);
        if (doubtful)
            continue;
        ASSERT_EQ(found, nearest < INFINITY) << i << " time " << time;
        if (found) {
            EXPECT_NEAR(hit.t / nearest, 1, 1e-3) << i;
        }
        hits += found;
    }
    EXPECT_GT(hits, 500u);
}

TEST(MotionTriangles, StandStillOutsideTheRangeOrVanish) {
    MovingMesh mesh = randomMotion(400, 3, 0.2f, 0.5f, 3, 10, 12);
    const TriangleInput in = mesh.input();
    for (uint32_t flags = 0; flags < 4; ++flags) {
        mesh.motion.flags = flags;
        const Structure s = makeStructure(in, mesh.options());
        EXPECT_GT(compareAt(s, mesh, 10, 1, 500), 50u); // the ends belong to the range
        EXPECT_GT(compareAt(s, mesh, 12, 1, 500), 50u);
        for (float time : {9.99f, -1e30f, 12.01f, INFINITY, -INFINITY}) {
            const bool gone = time < 10 ? flags & kStartVanish : flags & kEndVanish;
            if (!gone) {
                EXPECT_GT(compareAt(s, mesh, time, 2, 500), 50u);
                continue;
            }
            Random random(2);
            for (int i = 0; i < 200; ++i) {
                const QueryRay ray = randomRay(random, 2);
                QueryHit hit;
                EXPECT_FALSE(kernels(chosenIsa()).closestAt(s.block(), ray, time, hit));
                EXPECT_FALSE(kernels(chosenIsa()).occludedAt(s.block(), ray, time));
            }
        }
    }
}

TEST(MotionTriangles, EmptyRangesAndNoTimes) {
    MovingMesh mesh = randomMotion(400, 3, 0.2f, 0.5f, 4, 5, 5);
    const TriangleInput in = mesh.input();
    const Structure s = makeStructure(in, mesh.options());
    for (float time : {5.0f, 4.0f, -INFINITY, NAN, 5.1f, INFINITY}) {
        const KeySegment at = keySegment(3, 5, 5, time);
        EXPECT_EQ(at.key + at.fraction, time > 5 ? 2 : 0) << time;
        EXPECT_GT(compareAt(s, mesh, time, 2, 500), 50u);
    }
}

TEST(MotionTriangles, InactiveOnesAreLeftOut) {
    MovingMesh mesh = randomMotion(900, 3, 0.2f, 0.2f, 8);
    for (uint32_t i = 0; i < 900; ++i) {
        if (i % 3 == 0) // unusable at one key
            mesh.keys[i / 3 % 3].vertices[3 * i].y = i % 2 ? NAN : INFINITY;
        if (i % 3 == 1) // without area at the first two keys, but not at the third
            for (int k = 0; k < 2; ++k)
                mesh.keys[size_t(k)].vertices[3 * i] = mesh.keys[size_t(k)].vertices[3 * i + 1];
    }
    const TriangleInput in = mesh.input();
    for (bool allowUpdate : {false, true}) {
        BuildOptions options = mesh.options();
        options.allowUpdate = allowUpdate;
        options.allowRandomVertexAccess = true;
        const Structure s = makeStructure(in, options);
        EXPECT_EQ(headerOf(s.block())->numActive, 600u);
        MovingMesh good = mesh;
        for (Mesh& key : good.keys)
            for (uint32_t i = 0; i < 900; i += 3)
                key.vertices[3 * i] = {NAN, NAN, NAN};
        for (float time : {0.0f, 0.3f, 0.5f, 0.9f})
            EXPECT_GT(compareAt(s, good, time, 2, 800), 50u);
        float v[9];
        ASSERT_TRUE(triangleVertices(s.block(), 0, 0, v, 0.5f));
        EXPECT_TRUE(std::isnan(v[0]));
        ASSERT_TRUE(triangleVertices(s.block(), 2, 0, v, 0.5f));
        EXPECT_FALSE(std::isnan(v[0]));
    }
}

TEST(MotionTriangles, ThatHaveAnAreaOnlyOnTheWayCanBeHit) {
    // Corners exchange places: a line at both keys, a triangle between them.
    Mesh first;
    first.vertices = {{-1, 0, 0}, {1, 0, 0}, {0, 0, 0}};
    first.triangles = {{0, 1, 2}};
    Mesh second = first;
    second.vertices = {{0, -2, 0}, {0, 2, 0}, {0, 1, 0}};
    const MovingMesh mesh({first, second});
    const TriangleInput in = mesh.input();
    const Structure s = makeStructure(in, mesh.options());
    EXPECT_EQ(headerOf(s.block())->numActive, 1u);
    const Mesh half = mesh.at(0.5f);
    const Vec3 c = (half.vertices[0] + half.vertices[1] + half.vertices[2]) * (1.0f / 3);
    const QueryRay ray = {{c.x, c.y, 5}, 0, {0, 0, -1}, 100};
    QueryHit hit;
    EXPECT_TRUE(kernels(chosenIsa()).closestAt(s.block(), ray, 0.5f, hit));
    EXPECT_FALSE(kernels(chosenIsa()).closestAt(s.block(), ray, 0.0f, hit));
}

TEST(MotionTriangles, KernelsWithoutTimeRefuseThem) {
    const MovingMesh mesh = randomMotion(20, 2, 0.5f, 0.1f, 1);
    const TriangleInput in = mesh.input(), plain = mesh.keys[0].input();
    const Structure moving = makeStructure(in, mesh.options()), still = makeStructure(plain);
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        const QueryRay ray = randomRay(random, 2);
        QueryHit hit;
        for (Isa isa : machineIsas()) {
            EXPECT_FALSE(kernels(isa).closest(moving.block(), ray, hit));
            EXPECT_FALSE(kernels(isa).closestAt(still.block(), ray, 0, hit));
        }
    }
}

void updateNow(const Structure& s, const TriangleInput& in, const BuildOptions& options) {
    BuildInputs inputs;
    inputs.triangles = {&in, 1};
    const MemoryUsage usage = computeMemoryUsage(inputs, options);
    const auto temp = alignedBuffer(usage.tempUpdate);
    update(inputs, options, temp.get(), usage.tempUpdate, s.memory.get(), s.size);
}

TEST(MotionTriangles, UpdatesFollow) {
    for (uint32_t count : {1u, 8u, 2000u}) {
        MovingMesh mesh = randomMotion(count, 3, 0.1f, 0.2f, count);
        BuildOptions options = mesh.options();
        options.allowUpdate = true;
        const TriangleInput in = mesh.input();
        const Structure s = makeStructure(in, options), before = makeStructure(in, options);
        ASSERT_TRUE(s == before);
        updateNow(s, in, options);
        EXPECT_TRUE(s == before) << count; // without movement: the same bytes
        Random random(count);
        for (Mesh& key : mesh.keys)
            for (Vec3& v : key.vertices)
                v = Vec3{v.y, v.z * 1.5f, v.x} + random.point(0.05f);
        if (count > 1)
            mesh.keys[1].vertices[0].x = NAN; // becomes inactive
        updateNow(s, in, options);
        MovingMesh judge = mesh;
        if (count > 1)
            for (Mesh& key : judge.keys)
                key.vertices[0].x = NAN;
        for (float time : kTimes)
            compareAt(s, judge, time, count, 400);
        const Structure fresh = makeStructure(in, options);
        for (uint32_t key = 0; key < 3; ++key) {
            const Box a = boundsAtKey(s.block(), key), b = boundsAtKey(fresh.block(), key);
            for (int i = 0; i < 3; ++i) {
                EXPECT_EQ(a.lower[i], b.lower[i]);
                EXPECT_EQ(a.upper[i], b.upper[i]);
            }
        }
    }
}

TEST(MotionTriangles, UpdatesMustHaveTheSameKeysAndRange) {
    const MovingMesh mesh = randomMotion(10, 3, 0.1f, 0.2f, 1);
    BuildOptions options = mesh.options();
    options.allowUpdate = true;
    const TriangleInput in = mesh.input();
    const Structure s = makeStructure(in, options);
    const MotionOptions others[] = {
        {1, 0, 0, 1}, {2, 0, 0, 1}, {3, 1, 0, 1}, {3, 0, 0, 2}, {3, 0, -1, 1}};
    for (const MotionOptions& other : others) {
        BuildOptions wrong = options;
        wrong.motion = other;
        EXPECT_THROW(updateNow(s, in, wrong), Error) << other.keys;
    }
    EXPECT_NO_THROW(updateNow(s, in, options));
}

TEST(MotionTriangles, BoundsAtEachKey) {
    const MovingMesh mesh = randomMotion(50, 4, 0.1f, 2.0f, 9, -1, 2);
    const TriangleInput in = mesh.input();
    const Structure s = makeStructure(in, mesh.options());
    Box all;
    for (uint32_t key = 0; key < 4; ++key) {
        Box expected;
        for (const Vec3& v : mesh.keys[key].vertices)
            expected.extend(v);
        all.extend(expected);
        const Box found = boundsAtKey(s.block(), key);
        for (int a = 0; a < 3; ++a) {
            EXPECT_EQ(found.lower[a], expected.lower[a]) << key;
            EXPECT_EQ(found.upper[a], expected.upper[a]) << key;
        }
    }
    const Box whole = bounds(s.block());
    for (int a = 0; a < 3; ++a) {
        EXPECT_EQ(whole.lower[a], all.lower[a]);
        EXPECT_EQ(whole.upper[a], all.upper[a]);
    }
    const MotionOptions motion = motionOf(s.block());
    EXPECT_EQ(motion.keys, 4u);
    EXPECT_EQ(motion.begin, -1);
    EXPECT_EQ(motion.end, 2);
}

TEST(MotionTriangles, VerticesAtATime) {
    const MovingMesh mesh = randomMotion(100, 3, 0.1f, 1.0f, 6, 0, 2);
    TriangleInput in = mesh.input();
    in.sbt.primitiveIndexOffset = 50;
    BuildOptions options = mesh.options();
    options.allowRandomVertexAccess = true;
    const Structure s = makeStructure(in, options);
    for (float time : {-1.0f, 0.0f, 0.4f, 1.0f, 1.7f, 2.0f, 9.0f}) {
        const Mesh still = mesh.at(time, vertexBetween);
        for (uint32_t i = 0; i < 100; ++i) {
            float v[9];
            ASSERT_TRUE(triangleVertices(s.block(), 50 + i, 0, v, time));
            for (uint32_t k = 0; k < 9; ++k)
                EXPECT_EQ(v[k], still.vertices[3 * i + k / 3][int(k % 3)]);
        }
    }
}

TEST(MotionTriangles, TheBlockDoesNotDependOnThreads) {
    const MovingMesh mesh = randomMotion(20000, 2, 0.02f, 0.05f, 21);
    const TriangleInput in = mesh.input();
    Structure one;
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        one = makeStructure(in, mesh.options());
    }
    EXPECT_TRUE(one == makeStructure(in, mesh.options()));
}

TEST(MotionTriangles, NothingAtAll) {
    const MovingMesh mesh = randomMotion(0, 2, 1, 1, 1);
    const TriangleInput in = mesh.input();
    const Structure s = makeStructure(in, mesh.options());
    EXPECT_TRUE(bounds(s.block()).empty());
    EXPECT_TRUE(boundsAtKey(s.block(), 1).empty());
    QueryHit hit;
    EXPECT_FALSE(kernels(chosenIsa()).closestAt(s.block(), {{}, 0, {1, 0, 0}, 9}, 0.5f, hit));
}

} // namespace
} // namespace sunstone::bvh
