// SPDX-License-Identifier: Apache-2.0
// Hits of OptiX Prime against a reference: query types, formats, masks, ranges, strides,
// asynchronous execution. All tests run for each type of context and memory.
#include "fixture.h"

#include <algorithm>
#include <cstddef>

namespace prime_test {
namespace {

class PrimeQueries : public PrimeSetupTest {};

TEST_P(PrimeQueries, ClosestHitsAreThoseOfTheJudge) {
    const Mesh mesh = soup(300, 0.2f, 1);
    const std::vector<Ray> rays = randomRays(2000, 2);
    const RTPmodel model = makeModel(mesh, memory());
    const std::vector<Hit> hits = trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    EXPECT_EQ(wrongHits(mesh, rays, hits), 0u);
    EXPECT_GT(std::count_if(hits.begin(), hits.end(), [](const Hit& h) { return h.t >= 0; }), 300);
    for (const Hit& hit : hits)
        EXPECT_EQ(hit.instance, hit.t >= 0 ? 0 : -1);
}

TEST_P(PrimeQueries, AnyHitsAreHits) {
    const Mesh mesh = soup(300, 0.2f, 1);
    const std::vector<Ray> rays = randomRays(2000, 3);
    const RTPmodel model = makeModel(mesh, memory());
    const std::vector<Hit> any = trace(model, rays, RTP_QUERY_TYPE_ANY, memory());
    EXPECT_EQ(wrongHits(mesh, rays, any, true), 0u);
    const std::vector<Hit> closest = trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    for (size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(any[i].t >= 0, closest[i].t >= 0);
        EXPECT_LE(closest[i].t, any[i].t);
    }
}

TEST_P(PrimeQueries, AsynchronousQueriesFinish) {
    const Mesh mesh = soup(300, 0.2f, 1);
    const std::vector<Ray> rays = randomRays(3000, 4);
    const RTPmodel model = makeModel(mesh, memory());
    const std::vector<Hit> expected = trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    Buffer<Ray> in(memory(), rays);
    Buffer<Hit> out(memory(), std::vector<Hit>(rays.size()));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, memory(), in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, memory(), out);
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    int finished = 0;
    ASSERT_RTP(rtpQueryGetFinished(query, &finished));
    EXPECT_EQ(finished, 1) << "a query that never ran has finished";
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    for (int i = 0; i < 3; ++i)
        ASSERT_RTP(rtpQueryExecute(query, RTP_QUERY_HINT_ASYNC));
    ASSERT_RTP(rtpQueryFinish(query));
    ASSERT_RTP(rtpQueryFinish(query));
    ASSERT_RTP(rtpQueryGetFinished(query, &finished));
    EXPECT_EQ(finished, 1);
    EXPECT_EQ(std::memcmp(out.read().data(), expected.data(), out.bytes()), 0);
    // Polling ends, too.
    ASSERT_RTP(rtpQueryExecute(query, RTP_QUERY_HINT_ASYNC | RTP_QUERY_HINT_WATERTIGHT));
    for (finished = 0; !finished;)
        ASSERT_RTP(rtpQueryGetFinished(query, &finished));
}

TEST_P(PrimeQueries, ModelsUpdateAsynchronously) {
    const Mesh mesh = soup(5000, 0.1f, 1);
    Buffer<Float3> vertices(memory(), mesh.vertices);
    const Desc desc(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, memory(), vertices);
    RTPmodel model = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &model));
    int finished = 0;
    ASSERT_RTP(rtpModelGetFinished(model, &finished));
    EXPECT_EQ(finished, 1);
    ASSERT_RTP(rtpModelSetTriangles(model, nullptr, desc));
    ASSERT_RTP(rtpModelUpdate(model, RTP_MODEL_HINT_ASYNC));
    for (finished = 0; !finished;)
        ASSERT_RTP(rtpModelGetFinished(model, &finished));
    ASSERT_RTP(rtpModelUpdate(model, RTP_MODEL_HINT_ASYNC));
    const std::vector<Ray> rays = randomRays(500, 4); // the query waits for the update
    EXPECT_EQ(wrongHits(mesh, rays, trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory())), 0u);
    ASSERT_RTP(rtpModelFinish(model));
}

