// SPDX-License-Identifier: Apache-2.0
// Queries on the CPU, by the caller's threads or in the order of a stream of the CPU device.
#include "base/error.h"
#include "bvh/build/build.h"
#include "bvh/layout.h"
#include "device/device.h"
#include "engine/queries/queries.h"

#include <sys/mman.h>

#include <cstdlib>
#include <cstring>
#include <utility>

namespace sunstone::engine {
namespace {

// Memory for a structure. Large ones request huge pages, as device memory does.
class Memory {
public:
    explicit Memory(size_t size) {
        constexpr size_t kHugePage = size_t(1) << 21;
        const size_t alignment = size >= 2 * kHugePage ? kHugePage : bvh::kBlockAlignment;
        size_ = (size + alignment - 1) / alignment * alignment;
        address_ = std::aligned_alloc(alignment, size_ ? size_ : alignment);
        if (!address_)
            fail(Code::kOutOfMemory, size, " bytes for an acceleration structure");
        if (alignment == kHugePage)
            madvise(address_, size_, MADV_HUGEPAGE);
    }
    ~Memory() { std::free(address_); }
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;
    void* address() const { return address_; }
    size_t size() const { return size_; }

private:
    void* address_;
    size_t size_;
};

struct HostStructure final : QueryStructure {
    std::shared_ptr<const Memory> memory;
    std::vector<uint32_t> triangleMasks;
    std::vector<uint64_t> maskTables; // of instances
    std::vector<StructurePtr> children;
};

std::shared_ptr<Memory> buildBlock(const bvh::BuildInputs& inputs,
                                   const bvh::BuildOptions& options) {
    const bvh::MemoryUsage usage = bvh::computeMemoryUsage(inputs, options);
    const Memory temp(usage.temp);
    auto output = std::make_shared<Memory>(usage.output);
    bvh::build(inputs, options, temp.address(), usage.temp, output->address(), usage.output);
    return output;
}

std::vector<uint32_t> readMasks(const ModelTriangles& triangles) {
    std::vector<uint32_t> masks;
    if (!triangles.hasMasks)
        return masks;
    masks.resize(triangles.indices.count);
    const auto* const bytes = static_cast<const uint8_t*>(triangles.indices.address);
    for (size_t i = 0; i < masks.size(); ++i)
        std::memcpy(&masks[i], bytes + i * triangles.indices.stride + 12, 4);
    return masks;
}

void describe(HostStructure& structure, const void* block, devlib::HandleTag tag) {
    structure.handle = devlib::makeHandle(block, tag);
    structure.hasMasks = !structure.triangleMasks.empty();
    structure.masks = structure.hasMasks ? uint64_t(structure.triangleMasks.data()) : 0;
}

std::vector<bvh::InstanceDesc> describeInstances(const ModelInstances& instances) {
    std::vector<bvh::InstanceDesc> descs(instances.models.size());
    const auto* const bytes = static_cast<const uint8_t*>(instances.transforms.address);
    for (size_t i = 0; i < descs.size(); ++i) {
        std::memcpy(descs[i].transform, bytes + i * instances.transforms.stride,
                    sizeof(descs[i].transform));
        descs[i].instanceId = uint32_t(i);
        descs[i].visibilityMask = 255;
        descs[i].traversableHandle = instances.models[i]->handle;
    }
    return descs;
}

class CpuQueries : public QueryDevice {
public:
    StructurePtr build(const ModelTriangles& triangles) override {
        begin();
        bvh::TriangleInput input;
        input.vertices = triangles.vertices.address;
        input.vertexStride = triangles.vertices.stride;
        input.numVertices = uint32_t(triangles.vertices.count);
        input.numTriangles = uint32_t(triangles.triangles());
        if (triangles.indices.address) {
            input.indices = triangles.indices.address;
            input.indexFormat = bvh::IndexFormat::kUint3;
            input.indexStride = triangles.indices.stride;
        }
        bvh::BuildInputs inputs;
        inputs.triangles = {&input, 1};
        bvh::BuildOptions options;
        options.preferFastTrace = true;
        auto result = std::make_shared<HostStructure>();
        result->memory = buildBlock(inputs, options);
        result->triangles = triangles.triangles();
        result->triangleMasks = readMasks(triangles);
        describe(*result, result->memory->address(), devlib::kTagGas);
        return result;
    }

