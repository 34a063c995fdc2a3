// SPDX-License-Identifier: Apache-2.0
// Queries on a GPU: the builder's kernels build structures, persistent warps trace batches
// (bvh/gpu/batch/kernels.cu). Arrays of the host are copied to the device and back.
#include "engine/queries/queries.h"
#include "base/error.h"
#include "base/log.h"
#include "bvh/gpu/batch/batches.h"
#include "bvh/gpu/build/builder.h"
#include "bvh/layout.h"
#include "device/cuda/gpu_device.h"
#include "engine/gpu/code/kernel_code.h"
#include "engine/gpu/structures.h"

#include <algorithm>
#include <cstring>
#include <map>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

constexpr unsigned kLeastCapability = 70;

class DeviceMemory {
public:
    DeviceMemory(CUcontext context, uint64_t size) : context_(context), size_(size) {
        if (size)
            SUNSTONE_CU(memAlloc, &address_, size);
    }
    ~DeviceMemory() {
        try {
            ContextScope scope(context_);
            if (address_)
                driver().memFree(address_);
        } catch (const Error&) { // the application has destroyed its context
        }
    }
    DeviceMemory(const DeviceMemory&) = delete;
    DeviceMemory& operator=(const DeviceMemory&) = delete;
    CUdeviceptr address() const { return address_; }
    uint64_t size() const { return size_; }

private:
    CUcontext context_;
    CUdeviceptr address_ = 0;
    uint64_t size_;
};
using MemoryPtr = std::shared_ptr<DeviceMemory>;

struct GpuStructure final : QueryStructure {
    MemoryPtr memory, triangleMasks, maskTables;
    std::vector<StructurePtr> children;
};

// Memory and events that queries reuse, because allocation waits for the GPU.
class ScratchPool {
public:
    explicit ScratchPool(CUcontext context) : context_(context) {}
    ~ScratchPool() {
        try {
            ContextScope scope(context_);
            for (const CUevent event : events_)
                driver().eventDestroy(event);
        } catch (const Error&) { // the application has destroyed its context
        }
    }
    ScratchPool(const ScratchPool&) = delete;
    ScratchPool& operator=(const ScratchPool&) = delete;
    // Of the context, which is current.
    CUevent takeEvent() {
        {
            std::lock_guard lock(mutex_);
            if (!events_.empty()) {
                const CUevent event = events_.back();
                events_.pop_back();
                return event;
            }
        }
        CUevent event = nullptr;
        SUNSTONE_CU(eventCreate, &event, CU_EVENT_DISABLE_TIMING);
        return event;
    }
    void giveEvent(CUevent event) {
        std::lock_guard lock(mutex_);
        events_.push_back(event);
    }
    MemoryPtr take(uint64_t size) {
        {
            std::lock_guard lock(mutex_);
            const auto found = free_.lower_bound(size);
            // Skip memory that is much too large: others may need it.
            if (found != free_.end() && found->first <= 2 * size + kSmall) {
                MemoryPtr memory = found->second;
                free_.erase(found);
                return memory;
            }
        }
        return std::make_shared<DeviceMemory>(context_, size);
    }
    void give(MemoryPtr memory) {
        std::lock_guard lock(mutex_);
        if (free_.size() >= kMost)
            free_.erase(free_.begin());
        free_.emplace(memory->size(), std::move(memory));
    }

private:
    static constexpr uint64_t kSmall = 4096;
    static constexpr size_t kMost = 16;
    CUcontext context_;
    std::mutex mutex_;
    std::multimap<uint64_t, MemoryPtr> free_;
    std::vector<CUevent> events_;
};

