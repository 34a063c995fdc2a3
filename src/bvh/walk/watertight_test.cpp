// SPDX-License-Identifier: Apache-2.0
// No ray may slip through a closed mesh: rays aimed at vertices and at points of edges, from inside
// (must hit) and from outside (crossings: in as often as out).
#include "bvh/testing/meshes.h"

#include <gtest/gtest.h>

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

// A vertex, or a point on an edge, of a random triangle.
Vec3 target(const Mesh& mesh, Random& random) {
    const auto& t = mesh.triangles[random.below(uint32_t(mesh.triangles.size()))];
    const uint32_t corner = random.below(3);
    const Vec3 a = mesh.vertices[t[corner]], b = mesh.vertices[t[(corner + 1) % 3]];
    if (random.below(4) == 0)
        return a;
    const float s = random.below(4) ? random(0, 1) : 0.5f;
    return a + (b - a) * s;
}

struct Setting {
    Vec3 offset;
    float scale;
};
const Setting kSettings[] = {
    {{0, 0, 0}, 1}, {{100, -37, 1000}, 1}, {{3, 5, 7}, 1e-3f}, {{-1e4f, 1e5f, 10}, 1e3f}};

Mesh placed(Mesh mesh, const Setting& setting) {
    for (Vec3& v : mesh.vertices)
        v = v * setting.scale + setting.offset;
    return mesh;
}

void aimFromInside(const Mesh& unit, uint32_t rays, uint32_t seed) {
    for (const Setting& setting : kSettings) {
        const Mesh mesh = placed(unit, setting);
        for (bool fast : {false, true}) {
            BuildOptions options;
            options.preferFastBuild = fast;
            const Structure s = makeStructure(mesh.input(), options);
            for (Isa isa : machineIsas()) {
                Random random(seed);
                uint32_t missed = 0;
                for (uint32_t i = 0; i < rays; ++i) {
                    const Vec3 o = i % 16 == 0
                                       ? setting.offset
                                       : setting.offset + random.point(0.3f * setting.scale);
                    Vec3 d = target(mesh, random) - o;
                    if (i % 3 == 0)
                        d = math::normalize(d);
                    QueryRay ray = {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
                    QueryHit hit;
                    missed += !kernels(isa).closest(s.block(), ray, hit);
                    if (i % 8 == 0)
                        missed += !kernels(isa).occluded(s.block(), ray);
                }
                EXPECT_EQ(missed, 0u)
                    << isaName(isa) << " offset " << setting.offset.z << " fast " << fast;
            }
        }
    }
}

TEST(Watertight, Icosphere) {
    aimFromInside(icosphere(4), 60000, 1);
}
TEST(Watertight, RoughSphere) {
    aimFromInside(roughSphere(4, 3), 60000, 2);
}
TEST(Watertight, Cube) {
    aimFromInside(cube(), 60000, 3);
}

// Axis-parallel rays through vertices, edges and the planes of a cube and a grid on integers.
TEST(Watertight, RaysInThePlanesOfEdges) {
    Mesh grid;
    constexpr int kSide = 16;
    for (int y = 0; y <= kSide; ++y)
        for (int x = 0; x <= kSide; ++x)
            grid.vertices.push_back({float(x), float(y), 0});
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const uint32_t a = uint32_t(y * (kSide + 1) + x), b = a + 1, c = a + kSide + 1;
            grid.triangles.push_back({a, b, c});
            grid.triangles.push_back({b, c + 1, c});
        }
    const Structure s = makeStructure(grid.input());
    for (Isa isa : machineIsas())
        for (int y = 0; y <= 4 * kSide; ++y)
            for (int x = 0; x <= 4 * kSide; ++x)
                for (float side : {-1.0f, 1.0f}) {
                    const float px = float(x) / 4, py = float(y) / 4;
                    for (float length : {1.0f, 1e3f, 1e7f}) {
                        const QueryRay ray = {{px, py, side * length}, 0, {0, 0, -side}, 1e30f};
                        EXPECT_TRUE(kernels(isa).occluded(s.block(), ray)) << px << ' ' << py;
                    }
                    // Aimed at the same point from a corner above: no zero components but two
                    // equal.
                    const QueryRay slanted = {{px - 8, py - 8, side * 8}, 0, {1, 1, -side}, 1e30f};
                    EXPECT_TRUE(kernels(isa).occluded(s.block(), slanted)) << px << ' ' << py;
                }
}