struct FormatCase {
    RTPbufferformat format;
    size_t words;
};

TEST_P(PrimeQueries, EveryHitFormat) {
    const Mesh mesh = soup(300, 0.2f, 1);
    const std::vector<Ray> rays = randomRays(777, 5);
    const RTPmodel model = makeModel(mesh, memory());
    const std::vector<Hit> expected = trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    Buffer<Ray> in(memory(), rays);
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, memory(), in);
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    for (const FormatCase& c :
         {FormatCase{RTP_BUFFER_FORMAT_HIT_T, 1}, FormatCase{RTP_BUFFER_FORMAT_HIT_T_TRIID, 2},
          FormatCase{RTP_BUFFER_FORMAT_HIT_T_TRIID_U_V, 4},
          FormatCase{RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID, 3},
          FormatCase{RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, 5}}) {
        constexpr int kGuard = 0x5A5A5A5A;
        Buffer<int> out(memory(), std::vector<int>(rays.size() * c.words + 1, kGuard));
        const Desc hitDesc(context, c.format, memory(), out.address(), rays.size());
        ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
        ASSERT_RTP(rtpQueryExecute(query, 0));
        const std::vector<int>& words = out.read();
        for (size_t i = 0; i < rays.size(); ++i) {
            const int* const hit = &words[i * c.words];
            ASSERT_EQ(std::memcmp(hit, &expected[i].t, 4), 0);
            if (c.words > 1) {
                EXPECT_EQ(hit[1], expected[i].triangle);
            }
            if (c.words == 3 || c.words == 5) {
                EXPECT_EQ(hit[2], expected[i].instance);
            }
            if (c.words >= 4) {
                EXPECT_EQ(std::memcmp(hit + c.words - 2, &expected[i].u, 8), 0);
            }
        }
        EXPECT_EQ(words.back(), kGuard);
    }
}

TEST_P(PrimeQueries, BitmasksOfRanges) {
    const Mesh mesh = soup(300, 0.2f, 1);
    const std::vector<Ray> rays = randomRays(203, 6);
    const RTPmodel model = makeModel(mesh, memory());
    const std::vector<Hit> expected = trace(model, rays, RTP_QUERY_TYPE_ANY, memory());
    Buffer<Ray> in(memory(), rays);
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, memory(), in);
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_ANY, &query));
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    for (const size_t begin : {size_t(0), size_t(32), size_t(13)})
        for (const uint8_t fill : {uint8_t(0), uint8_t(0xFF)}) {
            Buffer<uint8_t> out(memory(), std::vector<uint8_t>(40, fill));
            const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_BITMASK, memory(), out.address(), 0);
            ASSERT_RTP(rtpBufferDescSetRange(hitDesc, begin, begin + rays.size()));
            ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
            ASSERT_RTP(rtpQueryExecute(query, 0));
            const std::vector<uint8_t>& bytes = out.read();
            for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
                const bool inside = bit >= begin && bit < begin + rays.size();
                EXPECT_EQ(bytes[bit / 8] >> bit % 8 & 1,
                          inside ? expected[bit - begin].t >= 0 : fill & 1)
                    << bit;
            }
        }
}

// The check of the second query's memory must not write: the first may be writing there.
TEST_P(PrimeQueries, QueriesShareTheBytesOfABitmask) {
    const RTPmodel model =
        makeModel({{{-1, -1, 5}, {3, -1, 5}, {-1, 3, 5}}, {{0, 1, 2}}}, memory());
    constexpr size_t kCount = 40, kFirst = 13;
    Buffer<Ray> in(memory(), std::vector<Ray>(kCount, Ray{{0, 0, 0}, 0, {0, 0, 1}, 10}));
    Buffer<uint8_t> out(memory(), std::vector<uint8_t>(kCount / 8));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, memory(), in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_BITMASK, memory(), out.address(), 0);
    RTPquery queries[2];
    for (int i = 0; i < 2; ++i) {
        const size_t begin = i ? kFirst : 0, end = i ? kCount : kFirst;
        ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &queries[i]));
        ASSERT_RTP(rtpBufferDescSetRange(rayDesc, begin, end));
        ASSERT_RTP(rtpBufferDescSetRange(hitDesc, begin, end));
        ASSERT_RTP(rtpQuerySetRays(queries[i], rayDesc));
        ASSERT_RTP(rtpQuerySetHits(queries[i], hitDesc));
    }
    for (int round = 0; round < 2000; ++round) {
        std::fill(out.values().begin(), out.values().end(), uint8_t(0));
        out.upload();
        for (RTPquery query : queries)
            ASSERT_RTP(rtpQueryExecute(query, RTP_QUERY_HINT_ASYNC));
        for (RTPquery query : queries)
            ASSERT_RTP(rtpQueryFinish(query));
        ASSERT_EQ(out.read(), std::vector<uint8_t>(kCount / 8, 0xFF)) << round;
    }
}

