// SPDX-License-Identifier: Apache-2.0
// State shared by all GPU back ends of a process: a process has one driver, and structures and
// limits belong to CUDA contexts, which several device contexts may use.
#pragma once

#include "engine/gpu/code/code_queue.h"
#include "engine/gpu/code/kernel_code.h"
#include "engine/gpu/handle_table.h"
#include "engine/gpu/structures.h"

#include <mutex>

namespace sunstone::engine {

struct GpuProcess {
    GpuHandleTable handles;
    GpuTableFollowers followers;
    KnownKernelCode kernels;
    GpuCodeQueue codeQueue;
    // Held from the query of a CUDA context's stack limit to its change.
    std::mutex stackLimit;
};

GpuProcess& gpuProcess();

} // namespace sunstone::engine
