// SPDX-License-Identifier: Apache-2.0
// Generated scenes and rays for benchmarks: the same bits on every machine and run (hashes, no
// library random numbers).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace bench {

struct Mesh {
    std::string name;
    std::vector<float> vertices;   // 3 per vertex
    std::vector<uint32_t> indices; // 3 per triangle
    float eye[3], target[3];       // a camera that sees the whole scene
    float fovDegrees = 60;
    float aoRadius = 1;

    uint32_t numTriangles() const { return uint32_t(indices.size() / 3); }
    uint32_t numVertices() const { return uint32_t(vertices.size() / 3); }
};

enum class SceneKind { kTerrain, kSoup, kLongThin, kSpheres };

// About `triangles` triangles of a kind.
Mesh makeScene(SceneKind kind, uint32_t triangles);

struct Ray {
    float origin[3];
    float tmin;
    float direction[3];
    float tmax;
};

// Camera rays, one per pixel, in tiles of 8 x 8 pixels.
std::vector<Ray> primaryRays(const Mesh& mesh, uint32_t width, uint32_t height);

// Where a ray met the mesh.
struct SurfacePoint {
    bool hit;
    float t;
    uint32_t triangle;
};

enum class RayKind { kShadow, kAmbientOcclusion, kDiffuse };

// One ray of a kind from each hit point: to a far light, short over the hemisphere, or long over
// it. Points that were not hit give no ray.
std::vector<Ray> secondaryRays(const Mesh& mesh, const std::vector<Ray>& primary,
                               const std::vector<SurfacePoint>& points, RayKind kind);

} // namespace bench
