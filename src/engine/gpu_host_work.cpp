// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu_host_work.h"

#include <algorithm>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

constexpr size_t kAlignment = 256;

size_t rounded(size_t size) {
    return (size + kAlignment - 1) / kAlignment * kAlignment;
}

struct Task {
    ContextPtr context;
    CUstream stream;
    const char* tag;
    HostWork work;
    std::shared_ptr<GpuHostWork::Failures> failures;

    void keep(const Error& error) const {
        if (context->log)
            context->log(LogLevel::kError, tag, error.what());
        std::lock_guard lock(failures->mutex);
        failures->first.emplace(stream, error);
    }
};

// Nothing may leave a callback of the driver. What failed work was to write stays as it was.
void CUDA_CB runTask(void* data) {
    const std::unique_ptr<Task> task(static_cast<Task*>(data));
    try {
        task->work.run(task->work.regions);
    } catch (const Error& error) {
        task->keep(error);
    } catch (const std::exception& error) {
        task->keep(Error(Code::kInternal, error.what()));
    }
}

void throwEarlier(GpuHostWork::Failures& failures, CUstream stream) {
    std::lock_guard lock(failures.mutex);
    const auto found = failures.first.find(stream);
    if (found == failures.first.end())
        return;
    const Error error = found->second;
    failures.first.erase(found);
    throw error;
}

CUDA_MEMCPY2D rowsOf(const HostRegion& region, bool toHost) {
    CUDA_MEMCPY2D copy = {};
    copy.WidthInBytes = region.width;
    copy.Height = region.height;
    if (toHost) {
        copy.srcMemoryType = CU_MEMORYTYPE_DEVICE;
        copy.srcDevice = CUdeviceptr(region.device);
        copy.srcPitch = region.stride;
        copy.dstMemoryType = CU_MEMORYTYPE_HOST;
        copy.dstHost = region.host;
        copy.dstPitch = region.hostStride;
    } else {
        copy.srcMemoryType = CU_MEMORYTYPE_HOST;
        copy.srcHost = region.host;
        copy.srcPitch = region.hostStride;
        copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
        copy.dstDevice = CUdeviceptr(region.device);
        copy.dstPitch = region.stride;
    }
    return copy;
}

} // namespace

GpuHostWork::~GpuHostWork() {
    try {
        ContextScope scope(context_);
        for (const auto& block : blocks_) {
            if (block->done) {
                driver().eventSynchronize(block->done);
                driver().eventDestroy(block->done);
            }
            if (block->memory)
                driver().memFreeHost(block->memory);
        }
    } catch (const Error&) { // the application has destroyed its context, and all of this with it
    }
}

GpuHostWork::Block& GpuHostWork::take(size_t size) {
    Block* found = nullptr;
    for (const auto& block : blocks_)
        if (driver().eventQuery(block->done) == CUDA_SUCCESS &&
            (!found || (found->capacity < size && block->capacity > found->capacity)))
            found = block.get();
    if (!found) {
        auto block = std::make_unique<Block>();
        SUNSTONE_CU(eventCreate, &block->done, CU_EVENT_DISABLE_TIMING);
        found = blocks_.emplace_back(std::move(block)).get();
    }
    if (found->capacity < size) {
        if (found->memory) {
            SUNSTONE_CU(memFreeHost, found->memory);
            found->memory = nullptr;
            found->capacity = 0;
        }
        SUNSTONE_CU(memAllocHost, reinterpret_cast<void**>(&found->memory), size);
        found->capacity = size;
    }
    return *found;
}

void GpuHostWork::run(const ContextPtr& context, CUstream stream, const char* tag, HostWork work) {
    throwEarlier(*failures_, stream);
    ContextScope scope(context_);
    size_t size = 0;
    for (HostRegion& region : work.regions) {
        region.hostStride = region.width;
        region.stride = std::max(region.stride, region.width);
        size += rounded(region.width * region.height);
    }
    std::lock_guard lock(mutex_);
    Block& block = take(std::max(size, kAlignment));
    uint8_t* place = block.memory;
    for (HostRegion& region : work.regions) {
        region.host = place;
        place += rounded(region.width * region.height);
    }
    try {
        queue(context, stream, tag, std::move(work));
    } catch (...) { // what is queued by then still uses the block
        endUse(block, stream);
        throw;
    }
    check(endUse(block, stream), DriverNames::eventRecord);
}

void GpuHostWork::queue(const ContextPtr& context, CUstream stream, const char* tag,
                        HostWork work) {
    const std::vector<HostRegion> regions = work.regions;
    for (const HostRegion& region : regions) {
        const CUDA_MEMCPY2D copy = rowsOf(region, true);
        SUNSTONE_CU(memcpy2DAsync, &copy, stream);
    }
    auto task = std::make_unique<Task>(Task{context, stream, tag, std::move(work), failures_});
    SUNSTONE_CU(launchHostFunc, stream, runTask, task.get());
    (void)task.release();
    for (const HostRegion& region : regions) {
        const CUDA_MEMCPY2D copy = rowsOf(region, false);
        if (region.isWritten)
            SUNSTONE_CU(memcpy2DAsync, &copy, stream);
    }
}

// The block is used again after what the stream does now; where that cannot be marked, the stream
// is waited for.
CUresult GpuHostWork::endUse(Block& block, CUstream stream) {
    const CUresult result = driver().eventRecord(block.done, stream);
    if (result != CUDA_SUCCESS)
        driver().streamSynchronize(stream);
    return result;
}

} // namespace sunstone::engine
