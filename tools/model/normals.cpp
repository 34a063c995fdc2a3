// SPDX-License-Identifier: Apache-2.0
// Normals for vertices without one. A corner's normal is the area-weighted mean over the triangles
// around its vertex that meet its own triangle at less than the crease angle. Corners of one vertex
// with equal normals share a vertex; other corners get copies of it.
#include "model.h"

#include <cmath>
#include <cstddef>

namespace model {
namespace {

constexpr float kCreaseCosine = 0.643f; // 50 degrees

Vec3 subtract(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

Vec3 add(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}

float dot(const Vec3& a, const Vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Scales to unit length; false for a vector without direction.
bool normalize(Vec3& v) {
    double length = std::sqrt(double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z);
    if (!(length > 0.0) || !std::isfinite(length))
        return false;
    v = {float(v.x / length), float(v.y / length), float(v.z / length)};
    return true;
}

struct Face {
    Vec3 scaled; // normal, with the triangle's area as length
    Vec3 unit;   // zero for a triangle without area
};

std::vector<Face> facesOf(const Model& model) {
    std::vector<Face> faces(model.triangles.size());
    for (size_t i = 0; i < faces.size(); ++i) {
        const Triangle& t = model.triangles[i];
        Vec3 u = subtract(model.positions[t.b], model.positions[t.a]);
        Vec3 v = subtract(model.positions[t.c], model.positions[t.a]);
        Vec3 scaled = {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
        faces[i].unit = scaled;
        if (normalize(faces[i].unit))
            faces[i].scaled = scaled;
        else
            faces[i].unit = {};
    }
    return faces;
}

uint32_t& corner(Model& model, uint32_t number) {
    Triangle& t = model.triangles[number / 3];
    return number % 3 == 0 ? t.a : number % 3 == 1 ? t.b : t.c;
}

// Corners (triangle * 3 + place) around each vertex that needs a normal, one list after the other.
struct Corners {
    std::vector<uint32_t> starts, list;
};

Corners gather(Model& model, const std::vector<bool>& missing) {
    Corners corners;
    uint32_t count = uint32_t(model.triangles.size()) * 3;
    corners.starts.assign(missing.size() + 1, 0);
    for (uint32_t i = 0; i < count; ++i)
        if (missing[corner(model, i)])
            ++corners.starts[corner(model, i) + 1];
    for (size_t v = 0; v < missing.size(); ++v)
        corners.starts[v + 1] += corners.starts[v];
    corners.list.resize(corners.starts.back());
    std::vector<uint32_t> next(corners.starts.begin(), corners.starts.end() - 1);
    for (uint32_t i = 0; i < count; ++i)
        if (missing[corner(model, i)])
            corners.list[next[corner(model, i)]++] = i;
    return corners;
}

// Normal of one corner, from the corners around the same vertex.
Vec3 cornerNormal(uint32_t own, const uint32_t* begin, const uint32_t* end,
                  const std::vector<Face>& faces) {
    const Face& face = faces[own / 3];
    Vec3 sum;
    for (const uint32_t* other = begin; other != end; ++other)
        if (dot(face.unit, faces[*other / 3].unit) >= kCreaseCosine)
            sum = add(sum, faces[*other / 3].scaled);
    if (!normalize(sum))
        sum = dot(face.unit, face.unit) > 0.0f ? face.unit : Vec3{0.0f, 1.0f, 0.0f};
    return sum;
}

// Gives the corners [begin, end) of vertex `v` their normals, copying the vertex where they differ.
void splitVertex(Model& model, uint32_t v, const uint32_t* begin, const uint32_t* end,
                 const std::vector<Face>& faces) {
    std::vector<uint32_t> copies; // vertices made for v so far, v itself first
    for (const uint32_t* i = begin; i != end; ++i) {
        Vec3 normal = cornerNormal(*i, begin, end, faces);
        uint32_t chosen = ~0u;
        for (uint32_t copy : copies)
            if (dot(model.normals[copy], normal) > 0.9999f)
                chosen = copy;
        if (chosen == ~0u && copies.empty()) {
            chosen = v;
            model.normals[v] = normal;
        } else if (chosen == ~0u) {
            chosen = uint32_t(model.positions.size());
            Vec3 position = model.positions[v]; // push_back may move it
            model.positions.push_back(position);
            model.normals.push_back(normal);
            if (!model.texcoords.empty())
                model.texcoords.push_back(Vec2(model.texcoords[v]));
            if (!model.colors.empty())
                model.colors.push_back(Vec4(model.colors[v]));
        }
        if (copies.empty() || copies.back() != chosen)
            copies.push_back(chosen);
        corner(model, *i) = chosen;
    }
}

void smoothVertex(Model& model, uint32_t v, const uint32_t* begin, const uint32_t* end,
                  const std::vector<Face>& faces) {
    Vec3 sum;
    for (const uint32_t* i = begin; i != end; ++i)
        sum = add(sum, faces[*i / 3].scaled);
    if (normalize(sum))
        model.normals[v] = sum;
}

} // namespace

void completeNormals(Model& model) {
    size_t vertexCount = model.positions.size();
    model.normals.resize(vertexCount);
    std::vector<bool> missing(vertexCount);
    for (size_t i = 0; i < vertexCount; ++i) {
        missing[i] = !normalize(model.normals[i]);
        if (missing[i])
            model.normals[i] = {0.0f, 1.0f, 0.0f};
    }
    std::vector<Face> faces = facesOf(model);
    Corners corners = gather(model, missing);
    for (uint32_t v = 0; v < vertexCount; ++v) {
        const uint32_t* begin = corners.list.data() + corners.starts[v];
        const uint32_t* end = corners.list.data() + corners.starts[v + 1];
        // Vertices with more corners (the tip of a cone, or hostile files) get one common normal,
        // because comparing all pairs would take too long.
        constexpr ptrdiff_t kMostCorners = 256;
        if (end - begin > kMostCorners)
            smoothVertex(model, v, begin, end, faces);
        else
            splitVertex(model, v, begin, end, faces);
    }
}

} // namespace model
