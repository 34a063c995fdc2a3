// SPDX-License-Identifier: Apache-2.0
// OBJ files through tinyobjloader. Corners that share position, normal and texture coordinates
// become one vertex.
#include "model.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <sstream>
#include <string_view>
#include <unordered_map>

#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

namespace model {
namespace {

// Numbers of position, normal and texture coordinates.
using Corner = std::array<int, 3>;
struct CornerHash {
    size_t operator()(const Corner& corner) const {
        return std::hash<uint64_t>()((uint64_t(uint32_t(corner[0])) << 32 | uint32_t(corner[1])) ^
                                     uint64_t(uint32_t(corner[2])) * 0x9E3779B97F4A7C15u);
    }
};

// Vertices made so far, by the numbers of a corner.
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
        int texcoord = index.texcoord_index;
        if (texcoord < 0 || size_t(texcoord) >= attributes_.texcoords.size() / 2)
            texcoord = -1;
        auto [entry, isNew] = numbers_.try_emplace({index.vertex_index, normal, texcoord},
                                                   uint32_t(model_.positions.size()));
        if (isNew) {
            model_.positions.push_back(take(attributes_.vertices, index.vertex_index));
            model_.normals.push_back(normal < 0 ? Vec3{} : take(attributes_.normals, normal));
            addLook(index.vertex_index, texcoord);
        }
        return entry->second;
    }

private:
    // Texture coordinates count from the bottom; colours are sRGB.
    void addLook(int vertex, int texcoord) {
        const std::vector<tinyobj::real_t>& t = attributes_.texcoords;
        if (!t.empty())
            model_.texcoords.push_back(
                texcoord < 0 ? Vec2{}
                             : Vec2{t[size_t(texcoord) * 2], 1.0f - t[size_t(texcoord) * 2 + 1]});
        if (attributes_.colors.size() == attributes_.vertices.size() &&
            !attributes_.colors.empty()) {
            const Vec3 color = take(attributes_.colors, vertex);
            const auto linear = [](float value) {
                return linearOf(value > 0.0f ? std::min(value, 1.0f) : 0.0f);
            };
            model_.colors.push_back({linear(color.x), linear(color.y), linear(color.z), 1.0f});
        }
    }
    static Vec3 take(const std::vector<tinyobj::real_t>& values, int index) {
        size_t i = size_t(index) * 3;
        return {values[i], values[i + 1], values[i + 2]};
    }

    const tinyobj::attrib_t& attributes_;
    Model& model_;
    std::unordered_map<Corner, uint32_t, CornerHash> numbers_;
};

// What tinyobjloader does not report: it reads coordinates that are no numbers (nan, inf) as 0, and
// numbers of vertices beyond 32 bits as other numbers.
struct Oddities {
    std::vector<size_t> notNumbers; // vertices with such coordinates
    size_t vertices = 0;
    std::string tooLarge; // the first such number of a face
};

// Takes the next word of the line, or an empty one at its end.
std::string_view takeWord(std::string_view& line) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(" \t"));
    line.remove_prefix(word.size());
    return word;
}

void examineVertex(std::string_view line, Oddities& found) {
    for (int i = 0; i < 3; ++i) {
        std::string_view word = takeWord(line);
        if (word.starts_with('-') || word.starts_with('+'))
            word.remove_prefix(1);
        if (!word.empty() && std::isalpha(static_cast<unsigned char>(word[0]))) {
            found.notNumbers.push_back(found.vertices);
            break;
        }
    }
    ++found.vertices;
}

void examineFace(std::string_view line, Oddities& found) {
    constexpr size_t kDigits = 9; // of any number that 32 bits hold
    for (std::string_view word = takeWord(line); !word.empty(); word = takeWord(line)) {
        const std::string number(word.substr(0, word.find('/')));
        if (number.size() <= kDigits || std::abs(std::atof(number.c_str())) <= double(INT32_MAX))
            continue;
        found.tooLarge = number;
        break;
    }
}

Oddities examine(std::string_view text) {
    Oddities found;
    for (size_t begin = 0; begin < text.size();) {
        const size_t end = std::min(text.find_first_of("\r\n", begin), text.size());
        const size_t first = std::min(text.find_first_not_of(" \t", begin), end);
        if (first + 1 < end && (text[first + 1] == ' ' || text[first + 1] == '\t') &&
            (text[first] == 'v' || text[first] == 'f')) {
            const std::string_view line = text.substr(first + 2, end - first - 2);
            if (text[first] == 'v')
                examineVertex(line, found);
            else if (found.tooLarge.empty())
                examineFace(line, found);
        }
        begin = end + 1;
    }
    return found;
}