TEST_P(PrimeQueries, RaysWithoutInterval) {
    const Mesh mesh = soup(300, 0.2f, 1);
    std::vector<Ray> rays = randomRays(500, 7);
    std::vector<Float3> pairs;
    for (Ray& ray : rays) {
        ray.tmin = 0;
        ray.tmax = 1e30f;
        pairs.push_back(ray.origin);
        pairs.push_back(ray.direction);
    }
    const RTPmodel model = makeModel(mesh, memory());
    const std::vector<Hit> expected = trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    Buffer<Float3> in(memory(), pairs);
    Buffer<Hit> out(memory(), std::vector<Hit>(rays.size()));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION, memory(), in.address(),
                       rays.size());
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, memory(), out);
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    ASSERT_RTP(rtpQueryExecute(query, 0));
    EXPECT_EQ(std::memcmp(out.read().data(), expected.data(), out.bytes()), 0);
}

// A model with masks, as indices of four ints.
struct MaskedModel {
    Buffer<Float3> vertices;
    Buffer<Int4> indices;
    Desc vertexDesc, indexDesc;
    RTPmodel model = nullptr;

    MaskedModel(RTPcontext context, RTPbuffertype memory, const Mesh& mesh, int (*maskOf)(int))
        : vertices(memory, mesh.vertices), indices(memory, masked(mesh, maskOf)),
          vertexDesc(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, memory, vertices),
          indexDesc(context, RTP_BUFFER_FORMAT_INDICES_INT3_MASK_INT, memory, indices) {
        EXPECT_RTP(rtpModelCreate(context, &model));
        EXPECT_RTP(rtpModelSetTriangles(model, indexDesc, vertexDesc));
        EXPECT_RTP(rtpModelUpdate(model, 0));
    }
    static std::vector<Int4> masked(const Mesh& mesh, int (*maskOf)(int)) {
        std::vector<Int4> result;
        for (const Int3& t : mesh.triangles)
            result.push_back({t.x, t.y, t.z, maskOf(int(result.size()))});
        return result;
    }
};

// The hits of rays that all have this mask.
std::vector<Hit> traceMasked(RTPcontext context, RTPmodel model, RTPbuffertype memory,
                             std::vector<Ray> rays, int mask) {
    for (Ray& ray : rays)
        std::memcpy(&ray.tmin, &mask, 4);
    Buffer<Ray> in(memory, rays);
    Buffer<Hit> out(memory, std::vector<Hit>(rays.size()));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_MASK_DIRECTION_TMAX, memory, in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, memory, out);
    RTPquery query = nullptr;
    EXPECT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    EXPECT_RTP(rtpQuerySetRays(query, rayDesc));
    EXPECT_RTP(rtpQuerySetHits(query, hitDesc));
    EXPECT_RTP(rtpQueryExecute(query, 0));
    EXPECT_RTP(rtpQueryDestroy(query));
    return out.read();
}

// The mesh without triangles that a mask hides: these become points.
Mesh visible(Mesh mesh, int (*maskOf)(int), int mask) {
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        if (!(maskOf(int(i)) & mask))
            mesh.triangles[i] = {0, 0, 0};
    return mesh;
}

