// SPDX-License-Identifier: Apache-2.0
// Batches against single rays and against a brute-force reference that tests every triangle.
#include "bvh/batch/batch.h"

#include "bvh/testing/meshes.h"
#include "devlib/graph.h"

#include <gtest/gtest.h>

#include <algorithm>

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

struct RawRay {
    float origin[3], tmin, direction[3], tmax;
};

RawRay rawRay(Vec3 o, Vec3 d, float tmin = 0, float tmax = 1e30f) {
    return {{o.x, o.y, o.z}, tmin, {d.x, d.y, d.z}, tmax};
}

// Rays of one camera, whose neighbours are similar.
std::vector<RawRay> cameraRays(uint32_t width, uint32_t height) {
    std::vector<RawRay> rays;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            rays.push_back(rawRay({0.1f, 0.2f, 3}, {float(x) / float(width) - 0.5f,
                                                    float(y) / float(height) - 0.5f, -1}));
    return rays;
}

std::vector<RawRay> randomRays(uint32_t count, uint32_t seed) {
    Random random(seed);
    std::vector<RawRay> rays;
    for (uint32_t i = 0; i < count; ++i) {
        const Vec3 o = random.point(random.below(2) ? 1.0f : 3.0f);
        RawRay ray = rawRay(o, random.below(2) ? random.point(1) - o : random.unit());
        if (random.below(4) == 0) {
            ray.tmin = random(-1, 1);
            ray.tmax = ray.tmin + random(0, 2);
        }
        switch (random.below(24)) {
        case 0:
            ray.direction[random.below(3)] = 0;
            break;
        case 1:
            ray.direction[0] = ray.direction[1] = 0;
            break;
        case 2:
            ray.origin[random.below(3)] = NAN;
            break;
        case 3:
            ray.tmax = ray.tmin - 1;
            break;
        case 4:
            ray.direction[random.below(3)] = INFINITY;
            break;
        }
        rays.push_back(ray);
    }
    return rays;
}

RayBatch batchOf(const Structure& s, const std::vector<RawRay>& rays, std::vector<BatchHit>& hits,
                 uint64_t masks = 0) {
    hits.assign(rays.size(), {7, 7, 7, 7, 7});
    RayBatch batch;
    batch.handle = uint64_t(s.block());
    batch.rays = uint64_t(rays.data());
    batch.hits = uint64_t(hits.data());
    batch.masks = masks;
    batch.count = rays.size();
    batch.hitFormat = HitFormat::kTTriangleInstanceUv;
    return batch;
}

QueryRay queryOf(const RawRay& ray) {
    QueryRay q;
    std::memcpy(&q, &ray, sizeof q);
    q.tmin = q.tmin < 0 ? 0 : q.tmin;
    return q;
}

// The batch's hits must equal those of single rays, bit for bit.
void compare(const Mesh& mesh, const std::vector<RawRay>& rays) {
    const Structure s = makeStructure(mesh.input());
    for (Isa isa : machineIsas()) {
        std::vector<BatchHit> hits;
        const RayBatch batch = batchOf(s, rays, hits);
        batchKernels(isa).closest(batch, 0, pieceCount(batch));
        uint32_t found = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            QueryHit expected{};
            const bool hit = kernels(isa).closest(s.block(), queryOf(rays[i]), expected);
            found += hit;
            ASSERT_EQ(hits[i].t >= 0, hit) << isaName(isa) << " ray " << i;
            if (!hit) {
                EXPECT_EQ(hits[i].triangle, ~0u);
                continue;
            }
            ASSERT_EQ(hits[i].t, expected.t) << isaName(isa) << " ray " << i;
            EXPECT_EQ(hits[i].triangle, expected.primitive);
            EXPECT_EQ(hits[i].u, expected.u);
            EXPECT_EQ(hits[i].v, expected.v);
            EXPECT_EQ(hits[i].instance, 0u);
        }
        EXPECT_GT(found, rays.size() / 100);
        batchKernels(isa).any(batchOf(s, rays, hits), 0, pieceCount(batch));
        for (size_t i = 0; i < rays.size(); ++i)
            ASSERT_EQ(hits[i].t >= 0, kernels(isa).occluded(s.block(), queryOf(rays[i])))
                << isaName(isa) << " ray " << i;
    }
}

