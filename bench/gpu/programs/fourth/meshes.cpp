// SPDX-License-Identifier: Apache-2.0
#include "meshes.h"

namespace bench {

void append(MaterialMesh& mesh, const Mesh& other, float3 scale, float3 at, unsigned material) {
    const auto first = uint32_t(mesh.vertices.size() / 3);
    for (size_t i = 0; i < other.vertices.size(); i += 3)
        mesh.vertices.insert(mesh.vertices.end(), {scale.x * other.vertices[i] + at.x,
                                                   scale.y * other.vertices[i + 1] + at.y,
                                                   scale.z * other.vertices[i + 2] + at.z});
    for (const uint32_t i : other.indices)
        mesh.indices.push_back(first + i);
    mesh.materials.insert(mesh.materials.end(), other.numTriangles(), uint8_t(material));
}

Mesh makeSheet(unsigned columns, unsigned rows, const std::function<float3(float, float)>& at) {
    Mesh mesh;
    for (unsigned y = 0; y <= rows; ++y)
        for (unsigned x = 0; x <= columns; ++x) {
            const float3 p = at(float(x) / float(columns), float(y) / float(rows));
            mesh.vertices.insert(mesh.vertices.end(), {p.x, p.y, p.z});
        }
    for (unsigned y = 0; y < rows; ++y)
        for (unsigned x = 0; x < columns; ++x) {
            const unsigned a = y * (columns + 1) + x, b = a + 1, c = a + columns + 1, d = c + 1;
            mesh.indices.insert(mesh.indices.end(), {a, c, b, b, c, d});
        }
    return mesh;
}

} // namespace bench