TEST_P(PrimeQueries, MasksHideTriangles) {
    const Mesh mesh = soup(300, 0.3f, 1);
    const auto maskOf = [](int i) { return 1 << i % 3; };
    const auto turned = [](int i) { return 1 << (i + 1) % 3; };
    std::vector<Ray> rays = randomRays(700, 8);
    for (Ray& ray : rays) {
        ray.tmin = 0;
        ray.tmax = 1e30f;
    }
    MaskedModel masked(context, memory(), mesh, maskOf);
    for (const int mask : {0, 1, 2, 3, 4, -1}) {
        const std::vector<Hit> hits = traceMasked(context, masked.model, memory(), rays, mask);
        EXPECT_EQ(wrongHits(visible(mesh, maskOf, mask), rays, hits), 0u) << mask;
    }
    // Rays without masks meet all triangles.
    EXPECT_EQ(wrongHits(mesh, rays, trace(masked.model, rays, RTP_QUERY_TYPE_CLOSEST, memory())),
              0u);
    // New masks on the same triangles.
    const std::vector<Int4> newIndices = MaskedModel::masked(mesh, turned);
    std::copy(newIndices.begin(), newIndices.end(), masked.indices.values().begin());
    masked.indices.upload();
    ASSERT_RTP(rtpModelSetTriangles(masked.model, masked.indexDesc, masked.vertexDesc));
    ASSERT_RTP(rtpModelUpdate(masked.model, RTP_MODEL_HINT_MASK_UPDATE | RTP_MODEL_HINT_ASYNC));
    for (const int mask : {1, 6}) {
        const std::vector<Hit> hits = traceMasked(context, masked.model, memory(), rays, mask);
        EXPECT_EQ(wrongHits(visible(mesh, turned, mask), rays, hits), 0u) << mask;
    }
}

TEST_P(PrimeQueries, MaskedRaysMeetTrianglesWithoutMasks) {
    const Mesh mesh = soup(200, 0.3f, 1);
    std::vector<Ray> rays = randomRays(500, 4);
    for (Ray& ray : rays) {
        ray.tmin = 0;
        ray.tmax = 1e30f;
    }
    const RTPmodel model = makeModel(mesh, memory());
    for (const int mask : {1, 6, -1})
        EXPECT_EQ(wrongHits(mesh, rays, traceMasked(context, model, memory(), rays, mask)), 0u);
}

TEST_P(PrimeQueries, RangesAndStrides) {
    const Mesh mesh = soup(200, 0.3f, 1);
    struct Vertex {
        Float3 position;
        float color[5];
    };
    std::vector<Vertex> vertices(4, {{9, 9, 9}, {}});
    for (const Float3& p : mesh.vertices)
        vertices.push_back({p, {1, 2, 3, 4, 5}});
    vertices.push_back({{9, 9, 9}, {}});
    std::vector<Int3> indices(2, Int3{-5, 100000, 0});
    indices.insert(indices.end(), mesh.triangles.begin(), mesh.triangles.end());
    Buffer<Vertex> vertexBuffer(memory(), vertices);
    Buffer<Int3> indexBuffer(memory(), indices);
    const Desc vertexDesc(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, memory(), vertexBuffer);
    const Desc indexDesc(context, RTP_BUFFER_FORMAT_INDICES_INT3, memory(), indexBuffer);
    ASSERT_RTP(rtpBufferDescSetStride(vertexDesc, sizeof(Vertex)));
    ASSERT_RTP(rtpBufferDescSetRange(vertexDesc, 4, 4 + mesh.vertices.size()));
    ASSERT_RTP(rtpBufferDescSetRange(indexDesc, 2, indices.size()));
    RTPmodel model = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &model));
    ASSERT_RTP(rtpModelSetTriangles(model, indexDesc, vertexDesc));
    ASSERT_RTP(rtpModelUpdate(model, 0));
    // Rays and hits have ranges, too.
    std::vector<Ray> rays = randomRays(300, 9);
    Buffer<Ray> in(memory(), rays);
    Buffer<Hit> out(memory(), std::vector<Hit>(400, Hit{7, 7, 7, 7, 7}));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, memory(), in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, memory(), out);
    ASSERT_RTP(rtpBufferDescSetRange(rayDesc, 50, 250));
    ASSERT_RTP(rtpBufferDescSetRange(hitDesc, 11, 211));
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    ASSERT_RTP(rtpQueryExecute(query, 0));
    const std::vector<Hit>& all = out.read();
    const std::vector<Hit> hits(all.begin() + 11, all.begin() + 211);
    EXPECT_EQ(wrongHits(mesh, {rays.begin() + 50, rays.begin() + 250}, hits), 0u);
    for (size_t i = 0; i < all.size(); ++i)
        if (i < 11 || i >= 211) {
            EXPECT_EQ(all[i].t, 7) << i;
        }
}

