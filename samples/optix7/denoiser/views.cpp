// SPDX-License-Identifier: Apache-2.0
#include "views.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace {

float hashed(unsigned value) {
    return float(hashPcg(value) >> 8) * (1.0f / 16777216.0f);
}

unsigned addMaterial(HostScene& scene, float3 color, float roughness, float metallic = 0.0f,
                     float3 emission = vec(0.0f)) {
    scene.materials.push_back({color, roughness, emission, metallic});
    return unsigned(scene.materials.size() - 1);
}

// (columns x rows) quads; `point(u, v)` with both from 0 to 1, `material(i, j)` of each quad.
template <class PointAt, class MaterialAt>
void addPatch(HostScene& scene, unsigned columns, unsigned rows, PointAt pointAt,
              MaterialAt materialAt) {
    unsigned first = unsigned(scene.positions.size());
    for (unsigned j = 0; j <= rows; ++j)
        for (unsigned i = 0; i <= columns; ++i)
            scene.positions.push_back(pointAt(float(i) / columns, float(j) / rows));
    for (unsigned j = 0; j < rows; ++j)
        for (unsigned i = 0; i < columns; ++i) {
            unsigned a = first + j * (columns + 1) + i, b = a + 1, c = b + columns + 1, d = c - 1;
            uint3 one = {a, d, b}, two = {b, d, c};
            scene.triangles.insert(scene.triangles.end(), {one, two});
            scene.materialOfTriangle.insert(scene.materialOfTriangle.end(), 2, materialAt(i, j));
        }
}

// `bump` is added to the radius at a unit direction.
template <class MaterialAt, class Bump>
void addSphere(HostScene& scene, float3 center, float radius, unsigned steps, MaterialAt materialAt,
               Bump bump) {
    addPatch(
        scene, 2 * steps, steps,
        [&](float u, float v) {
            float polar = kPi * v, turn = 2.0f * kPi * u;
            float3 direction = vec(std::sin(polar) * std::cos(turn), std::cos(polar),
                                   std::sin(polar) * std::sin(turn));
            return center + direction * (radius + bump(direction));
        },
        materialAt);
}

float noBump(float3) {
    return 0.0f;
}

template <class MaterialAt>
void addFloor(HostScene& scene, float size, unsigned steps, MaterialAt materialAt) {
    addPatch(
        scene, steps, steps,
        [&](float u, float v) { return vec((u - 0.5f) * size, 0.0f, (v - 0.5f) * size); },
        materialAt);
}

void makeKnotView(View& view) {
    view.scene = makeKnot(20000);
    Bounds bounds = boundsOf(view.scene);
    addGround(view.scene, bounds, bounds.low.y, {vec(0.36f, 0.35f, 0.34f), 0.5f, vec(0.0f), 0.0f});
    view.lights = makeStudio(bounds);
}

void makeTextures(View& view) {
    HostScene& scene = view.scene;
    unsigned first = addMaterial(scene, vec(0.8f, 0.76f, 0.7f), 0.9f);
    for (unsigned i = 1; i < 24; ++i)
        addMaterial(scene,
                    vec(0.15f + 0.7f * hashed(3 * i), 0.15f + 0.7f * hashed(3 * i + 1),
                        0.15f + 0.7f * hashed(3 * i + 2)),
                    0.9f);
    addFloor(scene, 12.0f, 120, [&](unsigned i, unsigned j) {
        return first +
               ((i / 4 + j / 4) % 2 ? hashPcg(i / 4 * 97 + j / 4) % 24 : hashPcg(i * 131 + j) % 3);
    });
    addSphere(
        scene, vec(-1.3f, 1.0f, 0.0f), 1.0f, 48,
        [&](unsigned i, unsigned j) { return first + (i / 4 + j / 4) % 2 * 5; }, noBump);
    addSphere(
        scene, vec(1.2f, 0.8f, 0.5f), 0.8f, 48,
        [&](unsigned, unsigned j) { return first + hashPcg(j / 2) % 24; }, noBump);
    view.lights.skyZenith = vec(0.5f, 0.7f, 1.1f);
    view.lights.skyHorizon = vec(1.2f, 1.1f, 0.95f);
    view.lights.ground = vec(0.2f, 0.18f, 0.15f);
}