TEST(Batch, CameraRays) {
    compare(soup(3000, 0.1f, 1), cameraRays(67, 41));
    compare(icosphere(4), cameraRays(67, 41));
    compare(soup(20, 0.5f, 2), cameraRays(67, 41));
}

TEST(Batch, RandomRays) {
    compare(soup(3000, 0.1f, 1), randomRays(5000, 3));
    compare(icosphere(4), randomRays(5000, 4));
    compare(cube(), randomRays(999, 5));
    compare(soup(1, 1, 6), randomRays(2000, 7));
}

// Parallel rays and narrow cones in any direction, some along axes, with invalid rays among them,
// which packets must exclude.
std::vector<RawRay> alikeRays(uint32_t count, uint32_t seed) {
    Random random(seed);
    std::vector<RawRay> rays;
    while (rays.size() < count) {
        Vec3 d = random.unit();
        for (int axis = 0; axis < 3; ++axis)
            if (random.below(3) == 0)
                d[axis] = random.below(2) ? 0.0f : -0.0f;
        if (math::length(d) == 0)
            continue;
        const float spread = random.below(2) ? 0.0f : random(0, 0.2f) * math::length(d);
        const bool isCamera = random.below(2);
        const Vec3 eye = random.point(2) - d * 2.0f;
        for (uint32_t i = 0; i < 64; ++i) {
            RawRay ray =
                rawRay(isCamera ? eye : random.point(1) - d * 3.0f, d + random.point(spread));
            switch (random.below(40)) {
            case 0:
                ray.origin[random.below(3)] = NAN;
                break;
            case 1:
                ray.tmax = random(-1, 3);
                break;
            case 2:
                ray.tmin = random(0, 4);
                break;
            }
            rays.push_back(ray);
        }
    }
    return rays;
}

TEST(Batch, RaysThatAreAlike) {
    Mesh mixed = soup(2000, 0.03f, 14); // tiny triangles, and some that fill the scene
    const Mesh large = soup(12, 3, 15);
    for (const auto& t : large.triangles)
        mixed.triangles.push_back({t[0] + 6000, t[1] + 6000, t[2] + 6000});
    mixed.vertices.insert(mixed.vertices.end(), large.vertices.begin(), large.vertices.end());
    compare(mixed, alikeRays(6400, 16));
    compare(soup(3000, 0.1f, 1), alikeRays(6400, 17));
    compare(cube(), alikeRays(3200, 18)); // rays in the planes of its sides
    compare(icosphere(3), alikeRays(3207, 19));
}

// Some rays start so far away that distances to planes overflow; neighbouring rays must still hit.
TEST(Batch, OriginsThatAreTooFarOff) {
    for (std::vector<RawRay> rays : {randomRays(5000, 20), alikeRays(6400, 21)}) {
        Random random(22);
        for (RawRay& ray : rays) {
            if (random.below(8) != 0)
                continue;
            for (float& o : ray.origin)
                if (random.below(4) != 0)
                    o = random.below(2) ? 1e38f : -1e38f;
            if (random.below(2))
                ray.tmax = INFINITY;
        }
        compare(soup(83, 0.5f, 9), rays);
    }
}

// Directions so long that no axis culls, in packets and as single rays.
TEST(Batch, LongDirections) {
    std::vector<RawRay> rays = cameraRays(600, 20);
    for (RawRay& ray : rays)
        for (float& d : ray.direction)
            d *= 1e38f;
    compare(icosphere(3), rays);
    compare(soup(83, 0.5f, 9), rays);
}