TEST_P(PrimeQueries, Float4VerticesAndFlatLists) {
    const Mesh mesh = soup(200, 0.3f, 1);
    std::vector<float> vertices;
    for (const Float3& p : mesh.vertices)
        vertices.insert(vertices.end(), {p.x, p.y, p.z, NAN});
    Buffer<float> buffer(memory(), vertices);
    const Desc desc(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT4, memory(), buffer.address(),
                    mesh.vertices.size());
    RTPmodel model = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &model));
    ASSERT_RTP(rtpModelSetTriangles(model, nullptr, desc));
    ASSERT_RTP(rtpModelUpdate(model, 0));
    const std::vector<Ray> rays = randomRays(500, 9);
    EXPECT_EQ(wrongHits(mesh, rays, trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory())), 0u);
    // The range of a flat list selects triangles; ids count from its begin.
    ASSERT_RTP(rtpBufferDescSetRange(desc, 30, 330));
    ASSERT_RTP(rtpModelSetTriangles(model, nullptr, desc));
    ASSERT_RTP(rtpModelUpdate(model, 0));
    Mesh part = mesh;
    part.triangles.assign(mesh.triangles.begin() + 10, mesh.triangles.begin() + 110);
    EXPECT_EQ(wrongHits(part, rays, trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory())), 0u);
}

TEST_P(PrimeQueries, RaysThatCannotHitMiss) {
    const RTPmodel model = makeModel(soup(300, 0.4f, 1), memory());
    std::vector<Ray> rays = randomRays(12, 10);
    rays[0].origin.x = NAN;
    rays[1].direction.y = NAN;
    rays[2].tmin = NAN;
    rays[3].tmax = NAN;
    rays[4].direction = {0, 0, 0};
    rays[5].origin.z = INFINITY;
    rays[6].direction.x = -INFINITY;
    rays[7].tmin = 2;
    rays[7].tmax = 1;
    rays[8].tmax = -1;
    for (const RTPquerytype type : {RTP_QUERY_TYPE_ANY, RTP_QUERY_TYPE_CLOSEST}) {
        const std::vector<Hit> hits = trace(model, rays, type, memory());
        for (size_t i = 0; i < 9; ++i) {
            EXPECT_EQ(hits[i].t, -1) << i;
            EXPECT_EQ(hits[i].triangle, -1);
            EXPECT_EQ(hits[i].instance, -1);
        }
    }
}

TEST_P(PrimeQueries, EmptyModelsAndEmptyRanges) {
    const RTPmodel model = makeModel(soup(3, 0.3f, 1), memory());
    EXPECT_EQ(trace(model, {}, RTP_QUERY_TYPE_ANY, RTP_BUFFER_TYPE_HOST).size(), 0u);
    const Mesh mesh = soup(3, 0.3f, 1);
    Buffer<Float3> vertices(memory(), mesh.vertices);
    const Desc desc(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, memory(), vertices.address(), 0);
    RTPmodel empty = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &empty));
    ASSERT_RTP(rtpModelSetTriangles(empty, nullptr, desc));
    ASSERT_RTP(rtpModelUpdate(empty, 0));
    for (const Hit& hit : trace(empty, randomRays(40, 2), RTP_QUERY_TYPE_CLOSEST, memory()))
        EXPECT_EQ(hit.t, -1);
}

