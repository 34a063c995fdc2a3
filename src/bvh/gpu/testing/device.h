// SPDX-License-Identifier: Apache-2.0
// For tests: the CPU device's driver as a table, device memory that is host memory, structures
// built with the GPU's kernels, and a query of the nearest hit by the GPU's traversal compiled for
// the host.
#pragma once

#include "base/error.h"
#include "bvh/gpu/build/builder.h"
#include "bvh/gpu/build/job.h"
#include "bvh/gpu/walk/traversal.h"
#include "bvh/testing/meshes.h"
#include "device/cuda/test_driver.h"

namespace sunstone::bvh::gpu::testing {

class Device {
public:
    static Device& get() {
        static Device device;
        return device;
    }
    const device::cuda::Driver& driver() const { return driver_; }
    // The driver's table, whose functions tests may replace.
    device::cuda::Driver& driverForTests() { return driver_; }
    const Builder& builder() const { return *builder_; }
    // Sets whether builds of few primitives take the kernels of large ones.
    void buildAsLarge(bool all) { builder_->setMostInBlock(all ? 0 : kSmallMost); }

private:
    Device() : driver_(device::cuda::testDriver()) {
        builder_ = std::make_unique<Builder>(driver_);
    }

    device::cuda::Driver driver_;
    std::unique_ptr<Builder> builder_;
};

class Buffer {
public:
    explicit Buffer(size_t size, int fill = 0xCD) : size_(size) {
        if (Device::get().driver().memAlloc(&address_, size ? size : 1))
            fail(Code::kOutOfMemory, size, " bytes");
        std::memset(data(), fill, size);
    }
    ~Buffer() { Device::get().driver().memFree(address_); }
    Buffer(const Buffer&) = delete;
    CUdeviceptr address() const { return address_; }
    size_t size() const { return size_; }
    void* data() const { return reinterpret_cast<void*>(address_); }

private:
    CUdeviceptr address_ = 0;
    size_t size_;
};

// A structure built by the GPU's kernels and compacted.
struct GpuStructure {
    std::shared_ptr<Buffer> memory, loose;
    const BlockHeader& header() const { return *static_cast<const BlockHeader*>(memory->data()); }
    uint64_t handle() const {
        return memory->address() |
               (kindOf(header().type) == BlockType::kInstances ? devlib::kTagIas : devlib::kTagGas);
    }
};

inline GpuStructure buildOnDevice(const BuildInputs& inputs, const BuildOptions& options = {}) {
    const Device& device = Device::get();
    const MemoryUsage usage = Builder::computeMemoryUsage(inputs, options);
    Buffer temp(usage.temp), size(8);
    GpuStructure s;
    s.loose = std::make_shared<Buffer>(usage.output);
    device.builder().build(nullptr, inputs, options, temp.address(), usage.temp, s.loose->address(),
                           usage.output);
    device.builder().emitCompactedSize(nullptr, s.loose->address(), size.address());
    if (device.driver().ctxSynchronize())
        fail(Code::kCudaError, "the build failed");
    const uint64_t compacted = *static_cast<const uint64_t*>(size.data());
    if (compacted > usage.output)
        fail(Code::kInternal, "compacted size ", compacted, " of ", usage.output);
    s.memory = std::make_shared<Buffer>(compacted);
    device.builder().compact(nullptr, s.loose->address(), s.memory->address(), s.memory->size());
    if (device.driver().ctxSynchronize())
        fail(Code::kCudaError, "compaction failed");
    return s;
}

inline GpuStructure buildOnDevice(const TriangleInput& input, const BuildOptions& options = {}) {
    BuildInputs inputs;
    inputs.triangles = {&input, 1};
    return buildOnDevice(inputs, options);
}

// The nearest triangle.
struct NearestPrograms : NoShapes, NoMotion, NoDeepGraphs, OneLane {
    static constexpr bool kTriangles = true, kCustoms = false, kInstances = true;
    static constexpr unsigned kLevels = 4;
    bool found = false;
    TriangleHit hit{};
    uint32_t primitive = ~0u, sbt = 0, instance = 0, current = 0;

