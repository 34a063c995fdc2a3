// SPDX-License-Identifier: Apache-2.0
// The back end for CUDA GPUs. A pipeline is one module of machine code (gpu/code/code.h); a launch
// is one kernel with a block of device memory (devlib/gpu/launch_block.h), copied in stream order.
#pragma once

#include "bvh/gpu/build/builder.h"
#include "denoise/gpu/gpu_denoiser.h"
#include "device/cuda/gpu_device.h"
#include "engine/backend.h"
#include "engine/gpu/code/code.h"
#include "engine/gpu/code/kernel_code.h"
#include "engine/gpu/lane_memory.h"
#include "engine/gpu/launch_slots.h"
#include "engine/gpu/shared_memory.h"
#include "engine/gpu/structures.h"

#include <map>
#include <mutex>
#include <string>

namespace sunstone::engine {

struct PipelineLimits;

class GpuBackend final : public Backend {
public:
    explicit GpuBackend(CUcontext context);
    ~GpuBackend() override;
    device::Device& device() override { return device_; }
    bool sharesMemory() const override { return false; }
    void* allocateShared(size_t bytes) override { return shared_.allocate(bytes); }
    void freeShared(void* memory) noexcept override { shared_.free(memory); }
    void copy(void* to, const void* from, size_t bytes) override;
    uint64_t addTexture(std::unique_ptr<texture::Texture> texture) override;
    void removeTexture(uint64_t handle) noexcept override;
    bool copiesImages() const override { return true; }

    // Makes or finds machine code of all kernels of the library, keeps it in the cache and loads
    // it.
    void prepareKernels();
    // Compiles the kernels of ready_code.h for which there is no code.
    void prepareReadyKernels(compiler::ObjectStore* store);

    void useCache(std::shared_ptr<CompileCache> cache) override {
        kernelCode_.useCache(std::move(cache));
    }
    bool accepts(const ptx::Module& module) override;
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

    void noteTransform(uint64_t handle) override { noteGpuHandle(handle); }

    void buildMicromapArray(const ContextPtr& context, MicromapArrayBuild request) override;
    bvh::RelocationInfo micromapRelocationInfo(const ContextPtr& context,
                                               const void* array) override;
    void relocateMicromapArray(const ContextPtr& context, void* stream,
                               const bvh::RelocationInfo& info, void* array) override;

private:
    void tellOfBuilds(const Context& context);
    void requireStructure(uint64_t handle, const char* parameter);
    bvh::BlockHeader headerOf(uint64_t handle, CUstream stream, const char* parameter);
    bool takes(const std::string& ptx);
    unsigned newestPtx();
    compiler::GpuTarget target();
    static GpuPipelineCode& codeOf(const Pipeline& pipeline);
    struct CodePlan;
    static unsigned depthOfGraphs(const PipelineLimits& limits, const GpuGraphs& there);
    std::shared_ptr<GpuCodeObject> makeCode(const CodePlan& plan, GpuCodeKind kind,
                                            const GpuLaterCode* later);
    std::shared_ptr<const GpuLaterCode> prepareNarrow(const CodePlan& plan, GpuCodeKind kind,
                                                      bool compiles);
    void obtainLaneMemory(GpuCodeObject& object, const compiler::GpuCode& code);
    compiler::GpuCode compileWhole(const compiler::GpuPipelineRequest& request);
    void addMachineCodeOfWhole(compiler::GpuCode& code,
                               const compiler::GpuPipelineRequest& request);
    bool addMachineCode(compiler::GpuCode& code, const compiler::GpuPipelineRequest& request);
    // Queues the compilation; before it, in the same job, `sooner` runs unless it is empty.
    std::shared_ptr<const GpuLaterCode> compileLater(const compiler::GpuPipelineRequest& request,
                                                     compiler::ObjectStore* store, bool isNarrow,
                                                     std::function<void()> sooner = {});
    void compileInto(GpuLaterCode& later, const compiler::GpuPipelineRequest& request,
                     compiler::ObjectStore* store, bool isNarrow);
    void makeReadyKernelLater(const compiler::GpuPipelineRequest& request,
                              compiler::ObjectStore* store);
    LoadedGpuCodes::Entry loadMachineCode(compiler::GpuCode code);
    // Gets the ready code; returns what runs before the compilation of the whole pipeline, or an
    // empty function.
    using BeforeWhole = std::function<std::function<void()>(const compiler::GpuCode&)>;
    LoadedGpuCodes::Entry obtainReadyCode(const compiler::GpuPipelineRequest& request,
                                          compiler::ObjectStore* store,
                                          const BeforeWhole& beforeWhole);
    void makeRoom(GpuCodeObject& code, const CodePlan& plan, const compiler::GpuStack& stack);
    void setStackUse(GpuCodeObject& code);
    LoadedGpuCodes::Entry obtainCode(const compiler::GpuPipelineRequest& request,
                                     compiler::ObjectStore* store, const BeforeWhole& beforeWhole);
    const bvh::gpu::Builder& builder();    // made at the first request
    denoise::gpu::GpuDenoiser& denoiser(); // likewise
    void tellOfRefusals(const Context& context);
    void throwRefusal(const Context& context, CUstream stream);

    device::cuda::GpuDevice device_;
    GpuKernelCode kernelCode_;
    std::once_flag builderMade_;
    std::unique_ptr<bvh::gpu::Builder> builder_;
    std::once_flag denoiserMade_;
    std::unique_ptr<denoise::gpu::GpuDenoiser> denoiser_;
    std::mutex refusalMutex_;
    std::map<CUstream, std::string> refusals_; // the first of each stream, until its next call
    LoadedGpuCodes loaded_;
    std::once_flag ptxAsked_;
    unsigned newestPtx_ = 0; // GpuTarget::ptxVersion
    std::unique_ptr<GpuKnownHandles> known_ = std::make_unique<GpuKnownHandles>();
    GpuLaneMemory laneMemory_;
    GpuLaunchSlots slots_;
    GpuSharedMemory shared_;
    std::mutex textureMutex_;
    std::map<uint64_t, CUmipmappedArray> textures_; // of addTexture()
};

} // namespace sunstone::engine
