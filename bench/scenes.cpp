// SPDX-License-Identifier: Apache-2.0
#include "scenes.h"

#include "launch_rays.h"

#include <algorithm>
#include <cmath>

namespace bench {
namespace {

struct V {
    float x, y, z;
};
V operator+(V a, V b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
V operator-(V a, V b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
V operator*(V a, float s) {
    return {a.x * s, a.y * s, a.z * s};
}
float dot(V a, V b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
V cross(V a, V b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
V unit(V a) {
    return a * (1 / std::sqrt(dot(a, a)));
}

uint32_t hash(uint32_t a, uint32_t b) {
    uint64_t x = (uint64_t(a) << 32 | b) + 0x9E3779B97F4A7C15ull;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ x >> 27) * 0x94D049BB133111EBull;
    return uint32_t((x ^ x >> 31) >> 16);
}
float random(uint32_t a, uint32_t b) {
    return float(hash(a, b) >> 8) * 0x1p-24f;
}
V randomUnit(uint32_t a, uint32_t b) {
    const float z = 2 * random(a, 2 * b) - 1, phi = 6.2831853f * random(a, 2 * b + 1);
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
}

void add(Mesh& m, V v) {
    m.vertices.insert(m.vertices.end(), {v.x, v.y, v.z});
}
void add(Mesh& m, uint32_t a, uint32_t b, uint32_t c) {
    m.indices.insert(m.indices.end(), {a, b, c});
}

void look(Mesh& m, V eye, V target) {
    m.eye[0] = eye.x, m.eye[1] = eye.y, m.eye[2] = eye.z;
    m.target[0] = target.x, m.target[1] = target.y, m.target[2] = target.z;
}

// Smooth noise of a lattice of random values.
float noise(float x, float y, uint32_t seed) {
    const float fx = std::floor(x), fy = std::floor(y);
    const auto at = [&](int i, int j) {
        return random(seed, hash(uint32_t(int(fx) + i), uint32_t(int(fy) + j)));
    };
    const auto smooth = [](float t) { return t * t * (3 - 2 * t); };
    const float u = smooth(x - fx), v = smooth(y - fy);
    return (at(0, 0) * (1 - u) + at(1, 0) * u) * (1 - v) + (at(0, 1) * (1 - u) + at(1, 1) * u) * v;
}

Mesh terrain(uint32_t triangles) {
    Mesh m;
    m.name = "terrain";
    const uint32_t n = std::max(1u, uint32_t(std::sqrt(triangles / 2.0)));
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i) {
            const float x = float(i) / float(n) * 100, y = float(j) / float(n) * 100;
            float height = 0, scale = 0.05f, weight = 12;
            for (uint32_t octave = 0; octave < 9; ++octave, scale *= 2, weight *= 0.5f)
                height += weight * noise(x * scale, y * scale, octave);
            add(m, {x - 50, height, y - 50});
        }
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            add(m, a, c, b);
            add(m, b, c, d);
        }
    look(m, {-48, 34, -48}, {10, 4, 10});
    m.aoRadius = 5;
    return m;
}

Mesh randomTriangles(uint32_t triangles, float length, float width, const char* name) {
    Mesh m;
    m.name = name;
    for (uint32_t i = 0; i < triangles; ++i) {
        const V center = {random(i, 1) * 2 - 1, random(i, 2) * 2 - 1, random(i, 3) * 2 - 1};
        const V along = randomUnit(i, 10) * length;
        const V across = unit(cross(along, randomUnit(i, 11) + V{1e-3f, 0, 0})) * width;
        add(m, center - along * 0.5f);
        add(m, center + along * 0.5f);
        add(m, center + across);
        add(m, 3 * i, 3 * i + 1, 3 * i + 2);
    }
    look(m, {-2.2f, 1.3f, -2.6f}, {0, 0, 0});
    m.fovDegrees = 50;
    m.aoRadius = 0.2f;
    return m;
}

// A sphere of `slices` around the y axis and `stacks` along it; radiusAt(direction) gives its
// shape.
template <class Radius>
void addSphere(Mesh& m, V center, uint32_t slices, uint32_t stacks, const Radius& radiusAt) {
    const uint32_t base = m.numVertices();
    for (uint32_t j = 0; j <= stacks; ++j)
        for (uint32_t i = 0; i < slices; ++i) {
            const float theta = 3.14159265f * float(j) / float(stacks);
            const float phi = 6.2831853f * float(i) / float(slices);
            const V d = {std::sin(theta) * std::cos(phi), std::cos(theta),
                         std::sin(theta) * std::sin(phi)};
            add(m, center + d * radiusAt(d));
        }
    for (uint32_t j = 0; j < stacks; ++j)
        for (uint32_t i = 0; i < slices; ++i) {
            const uint32_t a = base + j * slices + i;
            const uint32_t b = base + j * slices + (i + 1) % slices;
            if (j > 0)
                add(m, a, b, a + slices);
            if (j + 1 < stacks)
                add(m, b, b + slices, a + slices);
        }
}

Mesh spheres(uint32_t triangles) {
    Mesh m;
    m.name = "spheres";
    constexpr uint32_t kSlices = 50, kStacks = 26; // 2500 triangles each
    const uint32_t count = std::max(1u, triangles / (2 * kSlices * (kStacks - 1)));
    for (uint32_t s = 0; s < count; ++s) {
        const V center = {random(s, 1) * 100 - 50, random(s, 2) * 20, random(s, 3) * 100 - 50};
        const float radius = 0.4f + 1.2f * random(s, 4);
        addSphere(m, center, kSlices, kStacks, [&](V) { return radius; });
    }
    lookOverSlab(m);
    m.aoRadius = 5;
    return m;
}

Mesh overlapping(uint32_t triangles) {
    Mesh m;
    m.name = "overlap";
    for (uint32_t i = 0; i < triangles; ++i) {
        const V center = {random(i, 1) * 2 - 1, random(i, 2) * 2 - 1, random(i, 3) * 2 - 1};
        const float u = random(i, 4), size = 0.004f * std::pow(100.0f, u * u * u);
        for (uint32_t k = 0; k < 3; ++k)
            add(m, center + randomUnit(i, 10 + k) * size);
        add(m, 3 * i, 3 * i + 1, 3 * i + 2);
    }
    look(m, {-2.2f, 1.3f, -2.6f}, {0, 0, 0});
    m.fovDegrees = 50;
    m.aoRadius = 0.2f;
    return m;
}

// pointAt(u, v) for u and v in [0, 1].
template <class Point>
void addSheet(Mesh& m, uint32_t columns, uint32_t rows, const Point& pointAt) {
    const uint32_t base = m.numVertices();
    for (uint32_t j = 0; j <= rows; ++j)
        for (uint32_t i = 0; i <= columns; ++i)
            add(m, pointAt(float(i) / float(columns), float(j) / float(rows)));
    for (uint32_t j = 0; j < rows; ++j)
        for (uint32_t i = 0; i < columns; ++i) {
            const uint32_t a = base + j * (columns + 1) + i, b = a + 1, c = a + columns + 1;
            add(m, a, c, b);
            add(m, b, c, c + 1);
        }
}

void addBox(Mesh& m, V low, V high) {
    const V d = high - low;
    for (uint32_t axis = 0; axis < 3; ++axis)
        for (const float side : {0.0f, 1.0f})
            addSheet(m, 1, 1, [&](float u, float v) {
                const float c[3] = {axis == 0 ? side : u,
                                    axis == 1   ? side
                                    : axis == 0 ? u
                                                : v,
                                    axis == 2 ? side : v};
                return low + V{c[0] * d.x, c[1] * d.y, c[2] * d.z};
            });
}

// A hall of 60 x 12 x 24.
Mesh interior(uint32_t triangles) {
    Mesh m;
    m.name = "interior";
    const float detail = std::sqrt(float(triangles) / 1e6f);
    const auto parts = [&](float count) { return uint32_t(std::max(3.0f, count * detail)); };
    addBox(m, {-30, 0, -12}, {30, 12, 12});
    for (uint32_t beam = 0; beam < 60; ++beam)
        addBox(m, {float(beam) - 30, 11.2f, -12}, {float(beam) - 29.8f, 11.6f, 12});
    for (uint32_t step = 0; step < 20; ++step)
        addBox(m, {24 + 0.3f * float(step), 0, -4}, {30, 0.2f * float(step + 1), 4});
    for (uint32_t i = 0; i < 24; ++i) { // fluted columns
        const V foot = {5 * float(i / 2) - 27.5f, 0, i % 2 ? 7.0f : -7.0f};
        addSheet(m, parts(80), parts(80), [&](float u, float v) {
            const float phi = 6.2831853f * u, r = 0.6f + 0.05f * std::cos(20 * phi);
            return foot + V{r * std::cos(phi), 11.2f * v, r * std::sin(phi)};
        });
    }
    for (uint32_t i = 0; i < 60; ++i) // vases
        addSphere(m, {random(i, 1) * 44 - 24, 0.3f, random(i, 2) * 20 - 10}, parts(80), parts(40),
                  [&](V d) { return 0.3f + 0.03f * std::cos(12 * d.y); });
    for (uint32_t i = 0; i < 24; ++i) { // curtains
        const float x = 5 * float(i / 2) - 25.0f, z = i % 2 ? 11.5f : -11.5f;
        addSheet(m, parts(110), parts(50), [&](float u, float v) {
            return V{x + 2.5f * u, 0.2f + 9 * v, z + 0.15f * std::sin(60 * u + 3 * v)};
        });
    }
    look(m, {-27, 3, -3}, {10, 3, 2});
    m.fovDegrees = 70;
    m.aoRadius = 3;
    return m;
}

V at(const float p[3]) {
    return {p[0], p[1], p[2]};
}

} // namespace

Mesh makeScene(SceneKind kind, uint32_t triangles) {
    switch (kind) {
    case SceneKind::kTerrain:
        return terrain(triangles);
    case SceneKind::kSoup:
        return randomTriangles(triangles, 0.02f, 0.015f, "soup");
    case SceneKind::kLongThin:
        return randomTriangles(triangles, 0.4f, 0.001f, "long thin");
    case SceneKind::kOverlapping:
        return overlapping(triangles);
    case SceneKind::kInterior:
        return interior(triangles);
    case SceneKind::kLeaves:
        return makeLeaves(triangles);
    default:
        return spheres(triangles);
    }
}

std::vector<Ray> primaryRays(const Mesh& mesh, uint32_t width, uint32_t height) {
    const V eye = at(mesh.eye), forward = unit(at(mesh.target) - eye);
    const V right = unit(cross(forward, {0, 1, 0})), up = cross(right, forward);
    const float tangent = std::tan(mesh.fovDegrees * 0.00872664626f);
    const float aspect = float(width) / float(height);
    std::vector<Ray> rays;
    rays.reserve(size_t(width) * height);
    for (uint32_t ty = 0; ty < height; ty += 8)
        for (uint32_t tx = 0; tx < width; tx += 8)
            for (uint32_t y = ty; y < std::min(height, ty + 8); ++y)
                for (uint32_t x = tx; x < std::min(width, tx + 8); ++x) {
                    const float sx = (2 * (float(x) + 0.5f) / float(width) - 1) * tangent * aspect;
                    const float sy = (1 - 2 * (float(y) + 0.5f) / float(height)) * tangent;
                    const V d = unit(forward + right * sx + up * sy);
                    rays.push_back({{eye.x, eye.y, eye.z}, 0, {d.x, d.y, d.z}, 1e16f});
                }
    return rays;
}

std::vector<Ray> secondaryRays(const Mesh& mesh, const std::vector<Ray>& primary,
                               const std::vector<SurfacePoint>& points, RayKind kind) {
    std::vector<Surfel> surfels(points.size());
    for (size_t i = 0; i < points.size(); ++i) {
        surfels[i] = {points[i].hit, points[i].t, {}};
        if (!points[i].hit)
            continue;
        const uint32_t* index = &mesh.indices[3 * size_t(points[i].triangle)];
        const V a = at(&mesh.vertices[3 * size_t(index[0])]);
        const V b = at(&mesh.vertices[3 * size_t(index[1])]);
        const V c = at(&mesh.vertices[3 * size_t(index[2])]);
        const V normal = cross(b - a, c - a);
        surfels[i].normal[0] = normal.x;
        surfels[i].normal[1] = normal.y;
        surfels[i].normal[2] = normal.z;
    }
    return secondaryRays(primary, surfels, mesh.aoRadius, kind);
}

std::vector<Ray> secondaryRays(const std::vector<Ray>& primary, const std::vector<Surfel>& points,
                               float aoRadius, RayKind kind) {
    std::vector<Ray> rays;
    rays.reserve(primary.size());
    const V light = unit({0.4f, 0.8f, -0.3f});
    for (size_t i = 0; i < primary.size(); ++i) {
        if (!points[i].hit)
            continue;
        const V in = at(primary[i].direction);
        V normal = unit(at(points[i].normal));
        if (dot(normal, in) > 0)
            normal = normal * -1;
        const V p = at(primary[i].origin) + in * points[i].t;
        V d = light;
        float length = 1e16f;
        if (kind != RayKind::kShadow) {
            d = unit(normal * 1.0001f + randomUnit(uint32_t(i), 77)); // cosine-distributed
            if (kind == RayKind::kAmbientOcclusion)
                length = aoRadius;
        }
        rays.push_back({{p.x, p.y, p.z}, 1e-3f * aoRadius, {d.x, d.y, d.z}, length});
    }
    return rays;
}

std::vector<float> movedVertices(const Mesh& mesh) {
    float low = 1e30f, high = -1e30f;
    for (const float x : mesh.vertices) {
        low = std::min(low, x);
        high = std::max(high, x);
    }
    const float size = high - low, wave = 20 / size;
    std::vector<float> moved = mesh.vertices;
    for (size_t i = 0; i < mesh.vertices.size(); ++i) {
        const size_t other = i / 3 * 3 + (i + 1) % 3;
        moved[i] += 0.03f * size * std::sin(mesh.vertices[other] * wave + float(i % 3));
    }
    moved.resize(moved.size() + 4); // Embree reads 16 bytes at the last vertex
    return moved;
}

float timeOf(size_t ray) {
    return timeOfRay(unsigned(ray));
}

Mesh makeRock(uint32_t triangles) {
    Mesh m;
    m.name = "rock";
    const uint32_t stacks = std::max(3u, uint32_t(std::sqrt(triangles / 4.0)));
    addSphere(m, {0, 0, 0}, 2 * stacks, stacks,
              [](V d) { return 0.8f + 0.4f * noise(3 * d.x + 7 * d.y, 3 * d.z - 5 * d.y, 5); });
    m.aoRadius = 2;
    lookOverSlab(m);
    return m;
}

Mesh makeLeaves(uint32_t triangles) {
    Mesh m;
    m.name = "leaves";
    for (uint32_t i = 0; i < std::max(1u, triangles / 2); ++i) {
        const V center = {random(i, 1) * 100 - 50, random(i, 2) * 20, random(i, 3) * 100 - 50};
        const V u = randomUnit(i, 20) * 0.8f;
        const V v = unit(cross(u, randomUnit(i, 21) + V{1e-3f, 0, 0})) * 0.5f;
        const V corner = center - (u + v) * 0.5f;
        add(m, corner);
        add(m, corner + u);
        add(m, corner + u + v);
        add(m, corner + v);
        add(m, 4 * i, 4 * i + 1, 4 * i + 2);
        add(m, 4 * i, 4 * i + 2, 4 * i + 3);
    }
    m.aoRadius = 5;
    lookOverSlab(m);
    return m;
}

std::vector<float> makeBalls(uint32_t count, Mesh& view) {
    std::vector<float> balls;
    for (uint32_t i = 0; i < count; ++i)
        balls.insert(balls.end(), {random(i, 1) * 2 - 1, random(i, 2) * 2 - 1, random(i, 3) * 2 - 1,
                                   0.002f + 0.008f * random(i, 4)});
    look(view, {-2.2f, 1.3f, -2.6f}, {0, 0, 0});
    view.fovDegrees = 50;
    view.aoRadius = 0.2f;
    return balls;
}

void lookOverSlab(Mesh& mesh) {
    look(mesh, {-70, 40, -70}, {0, 8, 0});
}

std::vector<float> scatter(uint32_t count) {
    std::vector<float> matrices;
    for (uint32_t i = 0; i < count; ++i) {
        const V center = {random(i, 1) * 100 - 50, random(i, 2) * 20, random(i, 3) * 100 - 50};
        const V x = randomUnit(i, 20), y = unit(cross(x, randomUnit(i, 21) + V{1e-3f, 0, 0}));
        const V z = cross(x, y);
        const float s = 0.4f + 0.8f * random(i, 4);
        matrices.insert(matrices.end(), {s * x.x, s * y.x, s * z.x, center.x, //
                                         s * x.y, s * y.y, s * z.y, center.y, //
                                         s * x.z, s * y.z, s * z.z, center.z});
    }
    return matrices;
}

} // namespace bench
