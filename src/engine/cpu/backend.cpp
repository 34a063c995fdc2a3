// SPDX-License-Identifier: Apache-2.0
#include "engine/cpu/backend.h"

#include "base/error.h"
#include "texture/texture.h"

#include <cstring>

namespace sunstone::engine {
namespace {

class CpuBackend final : public Backend {
public:
    device::Device& device() override { return device::cpuDevice(); }
    bool sharesMemory() const override { return true; }
    void* allocateShared(size_t bytes) override { return device::allocateCpuShared(bytes); }
    void freeShared(void* memory) noexcept override { device::freeCpuShared(memory); }
    void copy(void* to, const void* from, size_t bytes) override { std::memcpy(to, from, bytes); }
    uint64_t addTexture(std::unique_ptr<texture::Texture> texture) override {
        return texture::add(std::move(texture));
    }
    void removeTexture(uint64_t handle) noexcept override { texture::removeTexture(handle); }
    bool copiesImages() const override { return false; }

    void compile(Pipeline& pipeline, const PipelineParts& parts) override {
        cpu::compile(pipeline, parts);
    }
    void launch(const ContextPtr& context, const LaunchRequest& request) override {
        cpu::launch(context, request);
    }
    void prepareDenoiser(int) override {}
    void setupDenoiser(const ContextPtr& context, const DenoiserSetup& setup) override {
        cpu::setupDenoiser(context, setup);
    }
    void denoise(const ContextPtr& context, DenoiseRequest request) override {
        cpu::denoise(context, std::move(request));
    }
    void imageStatistics(const ContextPtr& context, const StatisticsRequest& request) override {
        cpu::imageStatistics(context, request);
    }
    bvh::MemoryUsage accelMemory(const bvh::BuildInputs& inputs,
                                 const bvh::BuildOptions& options) override {
        return bvh::computeMemoryUsage(inputs, options);
    }
    uint64_t buildAccel(const ContextPtr& context, AccelBuild request) override {
        return cpu::buildAccel(context, std::move(request));
    }
    uint64_t compactAccel(const ContextPtr& context, void* stream, uint64_t handle,
                          void* destination, size_t destinationSize) override {
        return cpu::compactAccel(context, stream, handle, destination, destinationSize);
    }
    bvh::RelocationInfo relocationInfo(const ContextPtr& context, uint64_t handle) override {
        return cpu::relocationInfo(context, handle);
    }
    uint64_t relocateAccel(const ContextPtr& context, void* stream, const bvh::RelocationInfo& info,
                           void* block, const uint64_t* children, size_t count,
                           std::vector<const void*> arrays) override {
        return cpu::relocateAccel(context, stream, info, block, children, count, std::move(arrays));
    }
    void buildMicromapArray(const ContextPtr& context, MicromapArrayBuild request) override {
        cpu::buildMicromapArray(context, std::move(request));
    }
    bvh::RelocationInfo micromapRelocationInfo(const ContextPtr& context,
                                               const void* array) override {
        return cpu::micromapRelocationInfo(context, array);
    }
    void relocateMicromapArray(const ContextPtr& context, void* stream,
                               const bvh::RelocationInfo& info, void* array) override {
        cpu::relocateMicromapArray(context, stream, info, array);
    }
};

} // namespace

std::shared_ptr<Backend> cpuBackend() {
    return std::make_shared<CpuBackend>();
}

void requireSharedMemory(const Context& context, const char* what) {
    if (!context.backend->sharesMemory())
        fail(Code::kNotSupported, what, " is not available on GPUs yet");
}

} // namespace sunstone::engine
