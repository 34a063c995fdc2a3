// SPDX-License-Identifier: Apache-2.0
// A scene in host memory, generated or from an OBJ file.
#pragma once

#include "shading.h"

#include <string>
#include <vector>

struct HostTexture {
    unsigned width, height;
    std::vector<unsigned> texels; // as in Texture
};

struct HostScene {
    std::vector<float3> positions;
    std::vector<float3> normals; // one for each position
    std::vector<uint3> triangles;
    std::vector<unsigned> materialOfTriangle;
    std::vector<Material> materials;
    std::vector<float4> colors;    // empty, or one for each position
    std::vector<float2> texcoords; // empty, or one for each position
    std::vector<HostTexture> textures;
};

struct Bounds {
    float3 low, high;
    float3 center() const { return (low + high) * 0.5f; }
    float radius() const { return length(high - low) * 0.5f; }
};
Bounds boundsOf(const HostScene& scene);

// A knotted tube of about `triangles` triangles, standing on y = 0.
HostScene makeKnot(unsigned triangles);

// Triangles and polygons of a Wavefront OBJ file, in one material. Throws std::runtime_error that
// names the file, the line and the fault.
HostScene loadObj(const std::string& path);

// Replaces the normals by averages of the neighbouring triangles' normals.
void computeNormals(HostScene& scene);

// A large square at height `y` under the model.
void addGround(HostScene& scene, const Bounds& model, float y, const Material& material);

// Softboxes and sky that suit a model of these bounds, as shading.h expects them; the mesh pointers
// stay empty.
Scene makeStudio(const Bounds& model);

// A camera that sees the whole model from `azimuth` and `elevation` (degrees); azimuth 0 looks
// along -z. `zoom` above one moves nearer.
Camera orbitCamera(const Bounds& model, float azimuth, float elevation, float zoom, float aspect);