// Triangles with NaN vertices or indices out of range are never hit.
TEST_P(PrimeQueries, InvalidTrianglesAreNeverHit) {
    Mesh mesh = soup(100, 0.4f, 1);
    const Mesh good = mesh;
    mesh.vertices.push_back({NAN, 0, 0});
    const int nan = int(mesh.vertices.size()) - 1;
    mesh.triangles.insert(mesh.triangles.end(),
                          {{nan, 0, 1}, {0, 1, 1000000}, {-1, 0, 1}, {5, 5, 5}});
    const std::vector<Ray> rays = randomRays(500, 3);
    const std::vector<Hit> hits =
        trace(makeModel(mesh, memory()), rays, RTP_QUERY_TYPE_CLOSEST, memory());
    EXPECT_EQ(wrongHits(good, rays, hits), 0u);
}

struct Matrices {
    std::vector<float> rows; // 16 a matrix
    const float* operator[](size_t i) const { return &rows[16 * i]; }
};
Matrices spread(size_t count) {
    Matrices m;
    for (size_t i = 0; i < count; ++i) {
        const float a = float(i) * 0.7f, s = 0.5f + 0.1f * float(i % 3);
        const float c = std::cos(a) * s, n = std::sin(a) * s;
        m.rows.insert(m.rows.end(), {c, -n, 0, float(i % 3) - 1, n, c, 0.1f, float(i / 3 % 3) - 1,
                                     0, 0, s, 0.2f * float(i), 9, 9, 9, 9});
    }
    return m;
}

TEST_P(PrimeQueries, InstancesOfModels) {
    const std::vector<Mesh> meshes = {soup(60, 0.4f, 1), soup(90, 0.3f, 2)};
    const std::vector<RTPmodel> models = {makeModel(meshes[0], memory()),
                                          makeModel(meshes[1], memory())};
    constexpr size_t kCount = 8;
    const Matrices matrices = spread(kCount);
    std::vector<RTPmodel> list;
    Mesh flat; // the same triangles; which instance and triangle each is
    std::vector<std::pair<int, int>> ids;
    std::vector<float> rows43;
    for (size_t i = 0; i < kCount; ++i) {
        list.push_back(models[i % 2]);
        rows43.insert(rows43.end(), matrices[i], matrices[i] + 12);
        const Mesh part = moved(meshes[i % 2], matrices[i]);
        const int base = int(flat.vertices.size());
        flat.vertices.insert(flat.vertices.end(), part.vertices.begin(), part.vertices.end());
        for (const Int3& t : part.triangles) {
            ids.push_back({int(i), int(&t - part.triangles.data())});
            flat.triangles.push_back({t.x + base, t.y + base, t.z + base});
        }
    }
    const std::vector<Ray> rays = randomRays(1500, 11);
    Buffer<float> all(memory(), matrices.rows), three(memory(), rows43);
    const Desc instances(context, RTP_BUFFER_FORMAT_INSTANCE_MODEL, RTP_BUFFER_TYPE_HOST,
                         list.data(), kCount);
    const Desc full(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4, memory(), all.address(), kCount);
    const Desc packed(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, memory(), three.address(),
                      kCount);
    const Desc strided(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, memory(), all.address(),
                       kCount);
    ASSERT_RTP(rtpBufferDescSetStride(strided, 64));
    for (const RTPbufferdesc transforms :
         {RTPbufferdesc(full), RTPbufferdesc(packed), RTPbufferdesc(strided)}) {
        RTPmodel top = nullptr;
        ASSERT_RTP(rtpModelCreate(context, &top));
        ASSERT_RTP(rtpModelSetInstances(top, instances, transforms));
        ASSERT_RTP(rtpModelUpdate(top, RTP_MODEL_HINT_ASYNC)) << lastError();
        for (const bool any : {false, true}) {
            std::vector<Hit> hits =
                trace(top, rays, any ? RTP_QUERY_TYPE_ANY : RTP_QUERY_TYPE_CLOSEST, memory());
            size_t found = 0;
            for (Hit& hit : hits) {
                const auto place =
                    std::find(ids.begin(), ids.end(), std::pair(hit.instance, hit.triangle));
                if (hit.t >= 0) {
                    ++found;
                    ASSERT_NE(place, ids.end());
                    hit.triangle = int(place - ids.begin());
                }
            }
            EXPECT_EQ(wrongHits(flat, rays, hits, any), 0u);
            EXPECT_GT(found, 300u);
        }
        EXPECT_RTP(rtpModelDestroy(top));
    }
    // After the update of an instance model, the models of its instances may be destroyed.
    RTPmodel top = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &top));
    ASSERT_RTP(rtpModelSetInstances(top, instances, full));
    ASSERT_RTP(rtpModelUpdate(top, 0));
    const std::vector<Hit> before = trace(top, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    for (const RTPmodel model : models)
        ASSERT_RTP(rtpModelDestroy(model));
    const std::vector<Hit> after = trace(top, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    EXPECT_EQ(std::memcmp(before.data(), after.data(), before.size() * sizeof(Hit)), 0);
}

TEST_P(PrimeQueries, MasksOfInstances) {
    const Mesh mesh = soup(100, 0.4f, 1);
    const auto maskOf = [](int i) { return 1 << i % 2; };
    MaskedModel masked(context, memory(), mesh, maskOf);
    const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    RTPmodel list[1] = {masked.model};
    const Desc instances(context, RTP_BUFFER_FORMAT_INSTANCE_MODEL, RTP_BUFFER_TYPE_HOST, list, 1);
    const Desc transforms(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, RTP_BUFFER_TYPE_HOST,
                          const_cast<float*>(identity), 1);
    RTPmodel top = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &top));
    ASSERT_RTP(rtpModelSetInstances(top, instances, transforms));
    ASSERT_RTP(rtpModelUpdate(top, 0));
    std::vector<Ray> rays = randomRays(500, 8);
    for (Ray& ray : rays) {
        ray.tmin = 0;
        ray.tmax = 1e30f;
    }
    for (const int mask : {1, 2, 3})
        EXPECT_EQ(wrongHits(visible(mesh, maskOf, mask), rays,
                            traceMasked(context, top, memory(), rays, mask)),
                  0u);
}

