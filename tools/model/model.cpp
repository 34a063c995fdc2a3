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

// The differences of larger coordinates would exceed the range of a float.
constexpr float kLargestCoordinate = 1e18f;

bool isFinite(const Vec3& v) {
    return std::fabs(v.x) < kLargestCoordinate && std::fabs(v.y) < kLargestCoordinate &&
           std::fabs(v.z) < kLargestCoordinate;
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

std::string readBeside(const std::string& folder, const std::string& name) {
    const std::filesystem::path path = name;
    if (name.find("://") != std::string::npos || path.is_absolute() ||
        std::find(path.begin(), path.end(), "..") != path.end())
        throw ModelError("refers to \"" + name + "\", which is not a file beside it");
    try {
        return readFile((std::filesystem::path(folder) / path).string());
    } catch (const ModelError& error) {
        throw ModelError("refers to \"" + name + "\", which " + error.what());
    }
}

float linearOf(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
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
    if (!model.texcoords.empty())
        model.texcoords.resize(model.positions.size());
    if (!model.colors.empty())
        model.colors.resize(model.positions.size());
    for (Material& material : model.materials)
        if (material.texture >= int(model.textures.size()) || model.texcoords.empty())
            material.texture = -1;
    dropBadTriangles(model);
    if (model.triangles.empty())
        throw ModelError("holds no triangle whose coordinates are within 1e18");
    // Unused vertices may still have any value.
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
