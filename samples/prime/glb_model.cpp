// SPDX-License-Identifier: Apache-2.0
#include "glb_model.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

float dot(Vec a, Vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vec cross(Vec a, Vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vec normalize(Vec a) {
    const float length = std::sqrt(dot(a, a));
    return length > 0 ? 1 / length * a : a;
}

namespace {

using Json = nlohmann::json;

// Columns, as glTF stores them.
struct Matrix {
    float m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    Matrix operator*(const Matrix& o) const {
        Matrix r;
        for (int c = 0; c < 4; ++c)
            for (int i = 0; i < 4; ++i) {
                r.m[4 * c + i] = 0;
                for (int k = 0; k < 4; ++k)
                    r.m[4 * c + i] += m[4 * k + i] * o.m[4 * c + k];
            }
        return r;
    }
    Vec point(Vec p) const {
        return {m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]};
    }
};

class Reader {
public:
    explicit Reader(const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        if (!file)
            throw std::runtime_error("cannot read " + path +
                                     "; the first argument names the model, a binary glTF file");
        bytes_.assign(std::istreambuf_iterator<char>(file), {});
        constexpr size_t kHeader = 20;
        if (bytes_.size() < kHeader || std::memcmp(bytes_.data(), "glTF", 4) != 0)
            throw std::runtime_error(path + " is no binary glTF file");
        const size_t size = number<uint32_t>(12);
        if (size > bytes_.size() - kHeader)
            throw std::runtime_error(path + " is shorter than it says");
        json_ = Json::parse(bytes_.begin() + kHeader, bytes_.begin() + ptrdiff_t(kHeader + size));
        data_ = kHeader + size + 8;
    }

    GlbModel read() {
        const Json& scene = json_.at("scenes").at(json_.value("scene", size_t(0)));
        for (const Json& node : scene.at("nodes"))
            visit(node, Matrix());
        if (model_.triangles.empty())
            throw std::runtime_error("the file has no triangles");
        finish();
        return std::move(model_);
    }

private:
    template <class T>
    T number(size_t place) const {
        T value;
        if (place > bytes_.size() || sizeof(T) > bytes_.size() - place)
            throw std::runtime_error("the file ends within its data");
        std::memcpy(&value, bytes_.data() + place, sizeof(T));
        return value;
    }

    void visit(size_t index, const Matrix& parent) {
        const Json& node = json_.at("nodes").at(index);
        Matrix local;
        if (node.contains("matrix"))
            for (size_t i = 0; i < 16; ++i)
                local.m[i] = node["matrix"].at(i).get<float>();
        const Matrix toWorld = parent * local;
        if (node.contains("mesh"))
            for (const Json& part : json_.at("meshes").at(node["mesh"].get<size_t>())["primitives"])
                add(part, toWorld);
        if (node.contains("children"))
            for (const Json& child : node["children"])
                visit(child, toWorld);
    }

    struct View {
        size_t place, stride, count;
        int type;
    };
    View view(size_t index, size_t elementBytes) const {
        const Json& accessor = json_.at("accessors").at(index);
        const Json& buffer = json_.at("bufferViews").at(accessor.at("bufferView").get<size_t>());
        return {data_ + buffer.value("byteOffset", size_t(0)) +
                    accessor.value("byteOffset", size_t(0)),
                buffer.value("byteStride", elementBytes), accessor.at("count"),
                accessor.at("componentType")};
    }

    void add(const Json& part, const Matrix& toWorld) {
        constexpr int kTriangles = 4, kByte = 5121, kShort = 5123;
        if (part.value("mode", kTriangles) != kTriangles || !part.contains("indices"))
            return;
        const auto base = int32_t(model_.vertices.size());
        const View points = view(part.at("attributes").at("POSITION"), 12);
        for (size_t i = 0; i < points.count; ++i) {
            const size_t at = points.place + i * points.stride;
            model_.vertices.push_back(
                toWorld.point({number<float>(at), number<float>(at + 4), number<float>(at + 8)}));
        }
        const int type = json_["accessors"].at(part["indices"].get<size_t>()).at("componentType");
        const size_t bytes = type == kByte ? 1 : type == kShort ? 2 : 4;
        const View indices = view(part["indices"], bytes);
        const auto index = [&](size_t i) {
            const size_t at = indices.place + i * bytes;
            const uint32_t value = bytes == 1   ? number<uint8_t>(at)
                                   : bytes == 2 ? number<uint16_t>(at)
                                                : number<uint32_t>(at);
            if (value >= points.count)
                throw std::runtime_error("an index is out of range");
            return base + int32_t(value);
        };
        for (size_t i = 0; i + 2 < indices.count; i += 3)
            model_.triangles.push_back({index(i), index(i + 1), index(i + 2)});
    }

    // Normals, weighted by area, and bounds.
    void finish() {
        model_.normals.assign(model_.vertices.size(), {0, 0, 0});
        const auto vertex = [&](int32_t i) { return model_.vertices[size_t(i)]; };
        for (const Triangle& t : model_.triangles) {
            const Vec normal = cross(vertex(t.b) - vertex(t.a), vertex(t.c) - vertex(t.a));
            for (const int32_t i : {t.a, t.b, t.c})
                model_.normals[size_t(i)] = model_.normals[size_t(i)] + normal;
        }
        for (Vec& normal : model_.normals)
            normal = normalize(normal);
        model_.lower = model_.upper = model_.vertices.front();
        for (const Vec& p : model_.vertices) {
            model_.lower = {std::min(model_.lower.x, p.x), std::min(model_.lower.y, p.y),
                            std::min(model_.lower.z, p.z)};
            model_.upper = {std::max(model_.upper.x, p.x), std::max(model_.upper.y, p.y),
                            std::max(model_.upper.z, p.z)};
        }
    }

    std::string bytes_;
    Json json_;
    size_t data_ = 0;
    GlbModel model_;
};

} // namespace

GlbModel readGlb(const std::string& path) {
    return Reader(path).read();
}