// The end of work on a stream, as an event.
class GpuCompletion final : public Completion {
public:
    GpuCompletion(CUcontext context, CUstream stream, std::shared_ptr<ScratchPool> pool,
                  std::vector<MemoryPtr> scratch, StructurePtr structure)
        : context_(context), pool_(std::move(pool)), scratch_(std::move(scratch)),
          structure_(std::move(structure)), event_(pool_->takeEvent()) {
        SUNSTONE_CU(eventRecord, event_, stream);
    }
    ~GpuCompletion() override {
        try {
            wait();
        } catch (const Error& error) {
            log(LogLevel::kWarning, "engine", error.what());
        }
        pool_->giveEvent(event_);
    }
    void wait() override {
        std::lock_guard lock(mutex_);
        if (ended_)
            return;
        ended_ = true;
        ContextScope scope(context_);
        SUNSTONE_CU(eventSynchronize, event_);
        for (MemoryPtr& memory : scratch_)
            pool_->give(std::move(memory));
        scratch_.clear();
        structure_ = nullptr;
    }
    bool isDone() override {
        std::unique_lock lock(mutex_, std::try_to_lock);
        if (!lock)
            return false; // a thread waits
        ContextScope scope(context_);
        return ended_ || driver().eventQuery(event_) != CUDA_ERROR_NOT_READY;
    }

private:
    CUcontext context_;
    std::shared_ptr<ScratchPool> pool_;
    std::vector<MemoryPtr> scratch_;
    StructurePtr structure_;
    CUevent event_;
    std::mutex mutex_;
    bool ended_ = false;
};

class GpuQueries final : public QueryDevice {
public:
    explicit GpuQueries(CUcontext context)
        : device_(supported(context)),
          code_(device_.computeCapability(), device_.driverVersion(), usableKernelImages()),
          pool_(std::make_shared<ScratchPool>(context)) {
        auto cache = std::make_shared<CompileCache>(
            [](LogLevel level, const std::string& text) { log(level, "engine", text); });
        cache->start();
        code_.useCache(std::move(cache));
        ContextScope scope(context);
        builder_ = std::make_unique<bvh::gpu::Builder>(driver(), &code_);
        batches_ = std::make_unique<bvh::gpu::Batches>(driver(), &code_);
    }
    ~GpuQueries() override {
        try {
            ContextScope scope(device_.context());
            builder_.reset();
            batches_.reset();
        } catch (const Error&) { // the application has destroyed its context, and modules with it
            (void)builder_.release();
            (void)batches_.release();
        }
    }

    StructurePtr build(const ModelTriangles& triangles) override {
        ContextScope scope(device_.context());
        const MemoryPtr vertices = upload(triangles.vertices, 12),
                        indices = upload(triangles.indices, triangles.hasMasks ? 16 : 12);
        bvh::TriangleInput input;
        input.vertices = placeOf(triangles.vertices, vertices);
        input.vertexStride = triangles.vertices.stride;
        input.numVertices = uint32_t(triangles.vertices.count);
        input.numTriangles = uint32_t(triangles.triangles());
        if (triangles.indices.address) {
            input.indices = placeOf(triangles.indices, indices);
            input.indexFormat = bvh::IndexFormat::kUint3;
            input.indexStride = triangles.indices.stride;
        }
        bvh::BuildInputs inputs;
        inputs.triangles = {&input, 1};
        auto result = std::make_shared<GpuStructure>();
        result->memory = buildBlock(inputs);
        result->triangles = triangles.triangles();
        if (triangles.hasMasks)
            result->triangleMasks = masksOf(input.indices, triangles.indices.count);
        describe(*result, devlib::kTagGas);
        return result;
    }