void makeRelief(View& view) {
    HostScene& scene = view.scene;
    unsigned clay = addMaterial(scene, vec(0.7f, 0.62f, 0.52f), 0.8f);
    unsigned jade = addMaterial(scene, vec(0.3f, 0.55f, 0.42f), 0.6f);
    addPatch(
        scene, 240, 240,
        [](float u, float v) {
            float x = (u - 0.5f) * 12.0f, z = (v - 0.5f) * 12.0f;
            return vec(x, 0.05f * std::sin(9.0f * x) * std::sin(9.0f * z) - 0.05f, z);
        },
        [&](unsigned, unsigned) { return clay; });
    addSphere(
        scene, vec(-0.2f, 1.15f, 0.0f), 1.1f, 120, [&](unsigned, unsigned) { return jade; },
        [](float3 d) {
            return 0.06f * std::sin(16.0f * d.x) * std::sin(16.0f * d.y) * std::sin(16.0f * d.z) +
                   0.02f * std::sin(40.0f * d.y);
        });
    Bounds model = {vec(-1.4f, 0.0f, -1.4f), vec(1.4f, 2.4f, 1.4f)};
    view.lights = makeStudio(model);
    // The second softbox alone, small and strong.
    view.lights.lights[0] = view.lights.lights[1];
    view.lights.lights[0].edge1 = view.lights.lights[0].edge1 * 0.4f;
    view.lights.lights[0].edge2 = view.lights.lights[0].edge2 * 0.4f;
    view.lights.lights[0].area *= 0.16f;
    view.lights.lights[0].emission = vec(60.0f, 48.0f, 34.0f);
    view.lights.lights[0].chance = 1.0f;
    view.lights.lightCount = 1;
}

void makeGlossy(View& view) {
    HostScene& scene = view.scene;
    unsigned dark = addMaterial(scene, vec(0.12f, 0.12f, 0.14f), 0.2f);
    unsigned light = addMaterial(scene, vec(0.55f, 0.53f, 0.5f), 0.2f);
    addFloor(scene, 14.0f, 14, [&](unsigned i, unsigned j) { return (i + j) % 2 ? dark : light; });
    for (int i = 0; i < 5; ++i) {
        unsigned metal =
            addMaterial(scene, lerp(vec(0.95f, 0.7f, 0.35f), vec(0.75f, 0.8f, 0.9f), i * 0.25f),
                        0.12f + 0.09f * i, 1.0f);
        addSphere(
            scene, vec(-2.4f + 1.2f * i, 0.55f, i % 2 ? 0.9f : -0.5f), 0.55f, 64,
            [&](unsigned, unsigned) { return metal; }, noBump);
    }
    view.lights = makeStudio({vec(-3.0f, 0.0f, -1.5f), vec(3.0f, 1.2f, 1.5f)});
}

void makeLantern(View& view) {
    HostScene& scene = view.scene;
    unsigned wall = addMaterial(scene, vec(0.72f, 0.7f, 0.66f), 0.9f);
    unsigned red = addMaterial(scene, vec(0.75f, 0.25f, 0.18f), 0.7f);
    unsigned blue = addMaterial(scene, vec(0.2f, 0.3f, 0.7f), 0.4f);
    unsigned glow = addMaterial(scene, vec(0.0f), 1.0f, 0.0f, vec(7.0f, 5.6f, 3.6f));
    addFloor(scene, 12.0f, 24, [&](unsigned, unsigned) { return wall; });
    addSphere(
        scene, vec(0.0f, 2.2f, 0.6f), 0.75f, 32, [&](unsigned, unsigned) { return glow; }, noBump);
    addSphere(
        scene, vec(-1.4f, 0.8f, 0.2f), 0.8f, 48, [&](unsigned, unsigned) { return red; }, noBump);
    addSphere(
        scene, vec(1.3f, 0.7f, 0.0f), 0.7f, 48, [&](unsigned, unsigned) { return blue; }, noBump);
    view.lights.skyZenith = view.lights.skyHorizon = vec(0.03f, 0.035f, 0.05f);
    view.lights.ground = vec(0.02f);
}

} // namespace

View makeView(unsigned number, float aspect, float turn) {
    static const char* const kNames[kViewCount] = {"knot", "textures", "relief", "glossy",
                                                   "lantern"};
    using Make = void (*)(View&);
    static const Make kMakers[kViewCount] = {makeKnotView, makeTextures, makeRelief, makeGlossy,
                                             makeLantern};
    if (number >= kViewCount)
        throw std::runtime_error("there is no scene " + std::to_string(number));
    View view = {};
    view.lights.epsilon = 1e-4f;
    view.lights.maxSegments = 5;
    view.name = kNames[number];
    kMakers[number](view);
    if (number != 0)
        computeNormals(view.scene);
    Bounds model = number == 0 ? boundsOf(makeKnot(2000))
                               : Bounds{vec(-2.2f, 0.0f, -1.5f), vec(2.2f, 2.2f, 1.5f)};
    view.camera = orbitCamera(model, 24.0f + turn, 20.0f, number == 0 ? 1.0f : 1.3f, aspect);
    return view;
}
