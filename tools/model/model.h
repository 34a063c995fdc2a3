// SPDX-License-Identifier: Apache-2.0
// Triangle meshes from files: OBJ, glTF (.gltf, .glb) and PLY. Files are not trusted: counts,
// indices and sizes are checked against the file's actual contents, and every fault becomes one
// clear line.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace model {

struct Vec3 {
    float x = 0, y = 0, z = 0;
};

struct Triangle {
    uint32_t a, b, c; // vertex numbers
};

struct Material {
    Vec3 color = {0.72f, 0.7f, 0.67f};
    Vec3 emission;
    float roughness = 0.45f;
    float metallic = 0.0f;
};

// The result of every loader: at least one triangle, all indices in range, all positions finite, a
// unit normal for each vertex, a material for each triangle.
struct Model {
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;
    std::vector<Triangle> triangles;
    std::vector<uint32_t> materialOfTriangle;
    std::vector<Material> materials;
    size_t skippedTriangles = 0; // dropped for a position that is not finite
};

// A file that cannot be used; the text names the file and the cause.
class ModelError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// Chooses the loader by the file name's ending. Throws ModelError.
Model load(const std::string& path);

// One loader for each format; these throw ModelError without the file's name, and leave finish()
// to do the rest.
Model loadObj(const std::string& path);
Model loadGltf(const std::string& path);
Model loadPly(const std::string& path);

// The whole file; ModelError if it cannot be read.
std::string readFile(const std::string& path);

// Establishes the invariants of Model: checks indices, drops triangles that are not finite,
// completes the normals.
void finish(Model& model);

// Brings given normals to unit length and computes those that are missing (zero), from the
// neighbouring triangles, but not across edges sharper than 50 degrees: a vertex there is split.
// Indices must be in range, positions finite.
void completeNormals(Model& model);

} // namespace model