TEST(Batch, EmptyStructures) {
    Mesh mesh = cube();
    mesh.triangles.clear();
    const Structure s = makeStructure(mesh.input());
    const std::vector<RawRay> rays = randomRays(100, 8);
    std::vector<BatchHit> hits;
    for (Isa isa : machineIsas()) {
        const RayBatch batch = batchOf(s, rays, hits);
        batchKernels(isa).closest(batch, 0, pieceCount(batch));
        for (const BatchHit& hit : hits)
            EXPECT_EQ(hit.t, -1);
    }
}

struct Instanced {
    std::vector<Structure> children;
    std::vector<InstanceDesc> descs;
    Structure top;
};

Instanced makeInstanced(const std::vector<Mesh>& meshes, uint32_t count, uint32_t seed) {
    Random random(seed);
    Instanced r;
    for (const Mesh& mesh : meshes)
        r.children.push_back(makeStructure(mesh.input()));
    for (uint32_t i = 0; i < count; ++i) {
        InstanceDesc desc{};
        const Vec3 at = random.point(1);
        const Vec3 a = random.point(0.4f), b = random.point(0.4f);
        const float m[12] = {0.4f, a.x, a.y, at.x, b.x, 0.3f, a.z, at.y, b.y, b.z, 0.5f, at.z};
        std::copy(m, m + 12, desc.transform);
        desc.visibilityMask = 255;
        desc.traversableHandle =
            uint64_t(r.children[i % r.children.size()].block()) | devlib::kTagGas;
        r.descs.push_back(desc);
    }
    InstanceInput input;
    input.instances = r.descs.data();
    input.numInstances = count;
    BuildInputs inputs;
    inputs.instances = &input;
    r.top = makeStructure(inputs);
    return r;
}

// The triangles of all instances in one mesh; its triangle i is triangle ids[i] of instance
// instances[i].
struct Flattened {
    Mesh mesh;
    std::vector<uint32_t> ids, instances;
};

Flattened flatten(const std::vector<Mesh>& meshes, const Instanced& scene) {
    Flattened f;
    for (uint32_t i = 0; i < scene.descs.size(); ++i) {
        const Mesh& mesh = meshes[i % meshes.size()];
        const float* const m = scene.descs[i].transform;
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const uint32_t base = uint32_t(f.mesh.vertices.size());
            for (uint32_t k = 0; k < 3; ++k) {
                const Vec3 p = mesh.vertices[mesh.triangles[t][k]];
                f.mesh.vertices.push_back({m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                                           m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                                           m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]});
            }
            f.mesh.triangles.push_back({base, base + 1, base + 2});
            f.ids.push_back(t);
            f.instances.push_back(i);
        }
    }
    return f;
}

TEST(Batch, InstancesAgreeWithOneMesh) {
    const std::vector<Mesh> meshes = {soup(50, 0.3f, 1), icosphere(1)};
    const Instanced scene = makeInstanced(meshes, 30, 2);
    const Flattened flat = flatten(meshes, scene);
    const Structure one = makeStructure(flat.mesh.input());
    std::vector<RawRay> rays = randomRays(4000, 3);
    for (const RawRay& ray : cameraRays(64, 33))
        rays.push_back(ray);
    for (Isa isa : machineIsas()) {
        std::vector<BatchHit> hits, expected;
        const RayBatch batch = batchOf(scene.top, rays, hits);
        batchKernels(isa).closest(batch, 0, pieceCount(batch));
        batchKernels(isa).closest(batchOf(one, rays, expected), 0, pieceCount(batch));
        uint32_t found = 0, differ = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            found += hits[i].t >= 0;
            const bool same =
                hits[i].t < 0
                    ? expected[i].t < 0
                    : expected[i].t >= 0 &&
                          std::fabs(hits[i].t - expected[i].t) <= 1e-4f * (1 + hits[i].t) &&
                          flat.ids[expected[i].triangle] == hits[i].triangle &&
                          flat.instances[expected[i].triangle] == hits[i].instance;
            differ += !same;
        }
        EXPECT_GT(found, 1000u);
        EXPECT_LE(differ, 12u) << isaName(isa); // edges, rounded otherwise
        std::vector<BatchHit> any;
        batchKernels(isa).any(batchOf(scene.top, rays, any), 0, pieceCount(batch));
        for (size_t i = 0; i < rays.size(); ++i)
            ASSERT_EQ(any[i].t >= 0, hits[i].t >= 0) << isaName(isa) << " ray " << i;
    }
}

