// SPDX-License-Identifier: Apache-2.0
// Random triangles and random rays through every traversal rule, against the brute force of
// scene.h: masks, face culling, any-hit flags, interval, record index, instances.
#include "device/probe.h"
#include "rig.h"
#include "scene.h"

#include <cmath>

namespace tests::api {
namespace {

constexpr unsigned kRecords = 24; // hit records; record i holds the value 1000 + i

class Traversal : public DeviceTest {
protected:
    // Triangles of moderate size in the box [-1, 1]^3.
    static std::unique_ptr<TriangleMesh> randomMesh(std::mt19937& random, unsigned count,
                                                    std::vector<unsigned> flags, float size = 0.7f) {
        std::uniform_real_distribution<float> unit(-1, 1);
        std::vector<Vec3> vertices;
        std::vector<uint32_t> indices, sbt;
        for (unsigned i = 0; i < count; ++i) {
            Vec3 center{unit(random), unit(random), unit(random)};
            for (unsigned k = 0; k < 3; ++k) {
                indices.push_back(uint32_t(vertices.size()));
                vertices.push_back({center.x + size * unit(random), center.y + size * unit(random),
                                    center.z + size * unit(random)});
            }
            sbt.push_back(uint32_t(random() % flags.size()));
        }
        bool several = flags.size() > 1;
        auto mesh = std::make_unique<TriangleMesh>(vertices, indices, std::move(flags));
        if (several)
            mesh->setSbtIndices(sbt);
        return mesh;
    }

    static std::vector<Ray> randomRays(std::mt19937& random, size_t count, float spread) {
        std::uniform_real_distribution<float> unit(-1, 1);
        std::vector<Ray> rays(count);
        for (Ray& ray : rays) {
            ray.origin = {spread * unit(random), spread * unit(random), spread * unit(random)};
            Vec3 target{unit(random), unit(random), unit(random)};
            ray.direction = {target.x - ray.origin.x, target.y - ray.origin.y,
                             target.z - ray.origin.z};
            if (random() % 3 == 0)
                ray.tmin = 0.3f * std::abs(unit(random));
            if (random() % 3 == 0)
                ray.tmax = ray.tmin + 1.5f * std::abs(unit(random));
        }
        return rays;
    }

    void makeRig(const std::vector<unsigned>& rules) {
        rig_ = rig("probe", compileOptions(4));
        rig_->raygenRecord(rig_->raygen("__raygen__probe"));
        rig_->missRecord(rig_->miss("__miss__probe"), ProbeData{1, 0, nullptr, 0, 0});
        rig_->missRecord(rig_->miss("__miss__probe"), ProbeData{2, 0, nullptr, 0, 0});
        size_t hit = rig_->hit("__closesthit__probe", "__anyhit__probe");
        for (unsigned i = 0; i < kRecords; ++i)
            rig_->hitRecord(hit, ProbeData{1000 + i, rules[i % rules.size()], nullptr, 0, 0});
        rig_->link();
        rules_ = rules;
    }

    struct Query {
        Ray ray;
        unsigned sbtOffset = 0, sbtStride = 1, missIndex = 0;
    };

    std::vector<ProbeResult> trace(const std::vector<Query>& queries, OptixTraversableHandle handle) {
        std::vector<ProbeRay> rays;
        for (const Query& q : queries) {
            ProbeRay ray{};
            std::memcpy(ray.origin, &q.ray.origin, 12);
            std::memcpy(ray.direction, &q.ray.direction, 12);
            ray.tmin = q.ray.tmin;
            ray.tmax = q.ray.tmax;
            ray.mask = q.ray.mask;
            ray.flags = q.ray.flags;
            ray.sbtOffset = q.sbtOffset;
            ray.sbtStride = q.sbtStride;
            ray.missIndex = q.missIndex;
            ray.handle = handle;
            rays.push_back(ray);
        }
        Buffer in(rays);
        Buffer out(rays.size() * sizeof(ProbeResult));
        ProbeParams params{in.as<ProbeRay>(), out.as<ProbeResult>()};
        rig_->run(params, unsigned(rays.size()));
        return std::vector<ProbeResult>(out.as<ProbeResult>(),
                                        out.as<ProbeResult>() + rays.size());
    }

