// SPDX-License-Identifier: Apache-2.0
// glTF 2.0: .gltf with data: URIs or files beside it, and .glb. Reads triangles (lists, strips,
// fans), normals, base colour with its texture, vertex colours, alpha, metallic and roughness
// factors, emission, and the node hierarchy. Other textures, skins and animations are ignored;
// files that require an unsupported extension are refused. Source: glTF 2.0 specification, Khronos
// Group.
#include "gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace model {
namespace {

using gltf::Json;

constexpr unsigned kMaxNodeDepth = 256;

// Column-major 4 x 4, as glTF stores it.
using Matrix = std::array<double, 16>;
constexpr Matrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

Matrix multiply(const Matrix& a, const Matrix& b) {
    Matrix result = {};
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            for (int k = 0; k < 4; ++k)
                result[column * 4 + row] += a[k * 4 + row] * b[column * 4 + k];
    return result;
}

template <size_t N>
std::array<double, N> numbers(const Json& object, const char* key, std::array<double, N> fallback) {
    const Json* list = gltf::find(object, key);
    if (!list)
        return fallback;
    if (!list->is_array() || list->size() != N)
        throw ModelError(std::string("\"") + key + "\" must have " + std::to_string(N) +
                         " numbers");
    for (size_t i = 0; i < N; ++i) {
        if (!(*list)[i].is_number())
            throw ModelError(std::string("\"") + key + "\" holds something that is no number");
        fallback[i] = (*list)[i].get<double>();
    }
    return fallback;
}

Matrix localMatrix(const Json& node) {
    if (gltf::find(node, "matrix"))
        return numbers<16>(node, "matrix", kIdentity);
    auto t = numbers<3>(node, "translation", {0, 0, 0});
    auto q = numbers<4>(node, "rotation", {0, 0, 0, 1});
    auto s = numbers<3>(node, "scale", {1, 1, 1});
    double x = q[0], y = q[1], z = q[2], w = q[3];
    return {(1 - 2 * (y * y + z * z)) * s[0],
            2 * (x * y + z * w) * s[0],
            2 * (x * z - y * w) * s[0],
            0,
            2 * (x * y - z * w) * s[1],
            (1 - 2 * (x * x + z * z)) * s[1],
            2 * (y * z + x * w) * s[1],
            0,
            2 * (x * z + y * w) * s[2],
            2 * (y * z - x * w) * s[2],
            (1 - 2 * (x * x + y * y)) * s[2],
            0,
            t[0],
            t[1],
            t[2],
            1};
}

Vec3 transformPoint(const Matrix& m, const Vec3& p) {
    return {float(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12]),
            float(m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13]),
            float(m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14])};
}

// By the cofactors, which equal the inverse transpose up to scale and exist for flat matrices too.
Vec3 transformNormal(const Matrix& m, const Vec3& n) {
    auto cofactor = [&](int r, int c) {
        int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
        return m[c1 * 4 + r1] * m[c2 * 4 + r2] - m[c2 * 4 + r1] * m[c1 * 4 + r2];
    };
    auto row = [&](int r) {
        return float(cofactor(r, 0) * n.x + cofactor(r, 1) * n.y + cofactor(r, 2) * n.z);
    };
    Vec3 result = {row(0), row(1), row(2)};
    float largest = std::max({std::fabs(result.x), std::fabs(result.y), std::fabs(result.z)});
    if (largest > 0.0f && std::isfinite(largest)) // small cofactors must not vanish
        result = {result.x / largest, result.y / largest, result.z / largest};
    return result;
}

Material convertMaterial(const Json& source) {
    Material material;
    static const Json kNone = Json::object();
    const Json* pbr = gltf::find(source, "pbrMetallicRoughness");
    if (!pbr || !pbr->is_object())
        pbr = &kNone;
    auto color = numbers<4>(*pbr, "baseColorFactor", {1, 1, 1, 1});
    auto emission = numbers<3>(source, "emissiveFactor", {0, 0, 0});
    auto unit = [](double value) { return float(std::clamp(value, 0.0, 1.0)); };
    material.color = {unit(color[0]), unit(color[1]), unit(color[2])};
    material.opacity = unit(color[3]);
    material.cutoff = float(gltf::number(source, "alphaCutoff", 0.5));
    const Json* mode = gltf::find(source, "alphaMode");
    if (mode && mode->is_string())
        material.alpha = *mode == "MASK"    ? Alpha::kCutOut
                         : *mode == "BLEND" ? Alpha::kBlend
                                            : Alpha::kOpaque;
    material.emission = {unit(emission[0]), unit(emission[1]), unit(emission[2])};
    material.metallic = unit(gltf::number(*pbr, "metallicFactor", 1.0));
    material.roughness = unit(gltf::number(*pbr, "roughnessFactor", 1.0));
    // The ignored texture would set these, so they get plausible values.
    if (gltf::find(*pbr, "metallicRoughnessTexture"))
        material.metallic = 0.0f;
    return material;
}