TEST(Batch, EqualDistancesGoToTheLowestInstanceAndTriangle) {
    Mesh mesh = cube();
    const auto twice = mesh.triangles;
    mesh.triangles.insert(mesh.triangles.end(), twice.begin(), twice.end());
    Instanced scene = makeInstanced({mesh}, 3, 1);
    for (InstanceDesc& desc : scene.descs) {
        const float m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        std::copy(m, m + 12, desc.transform);
    }
    InstanceInput input;
    input.instances = scene.descs.data();
    input.numInstances = 3;
    BuildInputs inputs;
    inputs.instances = &input;
    scene.top = makeStructure(inputs);
    const std::vector<RawRay> rays = cameraRays(32, 32);
    std::vector<BatchHit> hits;
    for (Isa isa : machineIsas()) {
        const RayBatch batch = batchOf(scene.top, rays, hits);
        batchKernels(isa).closest(batch, 0, pieceCount(batch));
        for (const BatchHit& hit : hits)
            if (hit.t >= 0) {
                EXPECT_EQ(hit.instance, 0u);
                EXPECT_LT(hit.triangle, 12u);
            }
    }
}

TEST(Batch, MasksOfTriangles) {
    const Mesh mesh = soup(400, 0.4f, 9);
    const Structure s = makeStructure(mesh.input());
    std::vector<uint32_t> masks;
    for (uint32_t i = 0; i < 400; ++i)
        masks.push_back(1u << i % 3);
    std::vector<RawRay> rays = randomRays(1000, 10);
    for (RawRay& ray : rays)
        ray.tmin = 0;
    for (uint32_t mask : {0u, 1u, 2u, 6u, 7u}) {
        std::vector<RawRay> masked = rays;
        for (RawRay& ray : masked)
            std::memcpy(&ray.tmin, &mask, 4);
        Mesh visible = mesh;
        visible.triangles.clear();
        std::vector<uint32_t> ids;
        for (uint32_t i = 0; i < 400; ++i)
            if (masks[i] & mask) {
                visible.triangles.push_back(mesh.triangles[i]);
                ids.push_back(i);
            }
        const Structure few = makeStructure(visible.input());
        for (Isa isa : machineIsas()) {
            std::vector<BatchHit> hits, expected, any;
            RayBatch batch = batchOf(s, masked, hits, uint64_t(masks.data()));
            batch.rayFormat = RayFormat::kOriginMaskDirectionTmax;
            batchKernels(isa).closest(batch, 0, pieceCount(batch));
            batchKernels(isa).closest(batchOf(few, rays, expected), 0, pieceCount(batch));
            any = hits;
            batch.hits = uint64_t(any.data());
            batchKernels(isa).any(batch, 0, pieceCount(batch));
            for (size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(hits[i].t, expected[i].t) << isaName(isa) << " mask " << mask;
                ASSERT_EQ(any[i].t >= 0, hits[i].t >= 0);
                if (hits[i].t >= 0) {
                    EXPECT_EQ(hits[i].triangle, ids[expected[i].triangle]);
                    EXPECT_TRUE(masks[any[i].triangle] & mask);
                }
            }
        }
    }
}