    // The action of the any-hit program of a crossing's record.
    bool accepts(const Crossing& c, const Query& q, const ReferenceInstance& instance) const {
        if (!c.anyHitEnabled)
            return true;
        unsigned index =
            instance.instance.sbtOffset + c.sbtGasIndex * (q.sbtStride & 255) + q.sbtOffset;
        if (index >= kRecords)
            return true; // no program
        unsigned rule = rules_[index % rules_.size()];
        return !(rule == kProbeIgnore || (rule == kProbeIgnoreOdd && c.primitive % 2 == 1));
    }

    // Compares each result with the reference; returns how many rays were unambiguous hits.
    size_t compare(const std::vector<ReferenceInstance>& scene, const std::vector<Query>& queries,
                   const std::vector<ProbeResult>& results) {
        size_t hits = 0, judged = 0;
        for (size_t i = 0; i < queries.size(); ++i) {
            bool ambiguous = false;
            std::vector<Crossing> all = crossings(scene, queries[i].ray, ambiguous);
            if (ambiguous)
                continue;
            ++judged;
            SCOPED_TRACE("ray " + std::to_string(i) + ", flags " +
                         std::to_string(queries[i].ray.flags));
            std::vector<Crossing> accepted;
            for (const Crossing& c : all)
                if (accepts(c, queries[i], scene[c.instance]))
                    accepted.push_back(c);
            hits += !accepted.empty();
            judge(scene, queries[i], all, accepted, results[i], unsigned(i));
            if (HasFailure())
                return hits; // one ray suffices
        }
        EXPECT_GT(judged, queries.size() / 2);
        return hits;
    }

    void judge(const std::vector<ReferenceInstance>& scene, const Query& q,
               const std::vector<Crossing>& all, const std::vector<Crossing>& accepted,
               const ProbeResult& r, unsigned launchIndex) {
        bool closestHitRuns = !(q.ray.flags & OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT);
        if (accepted.empty()) {
            EXPECT_EQ(0u, r.closestHits);
            ASSERT_EQ(1u, r.misses);
            EXPECT_EQ(401u, r.payload[3]);
            EXPECT_EQ(300u, r.payload[2]);
            EXPECT_EQ(1 + q.missIndex, r.miss.sbtValue);
            EXPECT_EQ(q.ray.tmax, r.miss.tmax) << "a miss program sees the tmax of the trace";
            judgeRay(q, r.miss, launchIndex);
            return;
        }
        ASSERT_EQ(0u, r.misses);
        EXPECT_EQ(400u, r.payload[3]);
        judgeAnyHits(scene, q, all, r, launchIndex);
        bool first = q.ray.flags & OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT;
        // A group beyond the records has no closest-hit program either.
        const Crossing* hit = &accepted[0];
        if (first && r.closestHits == 1) {
            hit = nullptr;
            for (const Crossing& c : accepted)
                if (std::abs(c.t - r.closestHit.tmax) < 1e-4)
                    hit = &c;
            ASSERT_NE(nullptr, hit) << "an accepted hit is reported";
        }
        if (first && r.closestHits == 0)
            return;
        unsigned record = scene[hit->instance].instance.sbtOffset +
                          hit->sbtGasIndex * (q.sbtStride & 255) + q.sbtOffset;
        if (!closestHitRuns || record >= kRecords) {
            EXPECT_EQ(0u, r.closestHits);
            EXPECT_EQ(300u, r.payload[2]);
            return;
        }
        ASSERT_EQ(1u, r.closestHits);
        EXPECT_EQ(301u, r.payload[2]);
        EXPECT_EQ(200 + r.anyHits, r.payload[1]) << "each any-hit call counted in the payload";
        judgeHit(scene, *hit, r.closestHit, record);
        judgeRay(q, r.closestHit, launchIndex);
        EXPECT_NEAR(hit->t, r.closestHit.tmax, 1e-4 * (1 + hit->t));
    }

