// SPDX-License-Identifier: Apache-2.0
// Ray queries without programs: structures of triangles or instances, and batches of rays. The
// shells of OptiX Prime and of sunstone/rays.h use these objects. Descriptions are checked by the
// shell. A structure never changes once it is built, so queries in progress keep the structures
// that they use.
#pragma once

#include "bvh/batch/batch.h"

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace sunstone::engine {

// An array in memory of the caller.
struct QueryArray {
    const void* address = nullptr;
    uint64_t count = 0;
    uint32_t stride = 0; // bytes from element to element
    bool onHost = true;  // else device memory
};

struct ModelTriangles {
    QueryArray vertices;   // 3 floats each
    QueryArray indices;    // 3 ints each, address null: triangle i has vertices 3i to 3i + 2
    bool hasMasks = false; // a fourth int of each triplet is the triangle's mask
    uint64_t triangles() const { return indices.address ? indices.count : vertices.count / 3; }
};

class QueryStructure {
public:
    virtual ~QueryStructure() = default;
    uint64_t handle = 0, masks = 0; // as in bvh::RayBatch
    uint64_t triangles = 0;         // of a structure of triangles
    bool isInstances = false;
    bool hasMasks = false; // all triangles have
};
using StructurePtr = std::shared_ptr<const QueryStructure>;

struct ModelInstances {
    std::vector<StructurePtr> models;
    QueryArray transforms; // rows of 4 floats; the first three count
};

struct TraceRequest {
    StructurePtr structure;
    const void* rays = nullptr;
    void* hits = nullptr; // of kBit: the byte with the first ray's bit
    uint32_t firstBit = 0;
    bool raysOnHost = true, hitsOnHost = true;
    uint64_t count = 0;
    bvh::RayFormat rayFormat = bvh::RayFormat::kOriginTminDirectionTmax;
    bvh::HitFormat hitFormat = bvh::HitFormat::kTTriangleUv;
    bool any = false;
    void* stream = nullptr; // CUDA only

    bvh::RayBatch batch() const; // with the caller's addresses
};

// Work that may run asynchronously.
class Completion {
public:
    virtual ~Completion() = default;
    // Returns when the work has ended; throws its error, the first time only.
    virtual void wait() = 0;
    virtual bool isDone() = 0;
};
using CompletionPtr = std::shared_ptr<Completion>;

// The end of work on a thread of this process.
class HostCompletion final : public Completion {
public:
    void wait() override;
    bool isDone() override;
    // Runs the work and keeps its error.
    void run(const std::function<void()>& work);

private:
    std::mutex mutex_;
    std::condition_variable ended_;
    bool done_ = false;
    std::exception_ptr error_;
};

class QueryDevice {
public:
    virtual ~QueryDevice() = default;

    // The calls below wait for their work. On streams it follows all earlier work of the default
    // stream.
    virtual StructurePtr build(const ModelTriangles& triangles) = 0;
    virtual StructurePtr build(const ModelInstances& instances) = 0;
    // A structure with the same triangles and the current masks of the indices.
    virtual StructurePtr withMasks(const StructurePtr& structure,
                                   const ModelTriangles& triangles) = 0;
    // A copy of another device's structure of triangles.
    virtual StructurePtr copy(const StructurePtr& structure, QueryDevice& owner) = 0;
    // All bytes of a structure of triangles and of its masks, for copies on other devices, and
    // their format.
    struct Image {
        std::vector<uint8_t> block;
        std::vector<uint32_t> masks;
    };
    virtual Image image(const QueryStructure& structure) = 0;
    virtual bool usesCpuLayout() const = 0;

    // Queues the query; a device without queues runs it at once.
    virtual CompletionPtr trace(const TraceRequest& request) = 0;

    // Whether the device can read and write the range.
    virtual bool isDeviceMemory(const void* address, uint64_t bytes) = 0;
};

// On the CPU; calls return when their work is done.
std::shared_ptr<QueryDevice> cpuQueries();
// On the CPU device of CUDA, in stream order.
std::shared_ptr<QueryDevice> cpuStreamQueries();
// On the GPU of this CUcontext. Throws kNotSupported for devices that are too old.
std::shared_ptr<QueryDevice> gpuQueries(void* cudaContext);

// Whether the host can read (or also write) all of the range. Never faults.
bool isHostReadable(const void* address, uint64_t bytes);
bool isHostWritable(void* address, uint64_t bytes);

} // namespace sunstone::engine
