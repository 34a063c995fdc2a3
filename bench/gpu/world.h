// SPDX-License-Identifier: Apache-2.0
// The scenes of bench_gpu: their contents, their acceleration structures and the programs that
// trace them.
#pragma once

#include "../scenes.h"
#include "optix_setup.h"
#include "programs.h"

#include <memory>

namespace bench {

enum class WorldKind {
    kTriangles,
    kLeaves,
    kInstances,
    kSpheres,
    kMovingTriangles, // with two motion keys
    kMovingInstances, // with a motion transform below each
};
// Whether rays have times.
inline bool moves(WorldKind kind) {
    return kind == WorldKind::kMovingTriangles || kind == WorldKind::kMovingInstances;
}
inline bool isOfInstances(WorldKind kind) {
    return kind == WorldKind::kInstances || kind == WorldKind::kMovingInstances;
}

// A scene in host memory.
struct World {
    std::string name;
    WorldKind kind = WorldKind::kTriangles;
    Mesh mesh;                   // with the camera; empty for spheres
    std::vector<float> matrices; // of instances: rows of 3 x 4
    std::vector<float> spheres;  // centres and radii
    std::vector<float> later;    // vertices at the second motion key
    unsigned buildFlags = 0;     // of the structure that rays meet

    uint32_t count() const; // of triangles, instances or spheres
    // The point where the ray met the scene, with a normal (for rotating parts, the normal at the
    // first key).
    Surfel surfel(const Ray& ray, const GpuHit& hit, float time) const;
};

// `scale`: factor on the number of primitives; 1 in the tables.
const std::vector<std::string>& worldNames();
World makeWorld(const std::string& name, double scale);

// A structure in its own memory, compacted if its flags allow it.
struct Built {
    OptixTraversableHandle handle = 0;
    DeviceBuffer memory;
    OptixAccelBufferSizes sizes = {};
    uint64_t compactedSize = 0;
    double milliseconds = 0; // the fastest of the builds
};

// A world's data on the device.
class DeviceWorld {
public:
    DeviceWorld(OptixDeviceContext context, const World& world);

    // Builds `repeats` times.
    Built build(unsigned flags, int repeats);
    // Milliseconds of the fastest of `repeats` updates of a structure with these flags.
    double update(unsigned flags, int repeats);
    const DeviceBuffer& spheres() const { return spheres_; }

private:
    void describeTriangles(const World& world);
    void describeInstances(OptixDeviceContext context, const World& world);
    void describeSpheres(const World& world);
    // Handles of a motion transform for each instance, above the child.
    std::vector<OptixTraversableHandle> makeTransforms(size_t count);

    OptixDeviceContext context_;
    DeviceBuffer vertices_, later_, indices_, boxes_, spheres_, instances_, transforms_;
    CUdeviceptr addresses_[2] = {};
    OptixMotionOptions motion_ = {};
    unsigned flags_ = OPTIX_GEOMETRY_FLAG_NONE;
    OptixBuildInput input_ = {};
    std::unique_ptr<DeviceWorld> child_; // the instanced structures
    Built childStructure_;
};

enum class RayQuery { kClosest, kAny };

// The pipeline for a kind of world.
class Tracer {
public:
    Tracer(OptixDeviceContext context, WorldKind kind);

    // Uploads the data of a series of launches.
    void prepare(const GpuRaysParams& params);
    // Queues a launch on the default stream.
    void queue(RayQuery query, size_t count);

private:
    Program program_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer records_, params_;
    OptixShaderBindingTable table_ = {};
};

// The fastest of several repetitions in milliseconds, by events on the default stream. Slow work is
// repeated less often, but at least twice.
double fastest(int repeats, const std::function<void()>& work);

} // namespace bench
