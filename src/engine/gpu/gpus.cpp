// SPDX-License-Identifier: Apache-2.0
// See gpus.h.
#include "engine/gpu/gpus.h"

#include "base/error.h"
#include "base/log.h"
#include "device/cuda/driver.h"
#include "engine/gpu/backend.h"

#include <map>
#include <mutex>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

constexpr int kLeastMajor = 7;

Gpu describe(int ordinal) {
    CUdevice device = 0;
    SUNSTONE_CU(deviceGet, &device, ordinal);
    Gpu gpu;
    gpu.ordinal = ordinal;
    const auto ask = [&](CUdevice_attribute attribute) {
        int value = 0;
        SUNSTONE_CU(deviceGetAttribute, &value, attribute, device);
        return value;
    };
    char text[256] = {};
    SUNSTONE_CU(deviceGetName, text, int(sizeof text) - 1, device);
    gpu.name = text;
    SUNSTONE_CU(deviceGetPCIBusId, text, int(sizeof text) - 1, device);
    gpu.pciBusId = text;
    gpu.capability[0] = ask(CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR);
    gpu.capability[1] = ask(CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR);
    SUNSTONE_CU(deviceTotalMem, &gpu.memoryBytes, device);
    gpu.multiprocessors = ask(CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT);
    gpu.threadsPerBlock = ask(CU_DEVICE_ATTRIBUTE_MAX_THREADS_PER_BLOCK);
    gpu.clockKhz = ask(CU_DEVICE_ATTRIBUTE_CLOCK_RATE);
    gpu.hasTimeout = ask(CU_DEVICE_ATTRIBUTE_KERNEL_EXEC_TIMEOUT);
    gpu.isTcc = ask(CU_DEVICE_ATTRIBUTE_TCC_DRIVER);
    return gpu;
}

// The primary context, retained once.
CUcontext contextOf(const Gpu& gpu) {
    static auto* const mutex = new std::mutex;
    static auto* const contexts = new std::map<int, CUcontext>;
    std::lock_guard lock(*mutex);
    CUcontext& context = (*contexts)[gpu.ordinal];
    if (!context) {
        CUdevice device = 0;
        SUNSTONE_CU(deviceGet, &device, gpu.ordinal);
        SUNSTONE_CU(devicePrimaryCtxRetain, &context, device);
    }
    return context;
}

std::vector<Gpu> findGpus() {
    std::vector<Gpu> found;
    try {
        int count = 0;
        SUNSTONE_CU(init, 0);
        SUNSTONE_CU(deviceGetCount, &count);
        for (int i = 0; i < count; ++i)
            if (Gpu gpu = describe(i); gpu.capability[0] >= kLeastMajor)
                found.push_back(std::move(gpu));
    } catch (const Error& error) { // no driver, or none that works: the CPU runs programs
        log(LogLevel::kInfo, "engine", message("no CUDA GPU: ", error.what()));
        found.clear();
    }
    return found;
}

} // namespace

const std::vector<Gpu>& gpus() {
    static const auto* const all = new std::vector<Gpu>(findGpus());
    return *all;
}

std::shared_ptr<Backend> createPrimaryBackend(const Gpu& gpu) {
    return createGpuBackend(contextOf(gpu));
}

void warm(const Gpu& gpu, const CompileCache::Log& log) {
    auto cache = std::make_shared<CompileCache>(log);
    cache->start();
    GpuBackend backend(contextOf(gpu));
    backend.useCache(cache);
    backend.prepareKernels();
    backend.prepareReadyKernels(cache->enabled() ? cache.get() : nullptr);
}

int cudaOrdinalOfCpu() {
    return loadedDriver() == LoadedDriver::kCpuDevice ? 0 : -1;
}

size_t freeMemory(const Gpu& gpu) {
    ContextScope scope(contextOf(gpu));
    size_t bytes = 0, total = 0;
    SUNSTONE_CU(memGetInfo, &bytes, &total);
    return bytes;
}

} // namespace sunstone::engine