    StructurePtr build(const ModelInstances& instances) override {
        ContextScope scope(device_.context());
        const size_t count = instances.models.size();
        std::vector<uint8_t> copied;
        const auto* transforms = static_cast<const uint8_t*>(instances.transforms.address);
        if (!instances.transforms.onHost && count) {
            copied.resize((count - 1) * instances.transforms.stride + sizeof(float[12]));
            SUNSTONE_CU(memcpyDtoH, copied.data(), CUdeviceptr(transforms), copied.size());
            transforms = copied.data();
        }
        std::vector<bvh::InstanceDesc> descs(count);
        std::vector<uint64_t> tables;
        auto result = std::make_shared<GpuStructure>();
        result->hasMasks = true;
        for (size_t i = 0; i < count; ++i) {
            std::memcpy(descs[i].transform, transforms + i * instances.transforms.stride,
                        sizeof(descs[i].transform));
            descs[i].instanceId = uint32_t(i);
            descs[i].visibilityMask = 255;
            descs[i].traversableHandle = instances.models[i]->handle;
            tables.push_back(instances.models[i]->masks);
            result->hasMasks &= instances.models[i]->hasMasks;
        }
        const QueryArray array = {descs.data(), count, sizeof(bvh::InstanceDesc), true};
        const MemoryPtr records = upload(array, sizeof(bvh::InstanceDesc));
        bvh::InstanceInput input;
        input.instances = placeOf(array, records);
        input.numInstances = uint32_t(count);
        bvh::BuildInputs inputs;
        inputs.instances = &input;
        result->memory = buildBlock(inputs);
        result->maskTables = upload({tables.data(), count, 8, true}, 8);
        result->children = instances.models;
        result->isInstances = true;
        result->handle = result->memory->address() | devlib::kTagIas;
        result->masks = result->maskTables ? result->maskTables->address() : 0;
        return result;
    }

    StructurePtr withMasks(const StructurePtr& structure,
                           const ModelTriangles& triangles) override {
        ContextScope scope(device_.context());
        const auto& from = static_cast<const GpuStructure&>(*structure);
        auto result = std::make_shared<GpuStructure>();
        result->memory = from.memory;
        result->triangles = from.triangles;
        const MemoryPtr indices = upload(triangles.indices, 16);
        result->triangleMasks =
            masksOf(placeOf(triangles.indices, indices), triangles.indices.count);
        describe(*result, devlib::kTagGas);
        return result;
    }

    StructurePtr copy(const StructurePtr& structure, QueryDevice& owner) override {
        if (owner.usesCpuLayout())
            fail(Code::kNotSupported, "a model of the CPU cannot be copied to a GPU");
        const Image from = owner.image(*structure);
        ContextScope scope(device_.context());
        auto result = std::make_shared<GpuStructure>();
        result->memory = upload({from.block.data(), from.block.size(), 1, true}, 1);
        result->triangles = structure->triangles;
        result->triangleMasks = upload({from.masks.data(), from.masks.size(), 4, true}, 4);
        describe(*result, devlib::kTagGas);
        return result;
    }

    Image image(const QueryStructure& structure) override {
        const auto& from = static_cast<const GpuStructure&>(structure);
        ContextScope scope(device_.context());
        Image image;
        image.block.resize(from.memory->size());
        SUNSTONE_CU(memcpyDtoH, image.block.data(), from.memory->address(), image.block.size());
        if (from.triangleMasks) {
            image.masks.resize(from.triangles);
            SUNSTONE_CU(memcpyDtoH, image.masks.data(), from.triangleMasks->address(),
                        image.masks.size() * 4);
        }
        return image;
    }
    bool usesCpuLayout() const override { return false; }

    CompletionPtr trace(const TraceRequest& request) override {
        ContextScope scope(device_.context());
        const auto stream = CUstream(request.stream);
        device_.streamContext(request.stream); // throws unless it is alive
        bvh::RayBatch batch = request.batch();
        const uint64_t rayBytes = batch.count * bvh::rayBytes(batch.rayFormat);
        const bool bits = batch.hitFormat == bvh::HitFormat::kBit;
        const uint64_t hitBytes = bits ? (batch.firstBit + batch.count + 7) / 8
                                       : batch.count * bvh::hitBytes(batch.hitFormat);
        std::vector<MemoryPtr> scratch;
        const auto take = [&](uint64_t bytes) {
            return scratch.emplace_back(pool_->take(bytes))->address();
        };
        const CUdeviceptr own = take(bvh::gpu::Batches::scratchBytes(batch));
        if (batch.count && request.raysOnHost) {
            batch.rays = take(rayBytes);
            SUNSTONE_CU(memcpyHtoDAsync, batch.rays, request.rays, rayBytes, stream);
        }
        if (batch.count && request.hitsOnHost) {
            batch.hits = take(hitBytes);
            if (bits) // bits beside the range keep their values
                SUNSTONE_CU(memcpyHtoDAsync, batch.hits, request.hits, hitBytes, stream);
        }
        batches_->trace(stream, batch, request.any, request.structure->isInstances, own);
        if (batch.count && request.hitsOnHost)
            SUNSTONE_CU(memcpyDtoHAsync, request.hits, batch.hits, hitBytes, stream);
        return std::make_shared<GpuCompletion>(device_.context(), stream, pool_, std::move(scratch),
                                               request.structure);
    }

