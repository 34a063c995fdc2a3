// SPDX-License-Identifier: Apache-2.0
// OBJ files through tinyobjloader. Corners that share position and normal become one vertex.
#include "model.h"

#include <cmath>
#include <filesystem>
#include <sstream>
#include <unordered_map>

#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

namespace model {
namespace {

struct CornerHash {
    size_t operator()(const std::pair<int, int>& corner) const {
        return std::hash<uint64_t>()(uint64_t(uint32_t(corner.first)) << 32 |
                                     uint32_t(corner.second));
    }
};

// Vertices made so far, by position and normal number.
class VertexTable {
public:
    VertexTable(const tinyobj::attrib_t& attributes, Model& model)
        : attributes_(attributes), model_(model) {}

    uint32_t at(const tinyobj::index_t& index) {
        size_t count = attributes_.vertices.size() / 3;
        if (index.vertex_index < 0 || size_t(index.vertex_index) >= count)
            throw ModelError("a face refers to vertex " +
                             std::to_string(int64_t(index.vertex_index) + 1) + " of " +
                             std::to_string(count));
        int normal = index.normal_index;
        if (normal < 0 || size_t(normal) >= attributes_.normals.size() / 3)
            normal = -1;
        auto [entry, isNew] =
            numbers_.try_emplace({index.vertex_index, normal}, uint32_t(model_.positions.size()));
        if (isNew) {
            model_.positions.push_back(take(attributes_.vertices, index.vertex_index));
            model_.normals.push_back(normal < 0 ? Vec3{} : take(attributes_.normals, normal));
        }
        return entry->second;
    }

private:
    static Vec3 take(const std::vector<tinyobj::real_t>& values, int index) {
        size_t i = size_t(index) * 3;
        return {values[i], values[i + 1], values[i + 2]};
    }

    const tinyobj::attrib_t& attributes_;
    Model& model_;
    std::unordered_map<std::pair<int, int>, uint32_t, CornerHash> numbers_;
};

float clampUnit(float value) {
    return value > 0.0f ? std::min(value, 1.0f) : 0.0f;
}

Material convert(const tinyobj::material_t& source) {
    Material material;
    material.color = {clampUnit(source.diffuse[0]), clampUnit(source.diffuse[1]),
                      clampUnit(source.diffuse[2])};
    material.emission = {clampUnit(source.emission[0]), clampUnit(source.emission[1]),
                         clampUnit(source.emission[2])};
    material.metallic = clampUnit(source.metallic);
    if (source.roughness > 0.0f)
        material.roughness = clampUnit(source.roughness);
    else if (source.shininess > 1.0f) // Phong's exponent n to roughness: n = 2 / r^4 - 2
        material.roughness = clampUnit(std::pow(2.0f / (source.shininess + 2.0f), 0.25f));
    return material;
}

} // namespace

Model loadObj(const std::string& path) {
    std::istringstream text(readFile(path));
    std::string folder = std::filesystem::path(path).parent_path().string();
    tinyobj::MaterialFileReader materialReader(folder.empty() ? "." : folder);
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &text,
                          &materialReader, true)) {
        error.resize(std::min(error.find('\n'), error.size()));
        throw ModelError(error.empty() ? "is not an OBJ file" : error);
    }

    Model model;
    for (const tinyobj::material_t& material : materials)
        model.materials.push_back(convert(material));
    uint32_t noMaterial = uint32_t(model.materials.size());
    model.materials.emplace_back();
    VertexTable vertices(attributes, model);
    for (const tinyobj::shape_t& shape : shapes) {
        const tinyobj::mesh_t& mesh = shape.mesh;
        for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
            model.triangles.push_back({vertices.at(mesh.indices[i]),
                                       vertices.at(mesh.indices[i + 1]),
                                       vertices.at(mesh.indices[i + 2])});
            int material = i / 3 < mesh.material_ids.size() ? mesh.material_ids[i / 3] : -1;
            bool known = material >= 0 && uint32_t(material) < noMaterial;
            model.materialOfTriangle.push_back(known ? uint32_t(material) : noMaterial);
        }
    }
    return model;
}

} // namespace model