TEST_P(PrimeQueries, InstancesMixTrianglesWithAndWithoutMasks) {
    const Mesh mesh = soup(100, 0.4f, 1), plain = soup(100, 0.4f, 2);
    const auto maskOf = [](int i) { return 1 << i % 2; };
    MaskedModel masked(context, memory(), mesh, maskOf);
    RTPmodel list[2] = {masked.model, makeModel(plain, memory())};
    float rows[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const Desc instances(context, RTP_BUFFER_FORMAT_INSTANCE_MODEL, RTP_BUFFER_TYPE_HOST, list, 2);
    const Desc transforms(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, RTP_BUFFER_TYPE_HOST, rows,
                          2);
    RTPmodel top = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &top));
    ASSERT_RTP(rtpModelSetInstances(top, instances, transforms));
    ASSERT_RTP(rtpModelUpdate(top, 0));
    std::vector<Ray> rays = randomRays(500, 8);
    for (Ray& ray : rays) {
        ray.tmin = 0;
        ray.tmax = 1e30f;
    }
    for (const int mask : {1, 2, 4}) {
        Mesh both = visible(mesh, maskOf, mask);
        const int first = int(both.vertices.size()), triangles = int(both.triangles.size());
        both.vertices.insert(both.vertices.end(), plain.vertices.begin(), plain.vertices.end());
        for (const Int3& t : plain.triangles)
            both.triangles.push_back({t.x + first, t.y + first, t.z + first});
        std::vector<Hit> hits = traceMasked(context, top, memory(), rays, mask);
        for (Hit& hit : hits)
            if (hit.instance == 1) {
                hit.triangle += triangles;
                hit.instance = 0;
            }
        EXPECT_EQ(wrongHits(both, rays, hits), 0u) << mask;
    }
}

