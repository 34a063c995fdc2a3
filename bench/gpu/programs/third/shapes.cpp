// SPDX-License-Identifier: Apache-2.0
#include "shapes.h"

#include "sampling.h"

#include <cmath>

namespace bench {

void append(Mesh& mesh, const Mesh& other, float3 scale, float3 at) {
    const uint32_t first = mesh.numVertices();
    for (size_t i = 0; i < other.vertices.size(); i += 3)
        mesh.vertices.insert(mesh.vertices.end(), {scale.x * other.vertices[i] + at.x,
                                                   scale.y * other.vertices[i + 1] + at.y,
                                                   scale.z * other.vertices[i + 2] + at.z});
    for (const uint32_t i : other.indices)
        mesh.indices.push_back(first + i);
}

Mesh makeBox(float3 low, float3 high) {
    Mesh mesh;
    for (unsigned i = 0; i < 8; ++i)
        mesh.vertices.insert(mesh.vertices.end(), {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y,
                                                   i & 4 ? high.z : low.z});
    mesh.indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                    2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    return mesh;
}

Mesh makeLathe(const std::vector<float2>& profile, unsigned sectors, unsigned teeth) {
    Mesh mesh;
    for (const float2 p : profile)
        for (unsigned s = 0; s < sectors; ++s) {
            const float turns = float(s) / float(sectors);
            const float2 c = circlePoint(turns);
            const bool isGap = teeth > 0 && unsigned(2 * float(teeth) * turns) % 2 == 1;
            const float r = p.x * (isGap ? 0.85f : 1.0f);
            mesh.vertices.insert(mesh.vertices.end(), {r * c.x, p.y, r * c.y});
        }
    for (unsigned ring = 0; ring + 1 < profile.size(); ++ring)
        for (unsigned s = 0; s < sectors; ++s) {
            const unsigned a = ring * sectors + s, b = ring * sectors + (s + 1) % sectors;
            const unsigned c = a + sectors, d = b + sectors;
            mesh.indices.insert(mesh.indices.end(), {a, c, b, b, c, d});
        }
    return mesh;
}

Placement placed(float3 at, float scale, float turns) {
    const float2 c = circlePoint(turns - std::floor(turns));
    return {
        {scale * c.x, 0, scale * c.y, at.x, 0, scale, 0, at.y, -scale * c.y, 0, scale * c.x, at.z}};
}

std::vector<float3> smoothNormals(const Mesh& mesh) {
    std::vector<float3> normals(mesh.numVertices(), vec(0));
    const auto at = [&](uint32_t i) {
        return vec(mesh.vertices[3 * i], mesh.vertices[3 * i + 1], mesh.vertices[3 * i + 2]);
    };
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const uint32_t* const t = &mesh.indices[i];
        const float3 normal = cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
        for (unsigned k = 0; k < 3; ++k)
            normals[t[k]] += normal;
    }
    for (float3& n : normals)
        n = normalize(n + vec(0, 1e-20f, 0));
    return normals;
}

} // namespace bench