// Turns the corners of a primitive of the given mode into triangles.
std::vector<Triangle> assemble(const std::vector<uint32_t>& corners, uint64_t mode) {
    std::vector<Triangle> triangles;
    if (mode == 4) { // list
        for (size_t i = 0; i + 2 < corners.size(); i += 3)
            triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    } else if (mode == 5) { // strip: every second triangle is turned
        for (size_t i = 2; i < corners.size(); ++i)
            triangles.push_back({corners[i - 2], corners[i - (i % 2)], corners[i - 1 + (i % 2)]});
    } else if (mode == 6) { // fan
        for (size_t i = 2; i < corners.size(); ++i)
            triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
    return triangles; // points and lines have none
}

class Scene {
public:
    explicit Scene(const std::string& path) : file_(path) {}

    Model convert() {
        checkExtensions();
        if (const Json* materials = gltf::find(file_.root(), "materials"))
            for (const Json& material : gltf::array(*materials, "materials"))
                addMaterial(material);
        defaultMaterial_ = uint32_t(model_.materials.size());
        model_.materials.emplace_back();

        const Json* scenes = gltf::find(file_.root(), "scenes");
        uint64_t scene = gltf::index(file_.root(), "scene", 0);
        if (scenes && scene < gltf::array(*scenes, "scenes").size()) {
            if (const Json* roots = gltf::find((*scenes)[scene], "nodes"))
                for (const Json& root : gltf::array(*roots, "nodes"))
                    addNode(root, kIdentity, 0);
        } else if (const Json* meshes = gltf::find(file_.root(), "meshes")) {
            for (const Json& mesh : gltf::array(*meshes, "meshes"))
                addMesh(mesh, kIdentity);
        }
        return std::move(model_);
    }

private:
    void addMaterial(const Json& source) {
        model_.materials.push_back(convertMaterial(source));
        const Json* pbr = gltf::find(source, "pbrMetallicRoughness");
        const Json* reference = pbr ? gltf::find(*pbr, "baseColorTexture") : nullptr;
        const Json* number = reference ? gltf::find(*reference, "index") : nullptr;
        if (!number || gltf::index(*reference, "texCoord", 0) != 0)
            return;
        const Json* image = gltf::find(file_.element("textures", *number), "source");
        if (image)
            model_.materials.back().texture = textureOf(*image);
    }

    // The number of an image's texture; -1 if there is no usable texture.
    int textureOf(const Json& image) {
        const auto [entry, isNew] = textures_.try_emplace(image.dump(), -1);
        if (!isNew)
            return entry->second;
        try {
            model_.textures.push_back(decodePicture(file_.image(image)));
            entry->second = int(model_.textures.size()) - 1;
        } catch (const ModelError& error) {
            const std::string cause = error.what();
            model_.missing.push_back(
                cause.rfind("refers to", 0) == 0 ? cause : "image " + image.dump() + " " + cause);
        }
        return entry->second;
    }

    // Texture coordinates and colours of `count` new vertices, beside those of other primitives.
    void addLooks(const Json& attributes, size_t base, size_t count) {
        if (const Json* reference = gltf::find(attributes, "TEXCOORD_0")) {
            const std::vector<double> values = file_.read(*reference, 2);
            model_.texcoords.resize(base + count);
            for (size_t i = 0; i < std::min(count, values.size() / 2); ++i)
                model_.texcoords[base + i] = {float(values[i * 2]), float(values[i * 2 + 1])};
        }
        if (const Json* reference = gltf::find(attributes, "COLOR_0")) {
            const Json* type = gltf::find(file_.element("accessors", *reference), "type");
            const size_t components = type && *type == "VEC4" ? 4 : 3;
            const std::vector<double> values = file_.read(*reference, unsigned(components));
            model_.colors.resize(base + count);
            for (size_t i = 0; i < std::min(count, values.size() / components); ++i) {
                const double* c = &values[i * components];
                model_.colors[base + i] = {float(c[0]), float(c[1]), float(c[2]),
                                           components == 4 ? float(c[3]) : 1.0f};
            }
        }
    }

    void checkExtensions() {
        const Json* required = gltf::find(file_.root(), "extensionsRequired");
        if (!required)
            return;
        for (const Json& name : gltf::array(*required, "extensionsRequired")) {
            std::string text = name.is_string() ? name.get<std::string>() : "?";
            if (text != "KHR_mesh_quantization" && text.rfind("KHR_materials_", 0) != 0 &&
                text != "KHR_texture_transform" && text != "KHR_lights_punctual")
                throw ModelError("requires the glTF extension " + text +
                                 ", which is not supported");
        }
    }

    void addNode(const Json& reference, const Matrix& parent, unsigned depth) {
        if (depth > kMaxNodeDepth || ++nodesVisited_ > 1000000)
            throw ModelError("has a node hierarchy that is too deep or circular");
        const Json& node = file_.element("nodes", reference);
        Matrix matrix = multiply(parent, localMatrix(node));
        if (const Json* mesh = gltf::find(node, "mesh"))
            addMesh(file_.element("meshes", *mesh), matrix);
        if (const Json* children = gltf::find(node, "children"))
            for (const Json& child : gltf::array(*children, "children"))
                addNode(child, matrix, depth + 1);
    }

    void addMesh(const Json& mesh, const Matrix& matrix) {
        if (const Json* primitives = gltf::find(mesh, "primitives"))
            for (const Json& primitive : gltf::array(*primitives, "primitives"))
                addPrimitive(primitive, matrix);
    }

    void addPrimitive(const Json& primitive, const Matrix& matrix) {
        const Json* attributes = gltf::find(primitive, "attributes");
        const Json* position = attributes ? gltf::find(*attributes, "POSITION") : nullptr;
        uint64_t mode = gltf::index(primitive, "mode", 4);
        if (!position || mode < 4 || mode > 6)
            return;
        std::vector<double> points = file_.read(*position, 3);
        std::vector<double> normals;
        if (const Json* normal = gltf::find(*attributes, "NORMAL"))
            normals = file_.read(*normal, 3);
        size_t count = points.size() / 3;
        std::vector<uint32_t> corners = cornersOf(primitive, count);

        size_t base = model_.positions.size();
        if (base + count > 0xffffffffull || model_.triangles.size() > (1u << 28))
            throw ModelError("is too large");
        for (size_t i = 0; i < count; ++i) {
            const double* p = &points[i * 3];
            model_.positions.push_back(
                transformPoint(matrix, {float(p[0]), float(p[1]), float(p[2])}));
            const double* n = i * 3 + 2 < normals.size() ? &normals[i * 3] : nullptr;
            model_.normals.push_back(
                n ? transformNormal(matrix, {float(n[0]), float(n[1]), float(n[2])}) : Vec3{});
        }
        addLooks(*attributes, base, count);
        for (Triangle t : assemble(corners, mode)) {
            t.a += uint32_t(base);
            t.b += uint32_t(base);
            t.c += uint32_t(base);
            model_.triangles.push_back(t);
        }
        uint64_t material = gltf::index(primitive, "material", defaultMaterial_);
        model_.materialOfTriangle.resize(model_.triangles.size(), material < defaultMaterial_
                                                                      ? uint32_t(material)
                                                                      : defaultMaterial_);
    }

    // Vertex numbers within the primitive, checked.
    std::vector<uint32_t> cornersOf(const Json& primitive, size_t count) {
        std::vector<uint32_t> corners;
        const Json* indices = gltf::find(primitive, "indices");
        if (!indices) {
            for (size_t i = 0; i < count; ++i)
                corners.push_back(uint32_t(i));
            return corners;
        }
        for (double value : file_.read(*indices, 1)) {
            if (!(value >= 0.0) || value >= double(count))
                throw ModelError("an index refers to vertex " + std::to_string(int64_t(value)) +
                                 " of " + std::to_string(count));
            corners.push_back(uint32_t(value));
        }
        return corners;
    }

    gltf::File file_;
    Model model_;
    uint32_t defaultMaterial_ = 0;
    unsigned nodesVisited_ = 0;
    std::map<std::string, int> textures_; // by the image's number
};

} // namespace

Model loadGltf(const std::string& path) {
    return Scene(path).convert();
}

} // namespace model
