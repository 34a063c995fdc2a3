// SPDX-License-Identifier: Apache-2.0
// Rays against a reference that tests every triangle in double precision; instruction sets against
// each other; degenerate rays.
#include "bvh/testing/meshes.h"

#include <gtest/gtest.h>
#include <xmmintrin.h>

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

QueryRay rayFrom(Vec3 o, Vec3 d, float tmin = 0, float tmax = 1e30f) {
    return {{o.x, o.y, o.z}, tmin, {d.x, d.y, d.z}, tmax};
}

// Rays of many sorts around the unit cube.
QueryRay randomRay(Random& random) {
    Vec3 o = random.point(random.below(2) ? 1.0f : 4.0f);
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
        d = d * 1e6f;
        break;
    case 5:
        d.x *= 1e-9f;
        break;
    }
    if (math::length(d) == 0)
        d = {0, 1, 0};
    QueryRay ray = rayFrom(o, d);
    if (random.below(4) == 0) {
        const float scale = 1 / math::length(d);
        ray.tmin = random(0, 1) * scale;
        ray.tmax = ray.tmin + random(0, 2) * scale;
    }
    return ray;
}

struct Judgement {
    uint32_t hits = 0, wrong = 0;
    std::string first;
};

// Clear hits must be found, clear misses must not be reported, and t, u, v must fit.
void judge(const Mesh& mesh, const QueryRay& ray, bool found, const QueryHit& hit, Judgement& j) {
    constexpr double kEdge = 1e-4;
    const auto corners = [&](uint32_t i, Vec3 v[3]) {
        for (int k = 0; k < 3; ++k)
            v[k] = mesh.vertices[mesh.triangles[i][size_t(k)]];
    };
    double nearest = INFINITY;
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        Vec3 v[3];
        corners(i, v);
        const ExactHit e = exactHit(ray, v);
        if (e.margin > kEdge && e.t > ray.tmin * (1 + 1e-5) && e.t < ray.tmax * (1 - 1e-5))
            nearest = std::min(nearest, e.t);
    }
    const auto complain = [&](const std::string& what) {
        if (j.wrong++ == 0)
            j.first = what + ": t " + std::to_string(hit.t) + " nearest " + std::to_string(nearest);
    };
    const float scale = 1 / math::length({ray.direction[0], ray.direction[1], ray.direction[2]});
    const double slack = 2e-4 * scale;
    if (!found) {
        if (nearest < INFINITY)
            complain("missed");
        return;
    }
    ++j.hits;
    if (hit.primitive >= mesh.triangles.size())
        return complain("primitive out of range");
    Vec3 v[3];
    corners(hit.primitive, v);
    const ExactHit e = exactHit(ray, v);
    // Grazing hits are ill-conditioned: judge the reported point instead of t.
    Vec3 byRay, byTriangle;
    double off = 0;
    for (int a = 0; a < 3; ++a) {
        byRay[a] = ray.origin[a] + hit.t * ray.direction[a];
        byTriangle[a] = (1 - hit.u - hit.v) * v[0][a] + hit.u * v[1][a] + hit.v * v[2][a];
        off = std::max(off, double(std::fabs(byRay[a] - byTriangle[a])));
    }
    if (off > 1e-3)
        complain("u, v and t tell different points");
    if (hit.u < -1e-6f || hit.v < -1e-6f || hit.u + hit.v > 1 + 1e-6f)
        complain("outside by its own coordinates");
    if (e.margin < -kEdge && std::isfinite(e.margin) && std::fabs(e.t - hit.t) > slack)
        complain("outside");
    if (hit.t > nearest + slack)
        complain("a nearer triangle was overlooked");
    if (hit.t < ray.tmin || hit.t > ray.tmax)
        complain("outside the interval");
}

void judgeMesh(const Mesh& mesh, uint32_t rays, const BuildOptions& options, uint32_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Structure s = makeStructure(mesh.input(), options);
    Random random(seed);
    Judgement judgement;
    for (uint32_t i = 0; i < rays; ++i) {
        const QueryRay ray = randomRay(random);
        QueryHit reference{};
        bool referenceFound = false;
        for (Isa isa : machineIsas()) {
            QueryHit hit{};
            const bool found = kernels(isa).closest(s.block(), ray, hit);
            EXPECT_EQ(kernels(isa).occluded(s.block(), ray), found) << isaName(isa);
            if (isa == Isa::kBaseline) {
                judge(mesh, ray, found, hit, judgement);
                reference = hit;
                referenceFound = found;
                continue;
            }
            ASSERT_EQ(found, referenceFound) << isaName(isa);
            EXPECT_EQ(hit.t, reference.t) << isaName(isa);
            EXPECT_EQ(hit.u, reference.u) << isaName(isa);
            EXPECT_EQ(hit.v, reference.v) << isaName(isa);
            EXPECT_EQ(hit.primitive, reference.primitive) << isaName(isa);
        }
    }
    EXPECT_EQ(judgement.wrong, 0u) << judgement.first;
    EXPECT_GT(judgement.hits, rays / 50);
}