    bool isDeviceMemory(const void* address, uint64_t bytes) override {
        return device_.isAccessible(address, bytes);
    }

private:
    static CUcontext supported(CUcontext context) {
        const GpuDevice device(context);
        if (device.computeCapability() < kLeastCapability)
            fail(Code::kNotSupported, device.name(),
                 ": GPUs from compute capability 7.0 on are supported");
        return context;
    }

    // A copy of an array of the host in device memory; null if there is nothing to copy.
    MemoryPtr upload(const QueryArray& array, uint64_t elementBytes) {
        if (!array.onHost || !array.address || array.count == 0)
            return nullptr;
        const uint64_t bytes = (array.count - 1) * array.stride + elementBytes;
        auto memory = std::make_shared<DeviceMemory>(device_.context(), bytes);
        SUNSTONE_CU(memcpyHtoD, memory->address(), array.address, bytes);
        return memory;
    }
    static const void* placeOf(const QueryArray& array, const MemoryPtr& copy) {
        return copy ? reinterpret_cast<const void*>(copy->address()) : array.address;
    }

    // A built and compacted structure.
    MemoryPtr buildBlock(const bvh::BuildInputs& inputs) {
        bvh::BuildOptions options;
        options.preferFastTrace = true;
        options.allowCompaction = true;
        const bvh::MemoryUsage usage = bvh::gpu::Builder::computeMemoryUsage(inputs, options);
        builder_->prepare(inputs, options);
        const DeviceMemory temp(device_.context(), usage.temp),
            loose(device_.context(), usage.output), sizeWord(device_.context(), 8);
        builder_->build(nullptr, inputs, options, temp.address(), usage.temp, loose.address(),
                        usage.output);
        builder_->emitCompactedSize(nullptr, loose.address(), sizeWord.address());
        uint64_t size = 0;
        SUNSTONE_CU(memcpyDtoHAsync, &size, sizeWord.address(), 8, nullptr);
        SUNSTONE_CU(streamSynchronize, nullptr);
        std::vector<std::string> remarks;
        for (const std::string& failure : builder_->takeFailures(&remarks))
            fail(Code::kInternal, failure);
        if (size == 0 || size > usage.output)
            fail(Code::kInternal, "a build on the GPU reports ", size, " bytes");
        auto block = std::make_shared<DeviceMemory>(device_.context(), size);
        builder_->compact(nullptr, loose.address(), block->address(), size);
        SUNSTONE_CU(streamSynchronize, nullptr);
        return block;
    }

    MemoryPtr masksOf(const void* indices, uint64_t count) {
        auto masks = std::make_shared<DeviceMemory>(device_.context(), 4 * count);
        batches_->copyMasks(nullptr, CUdeviceptr(indices), masks->address(), count);
        SUNSTONE_CU(streamSynchronize, nullptr);
        return masks;
    }

    static void describe(GpuStructure& structure, devlib::HandleTag tag) {
        structure.handle = structure.memory->address() | tag;
        structure.hasMasks = structure.triangleMasks != nullptr;
        structure.masks = structure.hasMasks ? structure.triangleMasks->address() : 0;
    }

    GpuDevice device_;
    GpuKernelCode code_;
    std::shared_ptr<ScratchPool> pool_;
    std::unique_ptr<bvh::gpu::Builder> builder_;
    std::unique_ptr<bvh::gpu::Batches> batches_;
};

} // namespace

std::shared_ptr<QueryDevice> gpuQueries(void* cudaContext) {
    return std::make_shared<GpuQueries>(CUcontext(cudaContext));
}

} // namespace sunstone::engine