// Rays from outside through edges and vertices, including silhouettes: a ray that enters also
// leaves, so it meets a front if and only if it meets a back.
TEST(Watertight, WhatEntersLeaves) {
    for (const Mesh& mesh : {icosphere(4), torus(64, 32), cube(), roughSphere(4, 8)})
        for (const Setting& setting : kSettings) {
            const Mesh moved = placed(mesh, setting);
            const Structure s = makeStructure(moved.input());
            for (Isa isa : machineIsas()) {
                Random random(11);
                uint32_t unequal = 0, hits = 0;
                for (int i = 0; i < 20000; ++i) {
                    const Vec3 o = setting.offset + random.unit() * (5.0f * setting.scale);
                    const Vec3 d = target(moved, random) - o;
                    const QueryRay ray = {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
                    const bool in = kernels(isa).meetsSide(s.block(), ray, true);
                    hits += in;
                    unequal += in != kernels(isa).meetsSide(s.block(), ray, false);
                }
                EXPECT_GT(hits, 15000u);
                EXPECT_EQ(unequal, 0u) << isaName(isa) << " scale " << setting.scale;
            }
        }
}

// Millions of rays with the set that runs here.
TEST(Watertight, ManyRays) {
    const Mesh mesh = roughSphere(6, 21);
    const Structure s = makeStructure(mesh.input());
    const Kernels& k = kernels(chosenIsa());
    Random random(5);
    uint32_t missed = 0;
    for (int i = 0; i < 2000000; ++i) {
        const Vec3 o = random.point(0.3f), d = target(mesh, random) - o;
        const QueryRay ray = {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        missed += !k.occluded(s.block(), ray);
    }
    EXPECT_EQ(missed, 0u);
}

// Triangles whose length is 400 times their width: distances are as exact as the rounding of the
// vertices allows, although the area is a small difference of large products.
TEST(Watertight, DistancesToSlivers) {
    Random random(5);
    std::vector<double> errors;
    while (errors.size() < 20000) {
        const Vec3 center = random.point(1), along = random.unit() * 0.4f;
        const Vec3 across = math::cross(along, random.unit());
        if (math::length(across) < 0.01f)
            continue;
        Mesh mesh;
        mesh.vertices = {center - along * 0.5f, center + along * 0.5f,
                         center + across * (0.001f / math::length(across))};
        mesh.triangles = {{0, 1, 2}};
        const float u = random(0.2f, 0.4f), v = random(0.2f, 0.4f);
        const Vec3 *p = mesh.vertices.data(), origin = random.point(1);
        const Vec3 direction = p[0] * (1 - u - v) + p[1] * u + p[2] * v - origin;
        const Structure structure = makeStructure(mesh.input());
        const QueryRay ray{
            {origin.x, origin.y, origin.z}, 0, {direction.x, direction.y, direction.z}, 1e16f};
        QueryHit hit{};
        if (!kernels(chosenIsa()).closest(structure.block(), ray, hit))
            continue; // past it by rounding
        const auto wide = [](Vec3 a) { return std::array<double, 3>{a.x, a.y, a.z}; };
        const auto edge = [&](int i, int k) { return wide(p[i])[k] - wide(p[0])[k]; };
        double above = 0, below = 0;
        for (int k = 0; k < 3; ++k) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            const double normal = edge(1, a) * edge(2, b) - edge(1, b) * edge(2, a);
            above += normal * (wide(p[0])[k] - wide(origin)[k]);
            below += normal * wide(direction)[k];
        }
        errors.push_back(std::abs(hit.t * below / above - 1));
    }
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() * 99 / 100], 1.6e-6);
    EXPECT_LT(errors[errors.size() * 999 / 1000], 1.3e-5);
}

} // namespace
} // namespace sunstone::bvh