    Visit triangle(gpu::Ray& ray, const TriangleHit& h, uint32_t p, uint32_t word) {
        if (h.t < ray.tmax || !found || p < primitive) {
            found = true;
            hit = h;
            ray.tmax = h.t;
            primitive = p;
            sbt = word;
            instance = current;
        }
        return Visit::kContinue;
    }
    Visit custom(gpu::Ray&, uint32_t, uint32_t) { return Visit::kContinue; }
    bool enterInstance(gpu::Ray&, const InstanceRecord& i, uint64_t& child) {
        child = i.child;
        current = i.index;
        return true;
    }
    bool enterTransform(gpu::Ray&, uint64_t, uint64_t&, float*) { return false; }
    void leave(gpu::Ray&, uint32_t = 1) { current = 0; }
    bool nearestFirst() const { return true; }
};

// The nearest triangle with at most one level of instances: leaving an instance restores the ray's
// own space.
struct SingleLevelPrograms : NearestPrograms {
    static constexpr unsigned kLevels = 1;
};
struct FlatPrograms : NearestPrograms {
    static constexpr bool kInstances = false;
    static constexpr unsigned kLevels = 0;
};

template <class Programs>
bool nearestBy(Programs& programs, uint64_t handle, const QueryRay& query, QueryHit& hit) {
    gpu::Ray ray;
    for (int i = 0; i < 3; ++i) {
        ray.origin[i] = query.origin[i];
        ray.direction[i] = query.direction[i];
    }
    ray.tmin = query.tmin;
    ray.tmax = query.tmax;
    Traversal<Programs> traversal;
    U2 stack[Traversal<Programs>::kStackSize];
    typename Traversal<Programs>::Level levels[Programs::kLevels + 1];
    if (!traversal.start(programs, ray, handle, levels))
        return false;
    traversal.run(programs, ray, stack, levels, RunToEnd());
    if (!programs.found)
        return false;
    hit.t = programs.hit.t;
    hit.u = programs.hit.v / programs.hit.det;
    hit.v = programs.hit.w / programs.hit.det;
    hit.front = programs.hit.det > 0;
    hit.primitive = programs.primitive;
    hit.sbt = programs.sbt;
    return true;
}

inline bool nearest(uint64_t handle, const QueryRay& query, QueryHit& hit,
                    uint32_t* instance = nullptr) {
    NearestPrograms programs;
    if (!nearestBy(programs, handle, query, hit))
        return false;
    if (instance)
        *instance = programs.instance;
    return true;
}

// The nearest hit of curves and spheres, without instances.
struct ShapePrograms : NoMotion, OneLane {
    static constexpr bool kTriangles = true, kCustoms = false, kInstances = false;
    static constexpr unsigned kLevels = 0;
    bool found = false;
    ShapeHit hit{};

    static uint32_t shapes() { return shapeBitsOf(~0u); }
    bool meets(uint32_t) const { return true; }
    Visit triangle(gpu::Ray&, const TriangleHit&, uint32_t, uint32_t) { return Visit::kContinue; }
    Visit custom(gpu::Ray&, uint32_t, uint32_t) { return Visit::kContinue; }
    Visit shape(gpu::Ray& ray, const ShapeHit& h) {
        found = true;
        hit = h;
        ray.tmax = h.t;
        return Visit::kContinue;
    }
};

// ShapePrograms at a time.
struct MovingShapePrograms : ShapePrograms {
    static constexpr bool kMotion = true;
    float rayTime = 0;
    float time() const { return rayTime; }
    static bool meetsKeys() { return true; }
};

template <class Programs>
bool nearestShapeBy(Programs& programs, uint64_t handle, const ShapeRay& query, ShapeHit& hit) {
    gpu::Ray ray;
    for (int i = 0; i < 3; ++i) {
        ray.origin[i] = query.origin[i];
        ray.direction[i] = query.direction[i];
    }
    ray.tmin = query.tmin;
    ray.tmax = query.tmax;
    Traversal<Programs> traversal;
    U2 stack[Traversal<Programs>::kStackSize];
    typename Traversal<Programs>::Level levels[1];
    if (!traversal.start(programs, ray, handle, levels))
        return false;
    traversal.run(programs, ray, stack, levels, RunToEnd());
    hit = programs.hit;
    return programs.found;
}

inline bool nearestShape(uint64_t handle, const ShapeRay& query, ShapeHit& hit) {
    ShapePrograms programs;
    return nearestShapeBy(programs, handle, query, hit);
}
inline bool nearestShapeAt(uint64_t handle, const ShapeRay& query, ShapeHit& hit) {
    MovingShapePrograms programs;
    programs.rayTime = query.time;
    return nearestShapeBy(programs, handle, query, hit);
}

// The nearest triangle at a time.
struct MovingPrograms : NearestPrograms {
    static constexpr bool kMotion = true;
    float rayTime;
    KnownSegment known;

    explicit MovingPrograms(float time) : rayTime(time) {}
    float time() const { return rayTime; }
    static bool meetsKeys() { return true; }
    bool enterTransform(gpu::Ray&, uint64_t handle, uint64_t& child, float worldToObject[12]) {
        return worldToObjectOf(handle, rayTime, known, child, worldToObject);
    }
};

inline bool nearestAt(uint64_t handle, const QueryRay& query, float time, QueryHit& hit) {
    MovingPrograms programs(time);
    return nearestBy(programs, handle, query, hit);
}

// MovingPrograms beside lanes in structures with motion.
struct BesideMovingPrograms : MovingPrograms {
    using MovingPrograms::MovingPrograms;
    static bool any(bool) { return true; }
};

} // namespace sunstone::bvh::gpu::testing
