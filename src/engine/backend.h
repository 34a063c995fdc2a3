// SPDX-License-Identifier: Apache-2.0
// The interface between the engine and the back ends that run device code: the CPU
// (cpu/backend.cpp) or a CUDA GPU (gpu/backend.cpp). The free functions of pipeline.h, launch.h and
// accel.h do the checks and preparation that both share, then call the back end. Descriptions are
// in the engine's terms and already checked by the shell; they name device memory.
#pragma once

#include "bvh/build/build.h"
#include "bvh/relocate.h"
#include "compiler/compiler.h"
#include "device/device.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace sunstone::texture {
struct Texture;
}

namespace sunstone::engine {

class CompileCache;
struct AccelBuild;
struct Context;
struct DenoiseRequest;
struct DenoiserSetup;
struct LaunchRequest;
struct MicromapArrayBuild;
struct Pipeline;
struct ProgramGroup;
struct StatisticsRequest;

using ContextPtr = std::shared_ptr<Context>;

// The parts of a pipeline: its programs without duplicates, and the indices of each group's
// programs.
struct PipelineParts {
    static constexpr size_t kNone = ~size_t(0);
    using Indices = std::array<size_t, devlib::kRoleCount>; // by devlib::Role
    const std::vector<std::shared_ptr<ProgramGroup>>& groups;
    std::vector<Indices> indices; // of groups
    compiler::PipelineRequest request;
    compiler::ObjectStore* cache; // may be null
};

// Code of a pipeline, opaque to all but its back end.
class DeviceCode {
public:
    virtual ~DeviceCode() = default;
};

class Backend {
public:
    virtual ~Backend() = default;
    virtual device::Device& device() = 0;
    // Whether the host may read and write device memory.
    virtual bool sharesMemory() const = 0;
    // Memory of the library that programs read and write, and the host while no program runs.
    // Aligned to 128 bytes, zeroed. Throws kOutOfMemory.
    virtual void* allocateShared(size_t bytes) = 0;
    virtual void freeShared(void* memory) noexcept = 0;
    // Copies between memory of programs or of the library, and that of the host.
    virtual void copy(void* to, const void* from, size_t bytes) = 0;
    // Creates a texture for programs from images that the host can read; returns its handle, never
    // 0. Where copiesImages() is true, later changes of the images need a new texture.
    virtual uint64_t addTexture(std::unique_ptr<texture::Texture> texture) = 0;
    virtual void removeTexture(uint64_t handle) noexcept = 0;
    virtual bool copiesImages() const = 0;

    // Sets the cache of code that belongs to no pipeline; precedes all other calls.
    virtual void useCache(std::shared_ptr<CompileCache>) {}

    // Whether the device's compiler accepts this module, with the version and target of a pipeline
    // that contains it.
    virtual bool accepts(const ptx::Module&) { return false; }
    // Compiles the programs; stores the data for launches in the pipeline.
    virtual void compile(Pipeline& pipeline, const PipelineParts& parts) = 0;
    // Called after the pipeline's limits have changed.
    virtual void setStackSizes(const Context&, Pipeline&) {}
    virtual void launch(const ContextPtr& context, const LaunchRequest& request) = 0;
    // Logs the pending reports of launches and builds that have ended.
    virtual void flush(const Context&) {}

    // Denoising; see denoiser.h.
    // Prepares frames with that many planes of guides, so that queueing does not wait.
    virtual void prepareDenoiser(int guidePlanes) = 0;
    virtual void setupDenoiser(const ContextPtr& context, const DenoiserSetup& setup) = 0;
    virtual void denoise(const ContextPtr& context, DenoiseRequest request) = 0;
    virtual void imageStatistics(const ContextPtr& context, const StatisticsRequest& request) = 0;

    virtual bvh::MemoryUsage accelMemory(const bvh::BuildInputs& inputs,
                                         const bvh::BuildOptions& options) = 0;
    virtual uint64_t buildAccel(const ContextPtr& context, AccelBuild request) = 0;
    virtual uint64_t compactAccel(const ContextPtr& context, void* stream, uint64_t handle,
                                  void* destination, size_t destinationSize) = 0;
    virtual bvh::RelocationInfo relocationInfo(const ContextPtr& context, uint64_t handle) = 0;
    virtual uint64_t relocateAccel(const ContextPtr& context, void* stream,
                                   const bvh::RelocationInfo& info, void* block,
                                   const uint64_t* children, size_t count,
                                   std::vector<const void*> arrays) = 0;

    // Registers the handle of a transform in the caller's memory.
    virtual void noteTransform(uint64_t) {}

    virtual void buildMicromapArray(const ContextPtr& context, MicromapArrayBuild request) = 0;
    virtual bvh::RelocationInfo micromapRelocationInfo(const ContextPtr& context,
                                                       const void* array) = 0;
    virtual void relocateMicromapArray(const ContextPtr& context, void* stream,
                                       const bvh::RelocationInfo& info, void* array) = 0;
};

std::shared_ptr<Backend> cpuBackend();

// For the GPU of this CUcontext. Throws kNotSupported for devices that are too old, kCudaError
// where the driver has no such context.
std::shared_ptr<Backend> createGpuBackend(void* cudaContext);

// Throws kNotSupported unless the device's memory is the host's; `what` names the feature for the
// message.
void requireSharedMemory(const Context& context, const char* what);

} // namespace sunstone::engine
