// SPDX-License-Identifier: Apache-2.0
// Launches the batch kernels (kernels.cu) in the context that is current at construction. The same
// context must be current in all calls. Thread-safe.
#pragma once

#include "bvh/batch/ray_batch.h"
#include "device/cuda/kernel_set.h"

#include <vector>

namespace sunstone::bvh::gpu {

class Batches {
public:
    // `code`: source of machine code; null: the driver compiles.
    explicit Batches(const device::cuda::Driver& driver,
                     device::cuda::MachineCodeSource* code = nullptr);

    // Bytes of scratch memory that a batch takes.
    static uint64_t scratchBytes(const RayBatch& batch);

    // Queues the batch. Its scratch memory must live until it ends.
    void trace(CUstream stream, const RayBatch& batch, bool any, bool instances,
               CUdeviceptr scratch) const;

    // Queues the copy of the fourth words of indices.
    void copyMasks(CUstream stream, CUdeviceptr indices, CUdeviceptr masks, uint64_t count) const;

    // Compiles and loads all kernels.
    void prepareAll() const { kernels_.prepareAll(); }

private:
    void launch(uint32_t kernel, CUstream stream, uint64_t blocks, void** arguments) const;

    const device::cuda::Driver& driver_;
    mutable device::cuda::KernelSet kernels_;
    uint32_t multiprocessors_ = 1;
};

} // namespace sunstone::bvh::gpu