    void judgeRay(const Query& q, const ProbeSeen& s, unsigned launchIndex) {
        EXPECT_EQ(q.ray.tmin, s.tmin);
        EXPECT_EQ(0.0f, s.time);
        EXPECT_EQ(q.ray.flags, s.rayFlags);
        EXPECT_EQ(q.ray.mask, s.mask);
        EXPECT_EQ(0, std::memcmp(&q.ray.origin, s.worldOrigin, 12));
        EXPECT_EQ(0, std::memcmp(&q.ray.direction, s.worldDirection, 12));
        EXPECT_EQ(launchIndex, s.launchIndex);
    }

    void judgeHit(const std::vector<ReferenceInstance>& scene, const Crossing& c,
                  const ProbeSeen& s, unsigned record) {
        EXPECT_EQ(c.primitive, s.primitive);
        EXPECT_EQ(c.sbtGasIndex, s.sbtGasIndex);
        EXPECT_EQ(1000 + record, s.sbtValue);
        EXPECT_EQ(c.back ? 0xFFu : 0xFEu, s.hitKind);
        EXPECT_EQ(unsigned(OPTIX_PRIMITIVE_TYPE_TRIANGLE), s.primitiveType);
        EXPECT_EQ(1u, s.isTriangle);
        EXPECT_EQ(c.back ? 0u : 1u, s.isFront);
        EXPECT_EQ(c.back ? 1u : 0u, s.isBack);
        EXPECT_EQ(c.back ? 0u : 1u, s.isTriangleFront);
        EXPECT_EQ(c.back ? 1u : 0u, s.isTriangleBack);
        EXPECT_NEAR(c.u, s.barycentrics[0], 2e-3);
        EXPECT_NEAR(c.v, s.barycentrics[1], 2e-3);
        EXPECT_EQ(0, std::memcmp(s.attributes, s.barycentrics, 8));
        const OptixInstance& instance = scene[c.instance].instance;
        EXPECT_EQ(instance.instanceId, s.instanceId);
        if (instance.traversableHandle == 0) {
            EXPECT_EQ(0u, s.transformCount);
            EXPECT_EQ(0u, s.instanceIndex);
            EXPECT_EQ(~0u, s.instanceId);
        } else {
            EXPECT_EQ(c.instance, s.instanceIndex);
            judgeInstance(instance, s);
        }
    }

    static void expectNear(const float* a, const float* b, size_t count, float tolerance) {
        for (size_t i = 0; i < count; ++i)
            EXPECT_NEAR(a[i], b[i], tolerance) << i;
    }

    void judgeInstance(const OptixInstance& instance, const ProbeSeen& s) {
        Matrix toWorld;
        std::copy_n(instance.transform, 12, toWorld.begin());
        Matrix toObject = inverse(toWorld);
        ASSERT_EQ(1u, s.transformCount);
        EXPECT_EQ(unsigned(OPTIX_TRANSFORM_TYPE_INSTANCE), s.transformType);
        EXPECT_EQ(instance.instanceId, s.transformId);
        EXPECT_EQ(instance.traversableHandle, s.transformChild);
        EXPECT_EQ(instance.traversableHandle, s.gas);
        EXPECT_EQ(0, std::memcmp(instance.transform, s.instanceMatrix, 48));
        expectNear(toObject.data(), s.instanceInverse, 12, 1e-4f);
        expectNear(toWorld.data(), s.objectToWorld, 12, 1e-5f);
        expectNear(toObject.data(), s.worldToObject, 12, 1e-4f);
        Vec3 p{1, 2, 3};
        Vec3 point = transformPoint(toWorld, p), vector = transformVector(toWorld, p);
        expectNear(&point.x, s.worldPoint, 3, 1e-4f);
        expectNear(&vector.x, s.worldVector, 3, 1e-4f);
        Vec3 back = transformPoint(toObject, p);
        expectNear(&back.x, s.objectPoint, 3, 1e-3f);
        // Normals by the transpose of the inverse.
        Matrix transposed{};
        for (size_t i = 0; i < 3; ++i)
            for (size_t j = 0; j < 3; ++j)
                transposed[i * 4 + j] = toObject[j * 4 + i];
        Vec3 normal = transformVector(transposed, p);
        expectNear(&normal.x, s.worldNormal, 3, 1e-3f);
    }