TEST(Batch, FormatsHoldTheSameHits) {
    const Mesh mesh = soup(300, 0.4f, 11);
    const Structure s = makeStructure(mesh.input());
    const std::vector<RawRay> rays = cameraRays(19, 13);
    std::vector<BatchHit> full;
    const RayBatch reference = batchOf(s, rays, full);
    batchKernels(chosenIsa()).closest(reference, 0, pieceCount(reference));
    for (HitFormat format : {HitFormat::kT, HitFormat::kTTriangle, HitFormat::kTTriangleUv,
                             HitFormat::kTTriangleInstance}) {
        const uint32_t words = hitBytes(format) / 4;
        std::vector<uint32_t> out(rays.size() * words + 1, 0xABABABABu);
        RayBatch batch = reference;
        batch.hitFormat = format;
        batch.hits = uint64_t(out.data());
        traceBatch(batch, false);
        for (size_t i = 0; i < rays.size(); ++i) {
            const uint32_t* const hit = &out[i * words];
            EXPECT_EQ(std::memcmp(&hit[0], &full[i].t, 4), 0);
            if (words > 1) {
                EXPECT_EQ(hit[1], full[i].triangle);
            }
            if (words == 3) {
                EXPECT_EQ(hit[2], full[i].instance);
            }
            if (words == 4) {
                EXPECT_EQ(std::memcmp(&hit[2], &full[i].u, 8), 0);
            }
        }
        EXPECT_EQ(out.back(), 0xABABABABu);
    }
}

// Bits outside the range keep their values, at any first bit and count.
TEST(Batch, BitsAreWrittenInTheirRangeOnly) {
    const Structure s = makeStructure(soup(300, 0.4f, 11).input());
    const std::vector<RawRay> rays = cameraRays(21, 13);
    std::vector<BatchHit> full;
    const RayBatch reference = batchOf(s, rays, full);
    traceBatch(reference, false);
    for (const uint32_t firstBit : {0u, 1u, 5u, 7u})
        for (const uint64_t count : {1ull, 7ull, 8ull, 63ull, 64ull, 65ull, 273ull})
            for (const uint8_t fill : {uint8_t(0), uint8_t(255)}) {
                std::vector<uint8_t> bytes(64, fill);
                RayBatch batch = reference;
                batch.hitFormat = HitFormat::kBit;
                batch.hits = uint64_t(bytes.data());
                batch.firstBit = firstBit;
                batch.count = count;
                traceBatch(batch, true);
                for (uint64_t bit = 0; bit < bytes.size() * 8; ++bit) {
                    const bool is = bytes[bit / 8] >> bit % 8 & 1;
                    const bool inside = bit >= firstBit && bit < firstBit + count;
                    ASSERT_EQ(is, inside ? full[bit - firstBit].t >= 0 : fill != 0)
                        << bit << " of " << firstBit << ", " << count;
                }
            }
}

void compareAll(const Mesh& mesh, const BuildOptions& options, const std::vector<RawRay>& rays) {
    const Structure s = makeStructure(mesh.input(), options);
    std::vector<Structure> alone;
    for (const auto& triangle : mesh.triangles) {
        Mesh one = mesh;
        one.triangles = {triangle};
        alone.push_back(makeStructure(one.input()));
    }
    std::vector<BatchHit> unused;
    for (Isa isa : machineIsas()) {
        std::vector<ListedHit> hits;
        batchKernels(isa).all(batchOf(s, rays, unused), 0, rays.size(), hits);
        size_t next = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            std::vector<std::pair<float, uint32_t>> expected;
            for (uint32_t t = 0; t < alone.size(); ++t) {
                QueryHit hit{};
                if (kernels(isa).closest(alone[t].block(), queryOf(rays[i]), hit))
                    expected.push_back({hit.t, t});
            }
            std::sort(expected.begin(), expected.end());
            for (const auto& [t, triangle] : expected) {
                ASSERT_LT(next, hits.size());
                EXPECT_EQ(hits[next].ray, i);
                EXPECT_EQ(hits[next].hit.t, t);
                EXPECT_EQ(hits[next].hit.triangle, triangle);
                ++next;
            }
        }
        EXPECT_EQ(next, hits.size());
        EXPECT_GT(next, 200u);
    }
}

TEST(Batch, AllHitsAreThoseOfEveryTriangleAlone) {
    const std::vector<RawRay> rays = randomRays(300, 13);
    compareAll(soup(60, 0.8f, 12), {}, rays);
}

