// SPDX-License-Identifier: Apache-2.0
#include "bvh/gpu/batch/batches.h"

#include "bvh/gpu/batch/job.h"

#include <algorithm>
#include <iterator>

// The PTX of kernels.cu (SUNSTONE_BATCH_PTX, a file of the build).
asm(".pushsection .rodata\n"
    "sunstone_batch_ptx:\n"
    ".incbin \"" SUNSTONE_BATCH_PTX "\"\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" __attribute__((visibility("hidden"))) const char sunstone_batch_ptx[];

namespace sunstone::bvh::gpu {
namespace {

// The first eight: any + 2 * masked + 4 * instances.
constexpr const char* kNames[] = {"batch_closest",
                                  "batch_any",
                                  "batch_closest_masked",
                                  "batch_any_masked",
                                  "batch_closest_instances",
                                  "batch_any_instances",
                                  "batch_closest_instances_masked",
                                  "batch_any_instances_masked",
                                  "batch_bits",
                                  "batch_masks"};
constexpr uint32_t kBits = 8, kMasks = 9;
constexpr uint32_t kThreads = 128;
constexpr uint64_t kCounterBytes = 256;

std::vector<device::cuda::KernelSource> sources() {
    std::vector<device::cuda::KernelSource> all;
    for (const char* name : kNames)
        all.push_back({name, name, [name] {
                           static const device::cuda::KernelTexts texts(sunstone_batch_ptx);
                           return texts.moduleOf(name);
                       }});
    return all;
}

} // namespace

Batches::Batches(const device::cuda::Driver& driver, device::cuda::MachineCodeSource* code)
    : driver_(driver), kernels_(driver, code, sources()) {
    CUdevice device = 0;
    int count = 1;
    device::cuda::check(driver_, driver_.ctxGetDevice(&device), "cuCtxGetDevice");
    device::cuda::check(
        driver_,
        driver_.deviceGetAttribute(&count, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT, device),
        "cuDeviceGetAttribute");
    multiprocessors_ = uint32_t(std::max(count, 1));
}

uint64_t Batches::scratchBytes(const RayBatch& batch) {
    return kCounterBytes +
           (batch.hitFormat == HitFormat::kBit ? std::min(batch.count, kLaunchRays) : 0);
}

void Batches::launch(uint32_t kernel, CUstream stream, uint64_t blocks, void** arguments) const {
    device::cuda::check(driver_,
                        driver_.launchKernel(kernels_.function(kernel), unsigned(blocks), 1, 1,
                                             kThreads, 1, 1, 0, stream, arguments, nullptr),
                        "cuLaunchKernel");
}

void Batches::trace(CUstream stream, const RayBatch& batch, bool any, bool instances,
                    CUdeviceptr scratch) const {
    const uint32_t kernel = (any ? 1u : 0u) + (batch.masks ? 2u : 0u) + (instances ? 4u : 0u);
    BatchJob job{};
    job.batch = batch;
    job.counter = scratch;
    job.found = scratch + kCounterBytes;
    job.aligned = rayBytes(batch.rayFormat) == 32 && batch.rays % 16 == 0;
    job.wantedLanes = 20;
    for (uint64_t first = 0; first < batch.count; first += kLaunchRays) {
        job.batch.count = std::min(kLaunchRays, batch.count - first);
        job.batch.rays = batch.rays + first * rayBytes(batch.rayFormat);
        const bool bits = batch.hitFormat == HitFormat::kBit;
        const uint64_t place = batch.firstBit + first;
        job.batch.hits = batch.hits + (bits ? place / 8 : first * hitBytes(batch.hitFormat));
        job.batch.firstBit = bits ? uint32_t(place % 8) : 0;
        void* arguments[] = {&job};
        device::cuda::check(driver_, driver_.memsetD32Async(job.counter, 0, 1, stream),
                            "cuMemsetD32Async");
        constexpr uint64_t kBlocksPerMultiprocessor = 16;
        launch(kernel, stream,
               std::min<uint64_t>((job.batch.count + kThreads - 1) / kThreads,
                                  kBlocksPerMultiprocessor * multiprocessors_),
               arguments);
        if (bits)
            launch(kBits, stream,
                   ((job.batch.firstBit + job.batch.count + 7) / 8 + kThreads - 1) / kThreads,
                   arguments);
    }
}

void Batches::copyMasks(CUstream stream, CUdeviceptr indices, CUdeviceptr masks,
                        uint64_t count) const {
    void* arguments[] = {&indices, &masks, &count};
    if (count)
        launch(kMasks, stream, (count + kThreads - 1) / kThreads, arguments);
}

} // namespace sunstone::bvh::gpu
