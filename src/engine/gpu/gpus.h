// SPDX-License-Identifier: Apache-2.0
// The CUDA GPUs of the machine, for APIs whose applications choose no CUDA context.
#pragma once

#include "engine/backend.h"
#include "engine/compile_cache.h"

#include <cstddef>
#include <string>
#include <vector>

namespace sunstone::engine {

struct Gpu {
    int ordinal = 0; // the driver's
    std::string name, pciBusId;
    int capability[2] = {0, 0};
    size_t memoryBytes = 0;
    int multiprocessors = 0, threadsPerBlock = 0, clockKhz = 0;
    bool hasTimeout = false, isTcc = false;
};

// GPUs that the library supports, in the driver's order; none if the process has no CUDA driver, or
// that of the CPU device. The first call queries the driver.
const std::vector<Gpu>& gpus();

// Fills the default disk cache with machine code, for this GPU, of the library's kernels that have
// no code in the library itself. Lines of the cache go to `log`. Throws Error.
void warm(const Gpu& gpu, const CompileCache::Log& log);

// The back end of the GPU's primary context, which the driver's run-time API shares. The context
// is retained for the life of the process, as the run-time API does.
std::shared_ptr<Backend> createPrimaryBackend(const Gpu& gpu);
// The CUDA ordinal of the CPU: 0 if the process has the CPU device's driver, else -1.
int cudaOrdinalOfCpu();
// Bytes of memory that are free on the GPU.
size_t freeMemory(const Gpu& gpu);

} // namespace sunstone::engine