    StructurePtr build(const ModelInstances& instances) override {
        begin();
        auto result = std::make_shared<HostStructure>();
        const std::vector<bvh::InstanceDesc> descs = describeInstances(instances);
        bvh::InstanceInput input;
        input.instances = descs.data();
        input.numInstances = uint32_t(descs.size());
        bvh::BuildInputs inputs;
        inputs.instances = &input;
        bvh::BuildOptions options;
        options.preferFastTrace = true;
        result->memory = buildBlock(inputs, options);
        result->children = instances.models;
        result->isInstances = true;
        bool all = true;
        for (const StructurePtr& child : instances.models) {
            result->maskTables.push_back(child->masks);
            all &= child->hasMasks;
        }
        describe(*result, result->memory->address(), devlib::kTagIas);
        result->hasMasks = all;
        result->masks = uint64_t(result->maskTables.data());
        return result;
    }

    StructurePtr withMasks(const StructurePtr& structure,
                           const ModelTriangles& triangles) override {
        begin();
        const auto& from = static_cast<const HostStructure&>(*structure);
        auto result = std::make_shared<HostStructure>();
        result->memory = from.memory;
        result->triangles = from.triangles;
        result->triangleMasks = readMasks(triangles);
        describe(*result, result->memory->address(), devlib::kTagGas);
        return result;
    }

    StructurePtr copy(const StructurePtr& structure, QueryDevice& owner) override {
        if (!owner.usesCpuLayout())
            fail(Code::kNotSupported, "a model of a GPU cannot be copied to the CPU");
        const Image from = owner.image(*structure);
        auto result = std::make_shared<HostStructure>();
        auto memory = std::make_shared<Memory>(from.block.size());
        std::memcpy(memory->address(), from.block.data(), from.block.size());
        result->memory = std::move(memory);
        result->triangles = structure->triangles;
        result->triangleMasks = from.masks;
        describe(*result, result->memory->address(), devlib::kTagGas);
        return result;
    }

    Image image(const QueryStructure& structure) override {
        const auto& from = static_cast<const HostStructure&>(structure);
        const auto* const bytes = static_cast<const uint8_t*>(from.memory->address());
        return {{bytes, bytes + bvh::compactedSize(bytes)}, from.triangleMasks};
    }
    bool usesCpuLayout() const override { return true; }

    CompletionPtr trace(const TraceRequest& request) override {
        auto completion = std::make_shared<HostCompletion>();
        completion->run([&] { bvh::traceBatch(request.batch(), request.any); });
        return completion;
    }

    bool isDeviceMemory(const void* address, uint64_t bytes) override {
        return device::cpuDevice().isAccessible(address, bytes);
    }

protected:
    virtual void begin() {}
};

class CpuStreamQueries final : public CpuQueries {
public:
    CompletionPtr trace(const TraceRequest& request) override {
        auto completion = std::make_shared<HostCompletion>();
        device::cpuDevice().enqueue(request.stream, [request, completion] {
            completion->run([&] { bvh::traceBatch(request.batch(), request.any); });
        });
        return completion;
    }

protected:
    void begin() override { device::cpuDevice().synchronize(nullptr); }
};

} // namespace

bvh::RayBatch TraceRequest::batch() const {
    bvh::RayBatch batch;
    batch.rays = uint64_t(rays);
    batch.hits = uint64_t(hits);
    batch.handle = structure->handle;
    // Rays without masks meet all triangles.
    batch.masks = rayFormat == bvh::RayFormat::kOriginMaskDirectionTmax ? structure->masks : 0;
    batch.count = count;
    batch.rayFormat = rayFormat;
    batch.hitFormat = hitFormat;
    batch.firstBit = firstBit;
    return batch;
}

void HostCompletion::wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return done_; });
    if (std::exception_ptr error = std::exchange(error_, nullptr))
        std::rethrow_exception(error);
}

bool HostCompletion::isDone() {
    std::lock_guard lock(mutex_);
    return done_;
}

void HostCompletion::run(const std::function<void()>& work) {
    std::exception_ptr error;
    try {
        work();
    } catch (...) {
        error = std::current_exception();
    }
    std::lock_guard lock(mutex_);
    error_ = error;
    done_ = true;
    ended_.notify_all();
}

std::shared_ptr<QueryDevice> cpuQueries() {
    return std::make_shared<CpuQueries>();
}

std::shared_ptr<QueryDevice> cpuStreamQueries() {
    return std::make_shared<CpuStreamQueries>();
}

} // namespace sunstone::engine