    // Each any-hit call must belong to a crossing with any-hit enabled and have its distance as
    // tmax, and each crossing has one call (these triangles require single any-hit calls).
    void judgeAnyHits(const std::vector<ReferenceInstance>& scene, const Query& q,
                      const std::vector<Crossing>& all, const ProbeResult& r,
                      unsigned launchIndex) {
        for (unsigned k = 0; k < r.anyHits && k < kProbeRuns; ++k) {
            const ProbeSeen& s = r.anyHit[k];
            const Crossing* match = nullptr;
            for (const Crossing& c : all)
                if (c.primitive == s.primitive && c.sbtGasIndex == s.sbtGasIndex &&
                    (scene[c.instance].instance.traversableHandle == 0 ||
                     c.instance == s.instanceIndex))
                    match = &c;
            ASSERT_NE(nullptr, match) << "any-hit for a primitive the ray does not cross";
            EXPECT_TRUE(match->anyHitEnabled);
            EXPECT_NEAR(match->t, s.tmax, 1e-4 * (1 + match->t));
            unsigned record = scene[match->instance].instance.sbtOffset +
                              match->sbtGasIndex * (q.sbtStride & 255) + q.sbtOffset;
            judgeHit(scene, *match, s, record);
            judgeRay(q, s, launchIndex);
            judgeObjectRay(scene[match->instance], q, s);
        }
    }

    void judgeObjectRay(const ReferenceInstance& instance, const Query& q, const ProbeSeen& s) {
        Matrix toWorld;
        std::copy_n(instance.instance.transform, 12, toWorld.begin());
        Matrix toObject = inverse(toWorld);
        Vec3 o = transformPoint(toObject, q.ray.origin);
        Vec3 d = transformVector(toObject, q.ray.direction);
        expectNear(&o.x, s.objectOrigin, 3, 1e-3f);
        expectNear(&d.x, s.objectDirection, 3, 1e-3f);
    }