TEST(Traverse, SoupsAgreeWithTheJudge) {
    for (uint32_t count : {1u, 2u, 3u, 4u, 5u, 8u, 9u, 17u, 100u, 1500u})
        judgeMesh(soup(count, count < 20 ? 1.0f : 0.2f, count), 1500, {}, 100 + count);
}

TEST(Traverse, FastBuildsAgreeWithTheJudge) {
    BuildOptions options;
    options.preferFastBuild = true;
    for (uint32_t count : {1u, 4u, 5u, 6u, 9u, 64u, 1500u})
        judgeMesh(soup(count, count < 20 ? 1.0f : 0.2f, count), 1500, options, 200 + count);
}

TEST(Traverse, ClosedMeshesAgreeWithTheJudge) {
    judgeMesh(icosphere(3), 1500, {}, 1);
    judgeMesh(torus(30, 20), 1500, {}, 2);
    judgeMesh(cube(), 3000, {}, 3);
    judgeMesh(roughSphere(3, 5), 1500, {}, 4);
}

TEST(Traverse, LongThinTrianglesAgreeWithTheJudge) {
    Random random(31);
    Mesh m;
    for (uint32_t i = 0; i < 1500; ++i) {
        const Vec3 center = random.point(1), along = random.unit() * 0.4f;
        m.vertices.insert(m.vertices.end(),
                          {center - along, center + along, center + random.unit() * 0.02f});
        m.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    judgeMesh(m, 3000, {}, 32);
}

TEST(Traverse, FrontIsCounterClockwise) {
    Mesh m;
    m.vertices = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    m.triangles = {{0, 1, 2}};
    const Structure s = makeStructure(m.input());
    for (Isa isa : machineIsas()) {
        QueryHit hit{};
        // From +z the vertices run counter-clockwise.
        ASSERT_TRUE(kernels(isa).closest(s.block(), rayFrom({0, 0, 2}, {0, 0, -1}), hit));
        EXPECT_TRUE(hit.front);
        EXPECT_FLOAT_EQ(hit.t, 2);
        EXPECT_FLOAT_EQ(hit.v, 0.5f);
        EXPECT_FLOAT_EQ(hit.u, 0.25f);
        ASSERT_TRUE(kernels(isa).closest(s.block(), rayFrom({0, 0, -2}, {0, 0, 1}), hit));
        EXPECT_FALSE(hit.front);
        ASSERT_TRUE(kernels(isa).closest(s.block(), rayFrom({0, 0, 2}, {0.01f, 0.02f, -1}), hit));
        EXPECT_TRUE(hit.front);
    }
}

TEST(Traverse, IntervalIsClosed) {
    Mesh m;
    m.vertices = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    m.triangles = {{0, 1, 2}};
    const Structure s = makeStructure(m.input());
    for (Isa isa : machineIsas()) {
        const Kernels& k = kernels(isa);
        EXPECT_TRUE(k.occluded(s.block(), rayFrom({0, 0, 2}, {0, 0, -1}, 2, 2)));
        EXPECT_TRUE(k.occluded(s.block(), rayFrom({0, 0, 2}, {0, 0, -1}, 0, 2)));
        EXPECT_TRUE(k.occluded(s.block(), rayFrom({0, 0, 2}, {0, 0, -1}, 2, 3)));
        EXPECT_FALSE(k.occluded(s.block(), rayFrom({0, 0, 2}, {0, 0, -1}, 0, 1.999f)));
        EXPECT_FALSE(k.occluded(s.block(), rayFrom({0, 0, 2}, {0, 0, -1}, 2.001f, 3)));
        EXPECT_TRUE(k.occluded(s.block(), rayFrom({0, 0, 2}, {0, 0, -1}, 0, INFINITY)));
        EXPECT_TRUE(k.occluded(s.block(), rayFrom({0, 0, 0}, {0, 0, -1}, 0, 1)));
    }
}

TEST(Traverse, RaysThatAreNoneMiss) {
    const Structure s = makeStructure(soup(500, 0.3f, 9).input());
    const float nan = NAN, inf = INFINITY;
    const QueryRay rays[] = {
        rayFrom({nan, 0, 0}, {0, 0, 1}),       rayFrom({0, 0, 0}, {0, nan, 1}),
        rayFrom({0, 0, 0}, {0, 0, 0}),         rayFrom({inf, 0, 0}, {0, 0, 1}),
        rayFrom({0, 0, 0}, {0, 0, inf}),       rayFrom({0, 0, 0}, {0, 0, 1}, nan, 1),
        rayFrom({0, 0, 0}, {0, 0, 1}, 0, nan), rayFrom({0, 0, 0}, {0, 0, 1}, 2, 1),
        rayFrom({0, 0, 0}, {0, 0, 1}, inf, inf), rayFrom({-inf, inf, 0}, {0, 0, -inf}),
        rayFrom({1e38f, 1e38f, 0}, {1, 1, 1}), rayFrom({0, 0, 0}, {1e-42f, 0, 0}),
        rayFrom({0, 0, 0}, {0, 0, 1}, -inf, -1),
    };
    for (Isa isa : machineIsas())
        for (const QueryRay& ray : rays) {
            QueryHit hit{};
            EXPECT_FALSE(kernels(isa).closest(s.block(), ray, hit));
            EXPECT_FALSE(kernels(isa).occluded(s.block(), ray));
        }
}

// Origins so far away, relative to the direction, that distances to the planes of boxes overflow.
// All axes must still cull the unused children of a node.
TEST(Traverse, OriginsThatAreTooFarOff) {
    const Structure s = makeStructure(soup(83, 0.5f, 9).input());
    const float places[] = {0.5f, 1e38f, -1e38f, 3e37f};
    Random random(31);
    for (int i = 0; i < 4000; ++i) {
        Vec3 o, d = random.unit();
        for (int axis = 0; axis < 3; ++axis) {
            o[axis] = places[random.below(4)];
            if (random.below(8) == 0)
                d[axis] = random.below(2) ? 0.0f : 1e-9f;
        }
        o[int(random.below(3))] = places[1 + random.below(2)];
        const QueryRay ray = rayFrom(o, d, 0, random.below(2) ? INFINITY : 1e30f);
        for (Isa isa : machineIsas()) {
            QueryHit hit{};
            EXPECT_FALSE(kernels(isa).closest(s.block(), ray, hit)) << i;
            EXPECT_FALSE(kernels(isa).occluded(s.block(), ray)) << i;
        }
    }
}

// Distances to planes through zero overflow, those to the sphere do not.
TEST(Traverse, OverflowLosesNoHits) {
    Mesh m = icosphere(2);
    const Vec3 center = {0x1p50f, 0x1p50f, -0x1p50f};
    for (Vec3& v : m.vertices)
        v = v * 0x1p44f + center;
    const Structure s = makeStructure(m.input());
    Random random(18);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 o = center + random.unit() * 0x1p45f;
        const Vec3 d = (center + random.unit() * 0x1p43f - o) * 0x1p-125f;
        for (Isa isa : machineIsas())
            EXPECT_TRUE(kernels(isa).occluded(s.block(), rayFrom(o, d, 0, INFINITY))) << i;
    }
}

