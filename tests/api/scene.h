// SPDX-License-Identifier: Apache-2.0
// Acceleration structures for tests, and the expected hits of rays in them: brute force in double
// precision, with the traversal rules of the manual.
#pragma once

#include "fixture.h"

#include <array>
#include <random>

namespace tests::api {

struct Vec3 {
    float x, y, z;
};

using Matrix = std::array<float, 12>; // 3x4, rows
Matrix identity();
Matrix translation(float x, float y, float z);
Matrix randomAffine(std::mt19937& random, float spread); // well conditioned
Vec3 transformPoint(const Matrix& m, Vec3 p);
Vec3 transformVector(const Matrix& m, Vec3 v);
Matrix inverse(const Matrix& m);

// A structure in memory of exactly the computed size.
struct Accel {
    Buffer memory;
    OptixTraversableHandle handle = 0;
};

OptixAccelBuildOptions buildOptions(unsigned flags = 0);

// Sizes, build, wait; throws with the log on failure. Scratch memory is overwritten afterwards.
Accel buildAccel(OptixDeviceContext context, const LogRecord& log,
                 const std::vector<OptixBuildInput>& inputs, unsigned flags = 0,
                 const std::vector<OptixAccelEmitDesc>& emit = {});
Accel buildAccel(OptixDeviceContext context, const LogRecord& log,
                 const std::vector<OptixBuildInput>& inputs, const OptixAccelBuildOptions& options,
                 const std::vector<OptixAccelEmitDesc>& emit);

// One build input of float3 triangles with 32-bit indices, and its data. Must not move: the input
// points into it.
struct TriangleMesh {
    TriangleMesh(const std::vector<Vec3>& vertices, const std::vector<uint32_t>& indices,
                 std::vector<unsigned> geometryFlags = {0});
    TriangleMesh(const TriangleMesh&) = delete;
    // Per-triangle SBT records, as 32-bit indices.
    void setSbtIndices(const std::vector<uint32_t>& perTriangle);

    std::vector<Vec3> points;
    std::vector<uint32_t> corners;
    std::vector<uint32_t> sbtIndices;
    std::vector<unsigned> flags;
    Buffer vertices, indices, sbt;
    CUdeviceptr vertexAddress;
    OptixBuildInput input{};
};

struct CustomBoxes {
    explicit CustomBoxes(const std::vector<OptixAabb>& boxes,
                         std::vector<unsigned> geometryFlags = {0});
    CustomBoxes(const CustomBoxes&) = delete;
    std::vector<unsigned> flags;
    Buffer memory;
    CUdeviceptr address;
    OptixBuildInput input{};
};

struct InstanceList {
    explicit InstanceList(const std::vector<OptixInstance>& list);
    InstanceList(const InstanceList&) = delete;
    Buffer memory;
    OptixBuildInput input{};
};

OptixInstance instanceOf(OptixTraversableHandle child, const Matrix& transform, unsigned id = 0,
                         unsigned sbtOffset = 0, unsigned mask = 255, unsigned flags = 0);

// ---- The host's side ----------------------------------------------------------------------------

struct Ray {
    Vec3 origin{0, 0, 0};
    Vec3 direction{0, 0, 1};
    float tmin = 0;
    float tmax = 1e16f;
    unsigned mask = 255;
    unsigned flags = 0;
};

// A triangle of the reference, in object space.
struct ReferenceTriangle {
    Vec3 v[3];
    unsigned primitive;
    unsigned sbtGasIndex;
    unsigned geometryFlags;
};

struct ReferenceInstance {
    OptixInstance instance;
    const std::vector<ReferenceTriangle>* gas;
};

// One crossing of a triangle's plane inside the triangle.
struct Crossing {
    double t, u, v;
    bool back; // after instance flips
    bool anyHitEnabled;
    unsigned primitive, sbtGasIndex, instance;
};

// All crossings that pass the rules (mask, interval, culling), nearest first. `ambiguous`: rounding
// may decide differently (an edge, two equal distances, an end of the interval).
std::vector<Crossing> crossings(const std::vector<ReferenceInstance>& scene, const Ray& ray,
                                bool& ambiguous);

// The triangles of meshes in the order of build inputs of one structure.
std::vector<ReferenceTriangle> referenceOf(const std::vector<const TriangleMesh*>& meshes);

// A structure used without instances.
ReferenceInstance bare(const std::vector<ReferenceTriangle>& gas);

} // namespace tests::api
