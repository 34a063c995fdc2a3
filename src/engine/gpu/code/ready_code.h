// SPDX-License-Identifier: Apache-2.0
// Code of a pipeline from a kernel that was compiled before and the pipeline's programs, which are
// compiled now (compiler::GpuPart). It takes a fraction of the time of the whole pipeline. Its
// frames take up to twice as long: programs are called functions, and the kernel serves more kinds
// of primitives than the pipeline has (docs/notes/compile-time.md has figures). Launches use it
// until the whole pipeline is compiled (code_queue.h).
#pragma once

#include "compiler/gpu/pipeline.h"
#include "device/cuda/driver.h"

#include <optional>
#include <string>
#include <vector>

namespace sunstone::engine {

// All kernels, for an archive (kernel_images.h).
std::vector<compiler::GpuPipelineRequest> readyKernels(const compiler::GpuTarget& target);
// The kernel's name in the archive.
std::string readyKernelId(const compiler::GpuPipelineRequest& kernel);
// Registers of a thread.
unsigned readyKernelRegisters(const compiler::GpuPipelineRequest& kernel);

// The kernel that serves the pipeline of this request. Empty for pipelines that must compile as a
// whole: those with debug or stack overflow exceptions, with visit programs, or with many programs.
std::optional<compiler::GpuPipelineRequest>
readyKernelFor(const compiler::GpuPipelineRequest& request);
// Its code for the driver's linker: from the archive, from the process, or from the disk cache
// `store`, which may be null. If there is none, the code is empty, or compiled now where
// SUNSTONE_GPU_CODE is "ready".
std::string readyKernelCode(const compiler::GpuPipelineRequest& kernel,
                            compiler::ObjectStore* store);
// Compiles the kernel, once in a process.
std::string compileReadyKernel(const compiler::GpuPipelineRequest& kernel,
                               compiler::ObjectStore* store);

// The pipeline's code, linked with that of its kernel. Empty if its programs must compile together
// with the kernel.
std::optional<compiler::GpuCode> readyCodeOf(const compiler::GpuPipelineRequest& request,
                                             const compiler::GpuPipelineRequest& kernel,
                                             const std::string& kernelCode, CUcontext context);

} // namespace sunstone::engine
