// SPDX-License-Identifier: Apache-2.0
#include "host_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace {

constexpr float kDegree = kPi / 180.0f;

// A point of the (2, 3) torus knot.
float3 knotPoint(float turn) {
    float angle = 2.0f * kPi * turn;
    float radius = 2.0f + std::cos(3.0f * angle);
    return vec(radius * std::cos(2.0f * angle), radius * std::sin(2.0f * angle),
               std::sin(3.0f * angle) * 1.2f);
}

RectangleLight makeLight(float3 center, float3 target, float width, float height, float3 emission) {
    float3 normal = normalize(target - center);
    float3 side = normalize(cross(normal, vec(0.0f, 1.0f, 0.001f)));
    RectangleLight light;
    light.edge1 = side * width;
    light.edge2 = cross(side, normal) * height;
    light.corner = center - (light.edge1 + light.edge2) * 0.5f;
    light.normal = normal;
    light.area = width * height;
    light.emission = emission;
    light.chance = 0.0f;
    return light;
}

// "12", "12/3", "12//4": the vertex number, counted from 1 or, if negative, from the end.
unsigned vertexIndex(const std::string& word, size_t count, const std::string& place) {
    char* end = nullptr;
    long number = std::strtol(word.c_str(), &end, 10);
    bool wellFormed = end != word.c_str() && (*end == 0 || *end == '/');
    long index = number > 0 ? number - 1 : long(count) + number;
    if (!wellFormed || number == 0 || index < 0 || index >= long(count))
        throw std::runtime_error(place + ": vertex " + word + " does not exist");
    return unsigned(index);
}

uint3 makeTriangle(unsigned a, unsigned b, unsigned c) {
    uint3 triangle;
    triangle.x = a;
    triangle.y = b;
    triangle.z = c;
    return triangle;
}

} // namespace

Bounds boundsOf(const HostScene& scene) {
    Bounds bounds = {vec(1e30f), vec(-1e30f)};
    for (const uint3& triangle : scene.triangles)
        for (unsigned corner : {triangle.x, triangle.y, triangle.z}) {
            float3 p = scene.positions[corner];
            bounds.low =
                vec(minOf(bounds.low.x, p.x), minOf(bounds.low.y, p.y), minOf(bounds.low.z, p.z));
            bounds.high = vec(maxOf(bounds.high.x, p.x), maxOf(bounds.high.y, p.y),
                              maxOf(bounds.high.z, p.z));
        }
    return bounds;
}

HostScene makeKnot(unsigned triangles) {
    unsigned around = 8;
    while (around * around * 24 < triangles)
        ++around;
    unsigned along = std::max(triangles / (2 * around), 8u);
    HostScene scene;
    scene.materials.push_back({vec(0.95f, 0.42f, 0.16f), 0.25f, vec(0.0f), 0.0f});
    for (unsigned i = 0; i < along; ++i) {
        float turn = float(i) / float(along);
        float3 center = knotPoint(turn);
        float3 forward = normalize(knotPoint(turn + 1e-3f) - center);
        float3 side = normalize(cross(forward, center));
        float3 up = cross(side, forward);
        for (unsigned j = 0; j < around; ++j) {
            float angle = 2.0f * kPi * float(j) / float(around);
            float3 normal = side * std::cos(angle) + up * std::sin(angle);
            scene.positions.push_back(center + normal * 0.42f + vec(0.0f, 3.42f, 0.0f));
            scene.normals.push_back(normal);
            unsigned i1 = (i + 1) % along, j1 = (j + 1) % around;
            unsigned a = i * around + j, b = i1 * around + j;
            unsigned c = i1 * around + j1, d = i * around + j1;
            scene.triangles.push_back(makeTriangle(a, b, c));
            scene.triangles.push_back(makeTriangle(a, c, d));
        }
    }
    scene.materialOfTriangle.assign(scene.triangles.size(), 0);
    return scene;
}

HostScene loadObj(const std::string& path) {
    std::ifstream file(path);
    if (!file)
        throw std::runtime_error("cannot read " + path);
    HostScene scene;
    scene.materials.push_back({vec(0.75f, 0.72f, 0.68f), 0.35f, vec(0.0f), 0.0f});
    size_t number = 0;
    for (std::string line; std::getline(file, line);) {
        std::string place = path + ":" + std::to_string(++number);
        std::istringstream words(line);
        std::string keyword;
        words >> keyword;
        if (keyword == "v") {
            float3 p;
            if (!(words >> p.x >> p.y >> p.z))
                throw std::runtime_error(place + ": expected three coordinates");
            scene.positions.push_back(p);
        } else if (keyword == "f") {
            std::vector<unsigned> corners;
            for (std::string word; words >> word;)
                corners.push_back(vertexIndex(word, scene.positions.size(), place));
            for (size_t i = 2; i < corners.size(); ++i)
                scene.triangles.push_back(makeTriangle(corners[0], corners[i - 1], corners[i]));
        }
    }
    if (scene.triangles.empty())
        throw std::runtime_error(path + ": no faces found");
    scene.materialOfTriangle.assign(scene.triangles.size(), 0);
    computeNormals(scene);
    return scene;
}

