// SPDX-License-Identifier: Apache-2.0
#include "model.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

namespace model {
namespace {

// Beyond this, differences of coordinates leave the range of a float.
constexpr float kLargestCoordinate = 1e18f;

bool isFinite(const Vec3& v) {
    return std::fabs(v.x) < kLargestCoordinate && std::fabs(v.y) < kLargestCoordinate &&
           std::fabs(v.z) < kLargestCoordinate;
}

Vec3 subtract(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Scales to unit length; false if there is no direction to keep.
bool normalize(Vec3& v) {
    double length = std::sqrt(double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z);
    if (!(length > 0.0) || !std::isfinite(length))
        return false;
    v = {float(v.x / length), float(v.y / length), float(v.z / length)};
    return true;
}

void dropBadTriangles(Model& model) {
    size_t kept = 0;
    for (size_t i = 0; i < model.triangles.size(); ++i) {
        const Triangle& t = model.triangles[i];
        if (!isFinite(model.positions[t.a]) || !isFinite(model.positions[t.b]) ||
            !isFinite(model.positions[t.c])) {
            ++model.skippedTriangles;
            continue;
        }
        model.triangles[kept] = t;
        model.materialOfTriangle[kept++] = model.materialOfTriangle[i];
    }
    model.triangles.resize(kept);
    model.materialOfTriangle.resize(kept);
}

// Vertices without a normal get the mean of their triangles' normals, weighted by area.
void completeNormals(Model& model) {
    model.normals.resize(model.positions.size());
    std::vector<bool> missing(model.positions.size());
    for (size_t i = 0; i < missing.size(); ++i)
        missing[i] = !normalize(model.normals[i]);
    std::vector<Vec3> sums(model.positions.size());
    for (const Triangle& t : model.triangles) {
        const Vec3& a = model.positions[t.a];
        Vec3 scaled = cross(subtract(model.positions[t.b], a), subtract(model.positions[t.c], a));
        for (uint32_t corner : {t.a, t.b, t.c}) {
            sums[corner].x += scaled.x;
            sums[corner].y += scaled.y;
            sums[corner].z += scaled.z;
        }
    }
    for (size_t i = 0; i < missing.size(); ++i) {
        if (!missing[i])
            continue;
        model.normals[i] = sums[i];
        if (!normalize(model.normals[i]))
            model.normals[i] = {0.0f, 1.0f, 0.0f};
    }
}

} // namespace

std::string readFile(const std::string& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        throw ModelError("is a directory");
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                         std::fclose);
    if (!file)
        throw ModelError("cannot be opened");
    std::string text;
    char block[1 << 16];
    while (size_t count = std::fread(block, 1, sizeof(block), file.get()))
        text.append(block, count);
    if (std::ferror(file.get()))
        throw ModelError("cannot be read");
    return text;
}

void finish(Model& model) {
    if (model.triangles.empty())
        throw ModelError("holds no triangles");
    if (model.materials.empty())
        model.materials.emplace_back();
    model.materialOfTriangle.resize(model.triangles.size(), 0);
    for (size_t i = 0; i < model.triangles.size(); ++i) {
        const Triangle& t = model.triangles[i];
        uint32_t largest = std::max({t.a, t.b, t.c});
        if (largest >= model.positions.size())
            throw ModelError("triangle " + std::to_string(i) + " refers to vertex " +
                             std::to_string(largest) + " of " +
                             std::to_string(model.positions.size()));
        if (model.materialOfTriangle[i] >= model.materials.size())
            model.materialOfTriangle[i] = 0;
    }
    dropBadTriangles(model);
    if (model.triangles.empty())
        throw ModelError("holds no triangle with finite coordinates");
    // Unused vertices may still hold anything.
    for (Vec3& position : model.positions)
        if (!isFinite(position))
            position = {};
    completeNormals(model);
}

Model load(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    try {
        Model model;
        if (ending == ".obj")
            model = loadObj(path);
        else if (ending == ".gltf" || ending == ".glb")
            model = loadGltf(path);
        else if (ending == ".ply")
            model = loadPly(path);
        else
            throw ModelError("is of unknown format (known: .obj, .gltf, .glb, .ply)");
        finish(model);
        return model;
    } catch (const ModelError& error) {
        throw ModelError(path + ": " + error.what());
    } catch (const std::bad_alloc&) {
        throw ModelError(path + ": needs more memory than there is");
    }
}

} // namespace model