float clampUnit(float value) {
    return value > 0.0f ? std::min(value, 1.0f) : 0.0f;
}

// Light may be brighter than 1. The limit keeps sums of light finite.
float clampLight(float value) {
    constexpr float kBrightest = 1e6f;
    return value > 0.0f ? std::min(value, kBrightest) : 0.0f;
}

Material convert(const tinyobj::material_t& source) {
    Material material;
    material.color = {clampUnit(source.diffuse[0]), clampUnit(source.diffuse[1]),
                      clampUnit(source.diffuse[2])};
    material.emission = {clampLight(source.emission[0]), clampLight(source.emission[1]),
                         clampLight(source.emission[2])};
    material.metallic = clampUnit(source.metallic);
    if (source.roughness > 0.0f)
        material.roughness = clampUnit(source.roughness);
    else if (source.shininess > 1.0f) // Phong's exponent n to roughness: n = 2 / r^4 - 2
        material.roughness = clampUnit(std::pow(2.0f / (source.shininess + 2.0f), 0.25f));
    material.opacity = clampUnit(source.dissolve);
    if (material.opacity < 1.0f)
        material.alpha = Alpha::kBlend;
    return material;
}

// The pictures of materials. A texture with holes cuts them out.
class Textures {
public:
    Textures(Model& model, std::string folder) : model_(model), folder_(std::move(folder)) {}

    void apply(std::string name, Material& material) {
        if (name.empty())
            return;
        std::replace(name.begin(), name.end(), '\\', '/');
        const auto [entry, isNew] = numbers_.try_emplace(name, -1);
        if (isNew)
            entry->second = load(name);
        material.texture = entry->second;
        const Vec3& color = material.color;
        if (material.texture >= 0 && color.x + color.y + color.z == 0.0f)
            material.color = {1.0f, 1.0f, 1.0f}; // files that use only the texture
        if (material.texture >= 0 && material.alpha == Alpha::kOpaque &&
            hasHoles(model_.textures[size_t(material.texture)]))
            material.alpha = Alpha::kCutOut;
    }

private:
    int load(const std::string& name) {
        try {
            model_.textures.push_back(decodePicture(readBeside(folder_, name)));
            return int(model_.textures.size()) - 1;
        } catch (const ModelError& error) {
            const std::string cause = error.what();
            model_.missing.push_back(cause.rfind("refers to", 0) == 0
                                         ? cause
                                         : "refers to \"" + name + "\", which " + cause);
            return -1;
        }
    }
    static bool hasHoles(const Texture& texture) {
        for (size_t i = 3; i < texture.rgba.size(); i += 4)
            if (texture.rgba[i] < 128)
                return true;
        return false;
    }

    Model& model_;
    std::string folder_;
    std::unordered_map<std::string, int> numbers_;
};

// Reads material files beside the model, and notes those that cannot be read.
class MaterialFiles : public tinyobj::MaterialReader {
public:
    MaterialFiles(Model& model, std::string folder) : model_(model), folder_(std::move(folder)) {}
    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                    std::map<std::string, int>* numbers, std::string* warning,
                    std::string* error) override {
        try {
            std::istringstream text(readBeside(folder_, name));
            tinyobj::LoadMtl(numbers, materials, &text, warning, error);
            return true;
        } catch (const ModelError& fault) {
            model_.missing.push_back(fault.what());
            return false;
        }
    }

private:
    Model& model_;
    std::string folder_;
};

} // namespace

Model loadObj(const std::string& path) {
    std::istringstream text(readFile(path));
    const Oddities oddities = examine(text.str());
    if (!oddities.tooLarge.empty())
        throw ModelError("a face refers to vertex " + oddities.tooLarge + " of " +
                         std::to_string(oddities.vertices));
    std::string folder = std::filesystem::path(path).parent_path().string();
    Model model;
    MaterialFiles materialReader(model, folder);
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &text,
                          &materialReader, true, false)) {
        error.resize(std::min(error.find('\n'), error.size()));
        throw ModelError(error.empty() ? "is not an OBJ file" : error);
    }

    for (const size_t vertex : oddities.notNumbers) // finish() drops the triangles
        if (3 * vertex < attributes.vertices.size())
            attributes.vertices[3 * vertex] = std::numeric_limits<float>::quiet_NaN();

    Textures textures(model, folder);
    for (const tinyobj::material_t& material : materials) {
        model.materials.push_back(convert(material));
        textures.apply(material.diffuse_texname, model.materials.back());
    }
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
    if (!model.colors.empty())
        model.materials[noMaterial].color = {1.0f, 1.0f, 1.0f};
    return model;
}

} // namespace model
