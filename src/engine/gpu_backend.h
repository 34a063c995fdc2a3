// SPDX-License-Identifier: Apache-2.0
// CUDA GPUs behind backend.h. A pipeline is one module of machine code, made by the driver from
// PTX; a launch is one kernel with a block of device memory for what it needs
// (devlib/gpu/launch_block.h), copied in stream order.
#pragma once

#include "bvh/gpu/builder.h"
#include "denoise/gpu/gpu_denoiser.h"
#include "compiler/gpu_pipeline.h"
#include "device/cuda/gpu_device.h"
#include "engine/backend.h"
#include "engine/gpu_launch_slots.h"

#include <atomic>
#include <map>
#include <mutex>
#include <string>

namespace sunstone::engine {

// A loaded module; unloaded with the object, when nothing runs it any more.
class GpuCodeObject final : public DeviceCode {
public:
    // Loads the machine code, or the text where there is none, or none that the driver takes. Throws
    // kLinkError with what the driver has to say if it refuses the text. `log`: what its compiler
    // tells of functions, or empty.
    GpuCodeObject(CUcontext context, const compiler::GpuCode& code, unsigned maxRegisters,
                  std::string& log);
    ~GpuCodeObject() override;
    CUfunction kernel = nullptr;
    uint32_t firstGroup = 0; // what the code counts group numbers from
    // Bytes of stack that the programs take for traces of full depth and callables two deep, beside
    // what a launch index may use of what there is, with stack overflow exceptions.
    size_t neededStack = 0;
    size_t reservedStack = 0; // of it, for functions that do not check
    std::atomic<size_t> stackBytes = 0;

private:
    void compileText(const std::string& ptx, unsigned maxRegisters, std::string& log);

    CUcontext context_;
    CUmodule module_ = nullptr;
};

class GpuBackend final : public Backend {
public:
    explicit GpuBackend(CUcontext context);
    ~GpuBackend() override;
    device::Device& device() override { return device_; }
    bool sharesMemory() const override { return false; }

    void compile(Pipeline& pipeline, const PipelineParts& parts) override;
    void setStackSizes(const Context& context, Pipeline& pipeline) override;
    void launch(const ContextPtr& context, const LaunchRequest& request) override;
    void flush(const Context& context) override;
    void prepareDenoiser(int guidePlanes) override;
    void setupDenoiser(const ContextPtr& context, const DenoiserSetup& setup) override;
    void denoise(const ContextPtr& context, DenoiseRequest request) override;
    void imageStatistics(const ContextPtr& context, const StatisticsRequest& request) override;
    bvh::MemoryUsage accelMemory(const bvh::BuildInputs& inputs,
                                 const bvh::BuildOptions& options) override;
    uint64_t buildAccel(const ContextPtr& context, AccelBuild request) override;
    uint64_t compactAccel(const ContextPtr& context, void* stream, uint64_t handle,
                          void* destination, size_t destinationSize) override;
    bvh::RelocationInfo relocationInfo(const ContextPtr& context, uint64_t handle) override;
    uint64_t relocateAccel(const ContextPtr& context, void* stream, const bvh::RelocationInfo& info,
                           void* block, const uint64_t* children, size_t count,
                           std::vector<const void*> arrays) override;

    void buildMicromapArray(const ContextPtr& context, MicromapArrayBuild request) override;
    bvh::RelocationInfo micromapRelocationInfo(const ContextPtr& context,
                                               const void* array) override;
    void relocateMicromapArray(const ContextPtr& context, void* stream,
                               const bvh::RelocationInfo& info, void* array) override;

private:
    void tellOfBuilds(const Context& context);
    bvh::BlockHeader headerOf(uint64_t handle, CUstream stream, const char* parameter);
    void setStackUse(GpuCodeObject& code);
    const bvh::gpu::Builder& builder();    // made when first asked for, as its kernels are
    denoise::gpu::GpuDenoiser& denoiser(); // likewise
    void tellOfRefusals(const Context& context);
    void throwRefusal(const Context& context, CUstream stream);

    device::cuda::GpuDevice device_;
    std::once_flag builderMade_;
    std::unique_ptr<bvh::gpu::Builder> builder_;
    std::once_flag denoiserMade_;
    std::unique_ptr<denoise::gpu::GpuDenoiser> denoiser_;
    std::mutex refusalMutex_;
    std::map<CUstream, std::string> refusals_; // the first of each stream, until its next call
    GpuLaunchSlots slots_;
};

} // namespace sunstone::engine