void computeNormals(HostScene& scene) {
    scene.normals.assign(scene.positions.size(), vec(0.0f));
    for (const uint3& t : scene.triangles) {
        float3 a = scene.positions[t.x];
        float3 scaled = cross(scene.positions[t.y] - a, scene.positions[t.z] - a); // by area
        scene.normals[t.x] += scaled;
        scene.normals[t.y] += scaled;
        scene.normals[t.z] += scaled;
    }
    for (float3& normal : scene.normals) {
        float square = dot(normal, normal);
        normal = square > 1e-30f ? normal / std::sqrt(square) : vec(0.0f, 1.0f, 0.0f);
    }
}

void addGround(HostScene& scene, const Bounds& model, float y, const Material& material) {
    unsigned first = unsigned(scene.positions.size());
    float3 center = model.center();
    float extent = model.radius() * 40.0f;
    for (int corner = 0; corner < 4; ++corner) {
        float x = corner == 0 || corner == 3 ? -extent : extent;
        float z = corner < 2 ? extent : -extent;
        scene.positions.push_back(vec(center.x + x, y, center.z + z));
        scene.normals.push_back(vec(0.0f, 1.0f, 0.0f));
    }
    scene.triangles.push_back(makeTriangle(first, first + 1, first + 2));
    scene.triangles.push_back(makeTriangle(first, first + 2, first + 3));
    scene.materialOfTriangle.insert(scene.materialOfTriangle.end(), 2,
                                    unsigned(scene.materials.size()));
    scene.materials.push_back(material);
}

Scene makeStudio(const Bounds& model) {
    Scene scene = {};
    float3 center = model.center();
    float size = std::max(model.radius(), 1e-6f);
    scene.lights[0] = makeLight(center + vec(-2.2f, 3.0f, 1.8f) * size, center, 2.4f * size,
                                2.4f * size, vec(8.5f, 7.6f, 6.4f));
    scene.lights[1] = makeLight(center + vec(3.2f, 1.6f, 0.4f) * size, center, 1.2f * size,
                                2.4f * size, vec(2.2f, 2.9f, 4.2f));
    scene.lightCount = 2;
    float powers[2], sum = 0.0f;
    for (int i = 0; i < 2; ++i)
        sum += powers[i] = scene.lights[i].area * maxComponent(scene.lights[i].emission);
    for (int i = 0; i < 2; ++i)
        scene.lights[i].chance = powers[i] / sum;
    scene.skyZenith = vec(0.1f, 0.14f, 0.22f);
    scene.skyHorizon = vec(0.34f, 0.36f, 0.4f);
    scene.ground = vec(0.15f, 0.14f, 0.13f);
    // Large enough to leave a surface in single precision, small enough to be invisible.
    scene.epsilon = 2e-5f * (size + length(center));
    scene.maxSegments = 5;
    return scene;
}

Camera orbitCamera(const Bounds& model, float azimuth, float elevation, float zoom, float aspect) {
    constexpr float kFov = 34.0f;
    float cosine = std::cos(elevation * kDegree);
    float3 outwards = vec(std::sin(azimuth * kDegree) * cosine, std::sin(elevation * kDegree),
                          std::cos(azimuth * kDegree) * cosine);
    Camera camera = makeCamera(outwards, vec(0.0f), vec(0.0f, 1.0f, 0.0f), kFov, aspect);
    // The nearest position with all corners of the box in the picture.
    float tangent = std::tan(kFov * 0.5f * kDegree), distance = 0.0f;
    float3 half = (model.high - model.low) * 0.5f;
    for (int corner = 0; corner < 8; ++corner) {
        float3 p = vec(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y,
                       corner & 4 ? half.z : -half.z);
        float across = std::fabs(dot(p, normalize(camera.right))) / (tangent * aspect);
        float upwards = std::fabs(dot(p, normalize(camera.up))) / tangent;
        distance = maxOf(distance, dot(p, outwards) + maxOf(across, upwards));
    }
    constexpr float kMargin = 1.06f;
    camera.eye = model.center() + outwards * (distance * kMargin / zoom);
    return camera;
}
