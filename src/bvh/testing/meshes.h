// SPDX-License-Identifier: Apache-2.0
// For tests: meshes, random numbers, a buffer pair for builds, and a reference for hits in double
// precision that tests every triangle.
#pragma once

#include "bvh/build/build.h"
#include "bvh/walk/kernels.h"
#include "math/vec3.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <random>
#include <vector>

namespace sunstone::bvh::testing {

using math::Vec3;

struct Mesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<uint32_t, 3>> triangles;

    TriangleInput input() const {
        TriangleInput in;
        in.vertices = vertices.data();
        in.numVertices = uint32_t(vertices.size());
        in.indices = triangles.data();
        in.indexFormat = IndexFormat::kUint3;
        in.numTriangles = uint32_t(triangles.size());
        return in;
    }
};

class Random {
public:
    explicit Random(uint32_t seed) : engine_(seed) {}
    float operator()(float low, float high) {
        return low + (high - low) * float(engine_() >> 8) * 0x1p-24f;
    }
    uint32_t below(uint32_t n) { return uint32_t(uint64_t(engine_()) * n >> 32); }
    Vec3 point(float extent) {
        return {(*this)(-extent, extent), (*this)(-extent, extent), (*this)(-extent, extent)};
    }
    Vec3 unit() {
        for (;;) {
            const Vec3 p = point(1);
            const float l = math::length(p);
            if (l > 0.1f && l <= 1)
                return p * (1 / l);
        }
    }

private:
    std::mt19937 engine_;
};

inline std::shared_ptr<void> alignedBuffer(size_t size) {
    return {std::aligned_alloc(128, (size + 127) / 128 * 128), std::free};
}

// A built structure in a buffer of exactly its compacted size.
struct Structure {
    std::shared_ptr<void> memory;
    size_t size = 0;

    const void* block() const { return memory.get(); }
    bool operator==(const Structure& other) const {
        return size == other.size && std::memcmp(block(), other.block(), size) == 0;
    }
};

inline Structure makeStructure(const BuildInputs& inputs, const BuildOptions& options = {}) {
    const MemoryUsage usage = computeMemoryUsage(inputs, options);
    const auto temp = alignedBuffer(usage.temp), output = alignedBuffer(usage.output);
    build(inputs, options, temp.get(), usage.temp, output.get(), usage.output);
    Structure s;
    s.size = compactedSize(output.get());
    s.memory = alignedBuffer(s.size);
    compact(output.get(), s.memory.get(), s.size);
    return s;
}

inline Structure makeStructure(const TriangleInput& input, const BuildOptions& options = {}) {
    BuildInputs inputs;
    inputs.triangles = {&input, 1};
    return makeStructure(inputs, options);
}

// ---- meshes ----

inline Mesh soup(uint32_t count, float size, uint32_t seed) {
    Random random(seed);
    Mesh m;
    for (uint32_t i = 0; i < count; ++i) {
        const Vec3 center = random.point(1);
        for (int k = 0; k < 3; ++k)
            m.vertices.push_back(center + random.point(size));
        m.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return m;
}

// Long thin triangles, whose references builds with PREFER_FAST_TRACE split.
inline Mesh needles(uint32_t count, uint32_t seed) {
    Random random(seed);
    Mesh m;
    for (uint32_t i = 0; i < count; ++i) {
        const Vec3 from = random.point(1), along = random.unit() * random(0.2f, 1.5f);
        m.vertices.insert(m.vertices.end(),
                          {from, from + along, from + along * 0.5f + random.point(0.01f)});
        m.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return m;
}

inline Mesh cube() {
    Mesh m;
    for (int i = 0; i < 8; ++i)
        m.vertices.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
    m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return m;
}

inline Mesh icosphere(int levels) {
    const float p = 1.6180339887f;
    Mesh m;
    m.vertices = {{-1, p, 0}, {1, p, 0}, {-1, -p, 0}, {1, -p, 0}, {0, -1, p}, {0, 1, p},
                  {0, -1, -p}, {0, 1, -p}, {p, 0, -1}, {p, 0, 1}, {-p, 0, -1}, {-p, 0, 1}};
    m.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11},
                   {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                   {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9},
                   {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}};
    for (Vec3& v : m.vertices)
        v = math::normalize(v);
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto middle = [&](uint32_t a, uint32_t b) {
            const auto key = std::minmax(a, b);
            const auto [at, isNew] = middles.try_emplace(key, uint32_t(m.vertices.size()));
            if (isNew)
                m.vertices.push_back(math::normalize(m.vertices[a] + m.vertices[b]));
            return at->second;
        };
        std::vector<std::array<uint32_t, 3>> finer;
        for (const auto& t : m.triangles) {
            const uint32_t a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
            finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
        }
        m.triangles = finer;
    }
    return m;
}

// A sphere whose points move in and out at random: still wholly visible from its center.
inline Mesh roughSphere(int levels, uint32_t seed) {
    Random random(seed);
    Mesh m = icosphere(levels);
    for (Vec3& v : m.vertices)
        v = v * random(0.6f, 1.4f);
    return m;
}

inline Mesh torus(uint32_t n, uint32_t k) {
    Mesh m;
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < k; ++j) {
            const float a = 6.2831853f * float(i) / float(n), b = 6.2831853f * float(j) / float(k);
            const float r = 1 + 0.35f * std::cos(b);
            m.vertices.push_back({r * std::cos(a), 0.35f * std::sin(b), r * std::sin(a)});
            const uint32_t i1 = (i + 1) % n, j1 = (j + 1) % k;
            m.triangles.push_back({i * k + j, i * k + j1, i1 * k + j});
            m.triangles.push_back({i1 * k + j, i * k + j1, i1 * k + j1});
        }
    return m;
}

// ---- the judge ----

struct ExactHit {
    double t, margin; // margin: least barycentric coordinate; below 0 outside
};

// The hit of the line; t is infinite for parallel lines.
inline ExactHit exactHit(const QueryRay& ray, const Vec3 v[3]) {
    double e1[3], e2[3], s[3], d[3];
    for (int i = 0; i < 3; ++i) {
        e1[i] = double(v[1][i]) - v[0][i];
        e2[i] = double(v[2][i]) - v[0][i];
        s[i] = double(ray.origin[i]) - v[0][i];
        d[i] = ray.direction[i];
    }
    const auto cross = [](const double a[3], const double b[3], double c[3]) {
        c[0] = a[1] * b[2] - a[2] * b[1];
        c[1] = a[2] * b[0] - a[0] * b[2];
        c[2] = a[0] * b[1] - a[1] * b[0];
    };
    const auto dot = [](const double a[3], const double b[3]) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    };
    double p[3], q[3];
    cross(d, e2, p);
    cross(s, e1, q);
    const double det = dot(e1, p);
    if (det == 0)
        return {INFINITY, -INFINITY};
    const double u = dot(s, p) / det, w = dot(d, q) / det;
    return {dot(e2, q) / det, std::min({u, w, 1 - u - w})};
}

} // namespace sunstone::bvh::testing