// The reciprocals of directions this long are subnormal, or 0 on threads that flush those.
TEST(Traverse, LongDirections) {
    const Structure s = makeStructure(soup(83, 0.5f, 9).input());
    const Structure sphere = makeStructure(icosphere(2).input());
    const unsigned mode = _mm_getcsr();
    Random random(19);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 o = random.unit() * 3.0f;
        const Vec3 d = (random.unit() * 0.5f - o) * (1e37f * random(0.1f, 5));
        for (Isa isa : machineIsas()) {
            EXPECT_TRUE(kernels(isa).occluded(sphere.block(), rayFrom(o, d))) << i;
            _mm_setcsr(mode | 0x8040); // flush to zero, and subnormals are zeros
            QueryHit hit{};
            kernels(isa).closest(s.block(), rayFrom(o, d), hit);
            _mm_setcsr(mode);
        }
    }
}

TEST(Traverse, FarAwayAndHugeScenes) {
    for (float scale : {1e-12f, 1e-4f, 1e4f, 1e12f}) {
        Mesh m = icosphere(2);
        for (Vec3& v : m.vertices)
            v = v * scale;
        const Structure s = makeStructure(m.input());
        Random random(17);
        for (int i = 0; i < 2000; ++i) {
            const Vec3 o = random.unit() * (3 * scale);
            const Vec3 d = random.unit() * (0.9f * scale) - o;
            for (Isa isa : machineIsas())
                EXPECT_TRUE(kernels(isa).occluded(s.block(), rayFrom(o, d))) << scale;
        }
    }
}

} // namespace
} // namespace sunstone::bvh