// Several leaves refer to one triangle.
TEST(Batch, AllHitsNameSplitTrianglesOnce) {
    BuildOptions fast;
    fast.preferFastTrace = true;
    std::vector<RawRay> rays = randomRays(300, 14);
    compareAll(soup(60, 5, 12), fast, rays);
    const Mesh mesh = needles(60, 15);
    Random random(16);
    for (RawRay& ray : rays) {
        const Vec3* v = &mesh.vertices[3 * random.below(60)];
        const float a = random(0, 1), b = random(0, 1 - a);
        const Vec3 o = random.point(3);
        ray = rawRay(o, v[0] * (1 - a - b) + v[1] * a + v[2] * b - o);
    }
    compareAll(mesh, fast, rays);
}

// In double precision: projection, else the nearest of the three edges.
double exactDistance(const Vec3& pf, const Vec3 vf[3]) {
    struct D {
        double x, y, z;
    };
    const auto of = [](const Vec3& a) { return D{a.x, a.y, a.z}; };
    const auto minus = [](D a, D b) { return D{a.x - b.x, a.y - b.y, a.z - b.z}; };
    const auto dot = [](D a, D b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
    const auto cross = [](D a, D b) {
        return D{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    };
    const D p = of(pf), v[3] = {of(vf[0]), of(vf[1]), of(vf[2])};
    const D n = cross(minus(v[1], v[0]), minus(v[2], v[0]));
    bool inside = true;
    double least = INFINITY;
    for (int i = 0; i < 3; ++i) {
        const D a = v[i], e = minus(v[(i + 1) % 3], a), q = minus(p, a);
        inside &= dot(cross(e, q), n) >= 0;
        const double s = std::clamp(dot(q, e) / dot(e, e), 0.0, 1.0);
        const D r = {q.x - s * e.x, q.y - s * e.y, q.z - s * e.z};
        least = std::min(least, std::sqrt(dot(r, r)));
    }
    return inside ? std::fabs(dot(minus(p, v[0]), n)) / std::sqrt(dot(n, n)) : least;
}

TEST(Batch, NearestPointsAgreeWithTheJudge) {
    const std::vector<Mesh> meshes = {soup(40, 0.4f, 1), icosphere(1)};
    const Instanced scene = makeInstanced(meshes, 20, 5);
    const Flattened flat = flatten(meshes, scene);
    const Structure one = makeStructure(flat.mesh.input());
    Random random(14);
    std::vector<Vec3> points;
    for (int i = 0; i < 400; ++i)
        points.push_back(random.point(i % 2 ? 1.0f : 4.0f));
    std::vector<double> expected;
    for (const Vec3& p : points) {
        double least = INFINITY;
        for (const auto& t : flat.mesh.triangles) {
            const Vec3 v[3] = {flat.mesh.vertices[t[0]], flat.mesh.vertices[t[1]],
                               flat.mesh.vertices[t[2]]};
            least = std::min(least, exactDistance(p, v));
        }
        expected.push_back(least);
    }
    points.push_back({NAN, 0, 0});
    for (Isa isa : machineIsas())
        for (const Structure* s : {&one, &scene.top})
            for (const float farthest : {INFINITY, 0.2f}) {
                std::vector<NearestPoint> found(points.size());
                batchKernels(isa).nearest(uint64_t(s->block()), &points[0].x, farthest,
                                          found.data(), 0, points.size());
                for (size_t i = 0; i < expected.size(); ++i) {
                    if (found[i].distance < 0) {
                        EXPECT_GT(expected[i], farthest * (1 - 1e-5));
                        continue;
                    }
                    EXPECT_NEAR(found[i].distance, expected[i], 2e-5) << isaName(isa);
                    const Vec3 at = {found[i].point[0], found[i].point[1], found[i].point[2]};
                    EXPECT_NEAR(math::length(at - points[i]), found[i].distance, 2e-5);
                }
                EXPECT_LT(found.back().distance, 0);
            }
}

} // namespace
} // namespace sunstone::bvh
