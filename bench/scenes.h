// SPDX-License-Identifier: Apache-2.0
// Generated scenes and rays for benchmarks. They have the same bits on every machine and in every
// run, because their random numbers are hashes.
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

enum class SceneKind {
    kTerrain,
    kSoup,
    kLongThin,
    kSpheres,
    kOverlapping, // random triangles whose sides differ by a factor of 100
    kInterior,    // a hall: walls of a few triangles, columns, vases and curtains of tiny ones
    kLeaves,      // makeLeaves()
};

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

// A point where a ray met the mesh.
struct SurfacePoint {
    bool hit;
    float t;
    uint32_t triangle;
};

// A point with a normal, of any length and side, in place of the triangle.
struct Surfel {
    bool hit;
    float t;
    float normal[3];
};

enum class RayKind { kShadow, kAmbientOcclusion, kDiffuse };

// One ray of a kind from each hit point: to a far light, short over the hemisphere, or long over
// it. Points without a hit give no ray.
std::vector<Ray> secondaryRays(const Mesh& mesh, const std::vector<Ray>& primary,
                               const std::vector<SurfacePoint>& points, RayKind kind);
std::vector<Ray> secondaryRays(const std::vector<Ray>& primary, const std::vector<Surfel>& points,
                               float aoRadius, RayKind kind);

// The vertices at a second motion key: waves through the scene, of 3 percent of its size, so that
// neighbours move similarly.
std::vector<float> movedVertices(const Mesh& mesh);

// The time of a ray, in random order over [0, 1].
float timeOf(size_t ray);

// A rock of about `triangles` triangles around the origin, its radius near 1.
Mesh makeRock(uint32_t triangles);

// Row-major 3x4 matrices that spread `count` objects of radius 1 over a slab of 100 x 20 x 100,
// with random rotations and uniform scales from 0.4 to 1.2. Neighbours overlap.
std::vector<float> scatter(uint32_t count);

// Leaves over the slab, about `triangles` of them in pairs: each pair is a square whose corners are
// (0, 0), (1, 0), (1, 1) and (0, 0), (1, 1), (0, 1) in its own coordinates.
Mesh makeLeaves(uint32_t triangles);

// Centre and radius of `count` small spheres in a cube; `view` gets a camera that sees them.
std::vector<float> makeBalls(uint32_t count, Mesh& view);

// A camera that looks over the slab.
void lookOverSlab(Mesh& mesh);

} // namespace bench