// Equal rays in one call and in many calls have equal hits, whatever rays are beside them.
TEST_P(PrimeQueries, HitsDoNotDependOnTheBatch) {
    const RTPmodel model = makeModel(soup(300, 0.3f, 1), memory());
    const std::vector<Ray> rays = randomRays(130, 12);
    const std::vector<Hit> together = trace(model, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    for (size_t i = 0; i < rays.size(); i += 10) {
        const std::vector<Hit> alone = trace(model, {rays[i]}, RTP_QUERY_TYPE_CLOSEST, memory());
        EXPECT_EQ(std::memcmp(&alone[0], &together[i], sizeof(Hit)), 0);
    }
}

TEST_P(PrimeQueries, CopiesOfModels) {
    const Mesh mesh = soup(200, 0.3f, 1);
    const std::vector<Ray> rays = randomRays(500, 13);
    const RTPmodel source = makeModel(mesh, memory());
    const std::vector<Hit> expected = trace(source, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    RTPcontext other = nullptr;
    ASSERT_RTP(rtpContextCreate(GetParam().context, &other));
    std::swap(context, other); // copies belong to the second context
    RTPmodel copy = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &copy));
    ASSERT_RTP(rtpModelCopy(copy, source));
    EXPECT_RTP(rtpModelDestroy(source));
    EXPECT_EQ(rtpContextDestroy(other), RTP_SUCCESS);
    const std::vector<Hit> hits = trace(copy, rays, RTP_QUERY_TYPE_CLOSEST, memory());
    EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0);
    RTPmodel again = nullptr; // within one context
    ASSERT_RTP(rtpModelCreate(context, &again));
    ASSERT_RTP(rtpModelCopy(again, copy));
    EXPECT_EQ(wrongHits(mesh, rays, trace(again, rays, RTP_QUERY_TYPE_CLOSEST, memory())), 0u);
}

TEST_P(PrimeQueries, CallerTrianglesAreSetAfterACopy) {
    const Mesh mesh = soup(200, 0.3f, 1);
    const std::vector<Ray> rays = randomRays(500, 14);
    Buffer<Float3> vertices(memory(), mesh.vertices);
    Buffer<Int3> indices(memory(), mesh.triangles);
    const Desc vertexDesc(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, memory(), vertices);
    const Desc indexDesc(context, RTP_BUFFER_FORMAT_INDICES_INT3, memory(), indices);
    const int yes = 1;
    RTPmodel source = nullptr, copy = nullptr, whole = nullptr;
    for (RTPmodel* model : {&source, &copy, &whole})
        ASSERT_RTP(rtpModelCreate(context, model));
    for (const RTPmodel model : {source, copy})
        ASSERT_RTP(rtpModelSetBuilderParameter(model, RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES,
                                               sizeof(yes), &yes));
    ASSERT_RTP(rtpModelSetTriangles(source, indexDesc, vertexDesc));
    ASSERT_RTP(rtpModelUpdate(source, 0));
    EXPECT_EQ(
        wrongHits(mesh, rays,
                  trace(source, rays, RTP_QUERY_TYPE_CLOSEST, memory(), RTP_QUERY_HINT_WATERTIGHT)),
        0u);
    // Without the flag at the destination the triangles are copied.
    ASSERT_RTP(rtpModelCopy(whole, source));
    EXPECT_EQ(wrongHits(mesh, rays, trace(whole, rays, RTP_QUERY_TYPE_CLOSEST, memory())), 0u);
    // With it they must be set.
    ASSERT_RTP(rtpModelCopy(copy, source));
    RTPquery query = nullptr;
    Buffer<Ray> in(memory(), rays);
    Buffer<Hit> out(memory(), std::vector<Hit>(rays.size()));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, memory(), in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, memory(), out);
    ASSERT_RTP(rtpQueryCreate(copy, RTP_QUERY_TYPE_CLOSEST, &query));
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    EXPECT_EQ(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_OPERATION);
    EXPECT_EQ(rtpModelUpdate(copy, RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET),
              RTP_ERROR_INVALID_OPERATION);
    ASSERT_RTP(rtpModelSetTriangles(copy, indexDesc, vertexDesc));
    ASSERT_RTP(
        rtpModelUpdate(copy, RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET | RTP_MODEL_HINT_ASYNC));
    ASSERT_RTP(rtpQueryExecute(query, 0));
    EXPECT_EQ(wrongHits(mesh, rays, out.read()), 0u);
    // Not a second time, and not for other models.
    EXPECT_EQ(rtpModelUpdate(copy, RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET),
              RTP_ERROR_INVALID_OPERATION);
}

INSTANTIATE_TEST_SUITE_P(All, PrimeQueries, testing::ValuesIn(setups()), nameOf);

} // namespace
} // namespace prime_test
