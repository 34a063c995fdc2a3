// SPDX-License-Identifier: Apache-2.0
// Triangle meshes from files: OBJ, glTF (.gltf, .glb) and PLY. Files are not trusted: loaders check
// counts, indices and sizes against the file's actual contents, and report each fault in one clear
// line.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace model {

struct Vec3 {
    float x = 0, y = 0, z = 0;
};

struct Vec2 {
    float x = 0, y = 0;
};

struct Vec4 {
    float x = 1, y = 1, z = 1, w = 1;
};

struct Triangle {
    uint32_t a, b, c; // vertex numbers
};

// The meaning of the product of a material's, a vertex's and a texture's alpha.
enum class Alpha { kOpaque, kCutOut, kBlend };

struct Material {
    Vec3 color = {0.72f, 0.7f, 0.67f};
    Vec3 emission;
    float roughness = 0.45f;
    float metallic = 0.0f;
    Alpha alpha = Alpha::kOpaque;
    float opacity = 1.0f;
    float cutoff = 0.5f; // of kCutOut: less alpha is a hole
    int texture = -1;    // of the colour; -1: none
};

// sRGB bytes and linear alpha, 4 a texel, top row first.
struct Texture {
    unsigned width = 0, height = 0;
    std::vector<uint8_t> rgba;
};

// The result of every loader: at least one triangle, all indices in range, all positions finite, a
// unit normal for each vertex, a material for each triangle.
struct Model {
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;
    std::vector<Vec2> texcoords; // empty, or one for each vertex; (0, 0) is the texture's top left
    std::vector<Vec4> colors;    // empty, or one for each vertex: linear colour and alpha
    std::vector<Triangle> triangles;
    std::vector<uint32_t> materialOfTriangle;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<std::string>
        missing;                 // unusable files that the model names, with causes
    size_t skippedTriangles = 0; // dropped for a coordinate that is no number or beyond 1e18
};

// A file that cannot be used; the text names the file and the cause.
class ModelError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// Chooses the loader by the file name's ending. Throws ModelError.
Model load(const std::string& path);

// One loader for each format. Loaders throw ModelError without the file's name; the caller then
// calls finish().
Model loadObj(const std::string& path);
Model loadGltf(const std::string& path);
Model loadPly(const std::string& path);

// The whole file; ModelError if it cannot be read.
std::string readFile(const std::string& path);

// Decodes a PNG or JPEG picture; ModelError for other bytes.
Texture decodePicture(const std::string& bytes);

// The bytes of a file beside the model in `folder`. Other files are refused, because a model must
// not read arbitrary files. The ModelError names the file.
std::string readBeside(const std::string& folder, const std::string& name);

// The linear value of an sRGB one from 0 to 1.
float linearOf(float encoded);

// Establishes the invariants of Model: checks indices, drops triangles that are not finite,
// completes the normals.
void finish(Model& model);

// Normalises given normals, and computes missing (zero) normals from neighbouring triangles, but
// not across edges sharper than 50 degrees; vertices there are split. Indices must be in range,
// positions finite.
void completeNormals(Model& model);

} // namespace model