    std::unique_ptr<Rig> rig_;
    std::vector<unsigned> rules_;
};

// Ray flags in all combinations that the manual allows.
std::vector<unsigned> legalRayFlags() {
    std::vector<unsigned> all;
    for (unsigned anyHit : {0u, 1u, 2u, 64u, 128u})
        for (unsigned face : {0u, 16u, 32u})
            for (unsigned rest : {0u, 4u, 8u, 12u})
                all.push_back(anyHit | face | rest);
    return all;
}

TEST_P(Traversal, ClosestOfOneStructure) {
    std::mt19937 random(11);
    makeRig({kProbeAccept});
    auto mesh = randomMesh(random, 150, {0});
    auto other = randomMesh(random, 90, {0, 0, 0});
    other->input.triangleArray.primitiveIndexOffset = 5000;
    Accel accel = buildAccel(context_, log_, {mesh->input, other->input});
    auto gas = referenceOf({mesh.get(), other.get()});
    std::vector<Query> queries;
    for (const Ray& ray : randomRays(random, 3000, 3))
        queries.push_back({ray, unsigned(random() % 4), unsigned(random() % 4),
                           unsigned(random() % 2)});
    EXPECT_GT(compare({bare(gas)}, queries, trace(queries, accel.handle)), 500u);
}

TEST_P(Traversal, RayFlagsOnOneStructure) {
    std::mt19937 random(12);
    makeRig({kProbeAccept, kProbeIgnoreOdd, kProbeIgnore});
    auto mesh = randomMesh(random, 60, {0, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT});
    auto other = randomMesh(
        random, 40, {0, OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL,
                     OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT |
                         OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL});
    Accel accel = buildAccel(context_, log_, {mesh->input, other->input});
    auto gas = referenceOf({mesh.get(), other.get()});
    std::vector<unsigned> flags = legalRayFlags();
    std::vector<Query> queries;
    for (const Ray& ray : randomRays(random, 6000, 2.5f)) {
        queries.push_back({ray, unsigned(random() % 3), unsigned(1 + random() % 2), 0});
        queries.back().ray.flags = flags[queries.size() % flags.size()];
    }
    EXPECT_GT(compare({bare(gas)}, queries, trace(queries, accel.handle)), 1000u);
}

TEST_P(Traversal, InstancesMasksAndFlags) {
    std::mt19937 random(13);
    makeRig({kProbeAccept, kProbeIgnoreOdd, kProbeAccept, kProbeIgnore});
    auto first = randomMesh(random, 40, {0, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT});
    auto second = randomMesh(random, 25, {OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT});
    second->input.triangleArray.primitiveIndexOffset = 77;
    Accel a = buildAccel(context_, log_, {first->input});
    Accel b = buildAccel(context_, log_, {second->input, first->input});
    auto gasA = referenceOf({first.get()});
    auto gasB = referenceOf({second.get(), first.get()});
    std::vector<OptixInstance> list;
    std::vector<ReferenceInstance> scene;
    for (unsigned i = 0; i < 24; ++i) {
        bool useA = random() % 2;
        unsigned flags = unsigned(random() % 4); // face culling and flip
        flags |= i % 3 == 1 ? 4u : i % 3 == 2 ? 8u : 0u;
        unsigned mask = i % 4 == 0 ? 255u : 1u << random() % 8;
        list.push_back(instanceOf(useA ? a.handle : b.handle, randomAffine(random, 2.0f),
                                  (i * 0x1234567u) & 0x0FFFFFFFu, unsigned(random() % 12), mask,
                                  flags));
        scene.push_back({list.back(), useA ? &gasA : &gasB});
    }
    InstanceList instances(list);
    Accel top = buildAccel(context_, log_, {instances.input});
    std::vector<unsigned> flags = legalRayFlags();
    std::vector<Query> queries;
    for (const Ray& ray : randomRays(random, 5000, 4)) {
        queries.push_back({ray, unsigned(random() % 3), unsigned(random() % 3), 0});
        queries.back().ray.flags = flags[queries.size() % flags.size()];
        if (random() % 2)
            queries.back().ray.mask = unsigned(random() % 256);
    }
    EXPECT_GT(compare(scene, queries, trace(queries, top.handle)), 1000u);
}

TEST_P(Traversal, TerminateEndsTheRay) {
    std::mt19937 random(14);
    makeRig({kProbeTerminate});
    auto mesh = randomMesh(random, 200, {0});
    Accel accel = buildAccel(context_, log_, {mesh->input});
    auto gas = referenceOf({mesh.get()});
    std::vector<Query> queries;
    for (const Ray& ray : randomRays(random, 1000, 2))
        queries.push_back({ray});
    std::vector<ProbeResult> results = trace(queries, accel.handle);
    size_t hits = 0;
    for (size_t i = 0; i < queries.size(); ++i) {
        bool ambiguous = false;
        std::vector<Crossing> all = crossings({bare(gas)}, queries[i].ray, ambiguous);
        if (ambiguous)
            continue;
        ASSERT_EQ(all.empty() ? 0u : 1u, results[i].anyHits) << i;
        ASSERT_EQ(all.empty() ? 0u : 1u, results[i].closestHits) << i;
        if (all.empty())
            continue;
        ++hits;
        EXPECT_EQ(results[i].anyHit[0].primitive, results[i].closestHit.primitive)
            << "closest-hit runs for the hit that ended the ray";
        EXPECT_EQ(results[i].anyHit[0].tmax, results[i].closestHit.tmax);
    }
    EXPECT_GT(hits, 300u);
}

TEST_P(Traversal, EmptyMaskSeesNothing) {
    makeRig({kProbeAccept});
    TriangleMesh mesh({{-9, -9, 1}, {9, -9, 1}, {0, 9, 1}}, {0, 1, 2});
    Accel gas = buildAccel(context_, log_, {mesh.input});
    InstanceList list({instanceOf(gas.handle, identity(), 1, 0, 0), // never seen
                       instanceOf(gas.handle, translation(0, 0, 1), 2, 0, 0x80)});
    Accel top = buildAccel(context_, log_, {list.input});
    std::vector<Query> queries(4);
    for (Query& q : queries)
        q.ray.direction = {0, 0, 1};
    queries[1].ray.mask = 0;
    queries[2].ray.mask = 0x7F;
    queries[3].ray.mask = 0x80;
    std::vector<ProbeResult> r = trace(queries, top.handle);
    EXPECT_EQ(2u, r[0].closestHit.instanceId);
    EXPECT_EQ(1u, r[1].misses);
    EXPECT_EQ(1u, r[2].misses);
    EXPECT_EQ(2u, r[3].closestHit.instanceId);
    // A structure without instances has no mask.
    EXPECT_EQ(1u, trace({queries[2]}, gas.handle)[0].closestHits);
}

TEST_P(Traversal, IntervalEndsAreInside) {
    makeRig({kProbeAccept});
    TriangleMesh mesh({{-9, -9, 2}, {9, -9, 2}, {0, 9, 2}}, {0, 1, 2});
    Accel gas = buildAccel(context_, log_, {mesh.input});
    auto hits = [&](float tmin, float tmax) {
        Query q;
        q.ray.direction = {0, 0, 1};
        q.ray.tmin = tmin;
        q.ray.tmax = tmax;
        return trace({q}, gas.handle)[0].closestHits;
    };
    EXPECT_EQ(1u, hits(0, 10));
    EXPECT_EQ(1u, hits(2, 10));
    EXPECT_EQ(1u, hits(0, 2));
    EXPECT_EQ(1u, hits(2, 2));
    EXPECT_EQ(0u, hits(std::nextafter(2.0f, 3.0f), 10));
    EXPECT_EQ(0u, hits(0, std::nextafter(2.0f, 1.0f)));
    EXPECT_EQ(0u, hits(3, 1)) << "an empty interval";
}

TEST_P(Traversal, StrangeRaysMiss) {
    makeRig({kProbeAccept});
    TriangleMesh mesh({{-9, -9, 2}, {9, -9, 2}, {0, 9, 2}}, {0, 1, 2});
    Accel gas = buildAccel(context_, log_, {mesh.input});
    float nan = std::nanf(""), inf = INFINITY;
    std::vector<Query> queries;
    for (Vec3 direction : {Vec3{0, 0, 0}, Vec3{nan, 0, 1}, Vec3{0, 0, nan}, Vec3{inf, 0, 1},
                           Vec3{0, 0, -inf}}) {
        Query q;
        q.ray.direction = direction;
        queries.push_back(q);
    }
    for (Vec3 origin : {Vec3{nan, 0, 0}, Vec3{0, inf, 0}, Vec3{0, 0, -inf}}) {
        Query q;
        q.ray.origin = origin;
        q.ray.direction = {0, 0, 1};
        queries.push_back(q);
    }
    Query interval;
    interval.ray.direction = {0, 0, 1};
    interval.ray.tmin = nan;
    queries.push_back(interval);
    interval.ray.tmin = 0;
    interval.ray.tmax = nan;
    queries.push_back(interval);
    for (const ProbeResult& r : trace(queries, gas.handle)) {
        EXPECT_EQ(0u, r.closestHits);
        EXPECT_EQ(1u, r.misses);
    }
    // Applications often use an infinite tmax for any distance.
    interval.ray.tmax = inf;
    EXPECT_EQ(1u, trace({interval}, gas.handle)[0].closestHits);
}

INSTANTIATE_DEVICE_TEST(Traversal);

} // namespace
} // namespace tests::api
