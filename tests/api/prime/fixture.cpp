// SPDX-License-Identifier: Apache-2.0
#include "fixture.h"

#ifdef PRIME_TEST_CUDA
#include "cuda.h"
#endif

#include <algorithm>
#include <stdexcept>

namespace prime_test {

#ifdef PRIME_TEST_CUDA
std::vector<Setup> setups() {
    return {{RTP_CONTEXT_TYPE_CUDA, RTP_BUFFER_TYPE_HOST},
            {RTP_CONTEXT_TYPE_CUDA, RTP_BUFFER_TYPE_CUDA_LINEAR}};
}

static void check(CUresult result) {
    if (result != CUDA_SUCCESS)
        throw std::runtime_error("CUDA error " + std::to_string(int(result)));
}

void* deviceAlloc(size_t bytes) {
    CUdeviceptr address = 0;
    check(cuMemAlloc(&address, bytes));
    return reinterpret_cast<void*>(address);
}
void deviceFree(void* address) {
    cuMemFree(CUdeviceptr(address));
}
void copyToDevice(void* to, const void* from, size_t bytes) {
    if (bytes)
        check(cuMemcpyHtoD(CUdeviceptr(to), from, bytes));
}
void copyFromDevice(void* to, const void* from, size_t bytes) {
    if (bytes)
        check(cuMemcpyDtoH(to, CUdeviceptr(from), bytes));
}
#else
std::vector<Setup> setups() {
    return {{RTP_CONTEXT_TYPE_CPU, RTP_BUFFER_TYPE_HOST}};
}
void* deviceAlloc(size_t) {
    throw std::logic_error("no CUDA");
}
void deviceFree(void*) {}
void copyToDevice(void*, const void*, size_t) {}
void copyFromDevice(void*, const void*, size_t) {}
#endif

std::string nameOf(const testing::TestParamInfo<Setup>& info) {
    return testing::PrintToString(info.param);
}

Mesh soup(int triangles, float size, unsigned seed) {
    std::mt19937 random(seed);
    const auto number = [&](float extent) {
        return extent * (float(random() >> 8) * 0x1p-23f - 1);
    };
    Mesh mesh;
    for (int i = 0; i < triangles; ++i) {
        const Float3 c = {number(1), number(1), number(1)};
        for (int k = 0; k < 3; ++k)
            mesh.vertices.push_back({c.x + number(size), c.y + number(size), c.z + number(size)});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

std::vector<Ray> randomRays(size_t count, unsigned seed) {
    std::mt19937 random(seed);
    const auto number = [&] { return float(random() >> 8) * 0x1p-23f - 1; };
    std::vector<Ray> rays;
    while (rays.size() < count) {
        Ray ray = {{2 * number(), 2 * number(), 2 * number()}, 0, {}, 1e30f};
        Float3 d = {number() - ray.origin.x, number() - ray.origin.y, number() - ray.origin.z};
        const float length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
        if (length < 0.01f)
            continue;
        ray.direction = {d.x / length, d.y / length, d.z / length};
        if (random() % 4 == 0) {
            ray.tmin = 0.3f;
            ray.tmax = 1.5f;
        }
        rays.push_back(ray);
    }
    return rays;
}

Mesh moved(const Mesh& mesh, const float* m) {
    Mesh result = mesh;
    for (Float3& p : result.vertices)
        p = {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
             m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
             m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
    return result;
}

namespace {

struct D3 {
    double x, y, z;
};
D3 of(const Float3& a) {
    return {a.x, a.y, a.z};
}
D3 minus(D3 a, D3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
D3 cross(D3 a, D3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot(D3 a, D3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The distance, and the smallest of the three barycentric coordinates.
struct Candidate {
    double t, u, v, margin;
};
Candidate intersect(const Mesh& mesh, size_t triangle, const Ray& ray) {
    const Int3& i = mesh.triangles[triangle];
    const D3 a = of(mesh.vertices[size_t(i.x)]), d = of(ray.direction);
    const D3 e1 = minus(of(mesh.vertices[size_t(i.y)]), a),
             e2 = minus(of(mesh.vertices[size_t(i.z)]), a), s = minus(of(ray.origin), a);
    const D3 p = cross(d, e2), q = cross(s, e1);
    const double det = dot(e1, p), u = dot(s, p) / det, v = dot(d, q) / det;
    return {dot(e2, q) / det, u, v, std::min({u, v, 1 - u - v})};
}

} // namespace

size_t wrongHits(const Mesh& mesh, const std::vector<Ray>& rays, const std::vector<Hit>& hits,
                 bool any) {
    constexpr double kEdge = 1e-4, kFar = 1e-4;
    size_t wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        double clear = INFINITY; // nearest hit that no rounding can lose
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            const Candidate c = intersect(mesh, t, rays[i]);
            if (c.margin > kEdge && c.t > rays[i].tmin + kFar && c.t < rays[i].tmax - kFar)
                clear = std::min(clear, c.t);
        }
        const Hit& hit = hits[i];
        if (hit.t < 0) {
            wrong += clear < INFINITY || hit.t != -1 || hit.triangle != -1 || hit.instance != -1 ||
                     hit.u != 0 || hit.v != 0;
            continue;
        }
        if (size_t(hit.triangle) >= mesh.triangles.size()) {
            ++wrong;
            continue;
        }
        const Candidate c = intersect(mesh, size_t(hit.triangle), rays[i]);
        const bool fits = c.margin > -kEdge && std::fabs(c.t - double(hit.t)) < 1e-3 &&
                          std::fabs(c.u - double(hit.u)) < 1e-2 &&
                          std::fabs(c.v - double(hit.v)) < 1e-2;
        wrong += !fits || (!any && double(hit.t) > clear + 1e-3);
    }
    return wrong;
}

RTPmodel PrimeTest::makeModel(const Mesh& mesh, RTPbuffertype memory) {
    Buffer<Float3> vertices(memory, mesh.vertices);
    Buffer<Int3> indices(memory, mesh.triangles);
    const Desc vertexDesc(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, memory, vertices);
    const Desc indexDesc(context, RTP_BUFFER_FORMAT_INDICES_INT3, memory, indices);
    RTPmodel model = nullptr;
    EXPECT_RTP(rtpModelCreate(context, &model));
    EXPECT_RTP(rtpModelSetTriangles(model, indexDesc, vertexDesc));
    EXPECT_RTP(rtpModelUpdate(model, RTP_MODEL_HINT_NONE)) << lastError();
    return model;
}

std::vector<Hit> PrimeTest::trace(RTPmodel model, const std::vector<Ray>& rays, RTPquerytype type,
                                  RTPbuffertype memory, unsigned hints) {
    Buffer<Ray> in(memory, rays);
    Buffer<Hit> out(memory, std::vector<Hit>(rays.size(), Hit{7, 7, 7, 7, 7}));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, memory, in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, memory, out);
    RTPquery query = nullptr;
    EXPECT_RTP(rtpQueryCreate(model, type, &query));
    EXPECT_RTP(rtpQuerySetRays(query, rayDesc));
    EXPECT_RTP(rtpQuerySetHits(query, hitDesc));
    EXPECT_RTP(rtpQueryExecute(query, hints)) << lastError();
    EXPECT_RTP(rtpQueryFinish(query));
    EXPECT_RTP(rtpQueryDestroy(query));
    return out.read();
}

} // namespace prime_test
