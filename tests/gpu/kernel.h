// SPDX-License-Identifier: Apache-2.0
// For tests of GPU pipelines: a pipeline's kernel on the CPU device, which runs PTX too, and
// records.
#pragma once

#include "bvh/gpu/testing/device.h"
#include "devlib/gpu/launch_block.h"
#include "engine/gpu/code/ready_code.h"
#include "gpu/pipelines.h"

#include <gtest/gtest.h>

#include <cstring>

namespace sunstone::gpu_tests {

using bvh::gpu::testing::Buffer;
using bvh::gpu::testing::Device;

constexpr uint32_t kFirstGroup = 5; // number of a pipeline's group 1 in its context

struct alignas(16) Record {
    devlib::SbtHeader header{};
    uint32_t data[4] = {};
};

inline Record recordOf(uint32_t group, devlib::GroupKind kind) {
    Record record;
    record.header.magic = devlib::kSbtMagic;
    record.header.group = group;
    record.header.kind = kind;
    return record;
}

// A pipeline's kernel, loaded into the CPU device.
class Kernel {
public:
    explicit Kernel(const std::string& module, const Options& options = {}) {
        const compiler::GpuCode code =
            options.ready ? linkReadyCode(module, options) : compileCode(module, options);
        const std::string& image = options.ready ? code.machineCode : code.ptx;
        feedback = code.feedback;
        EXPECT_EQ(driver().moduleLoadDataEx(&module_, image.c_str(), 0, nullptr, nullptr),
                  CUDA_SUCCESS);
        EXPECT_EQ(driver().moduleGetFunction(&function_, module_, compiler::kGpuKernel),
                  CUDA_SUCCESS);
    }
    ~Kernel() { driver().moduleUnload(module_); }
    Kernel(const Kernel&) = delete;

    std::string feedback;
    uint32_t patience = devlib::kShortPatience;
    uint32_t maxTraceDepth = 1;
    unsigned blockThreads = devlib::kGpuBlockThreads; // others only if warps take launch indices

    // Launches with this block. The caller sets the fields that depend on the test.
    devlib::LaunchReport launch(const devlib::LaunchBlock& prepared, uint32_t width,
                                uint32_t height = 1, uint32_t depth = 1) const {
        Buffer memory(sizeof(prepared));
        std::memcpy(memory.data(), &prepared, sizeof(prepared));
        auto& block = *static_cast<devlib::LaunchBlock*>(memory.data());
        block.launch.dimensions[0] = width;
        block.launch.dimensions[1] = height;
        block.launch.dimensions[2] = depth;
        block.launch.maxTraceDepth = maxTraceDepth;
        block.constants = {0, 0, devlib::kMaxGraphDepth}; // handles are accepted unchecked
        block.report = devlib::emptyReport();
        block.launch.firstGroup = kFirstGroup - 1;
        block.launch.entryKind = devlib::kGroupRaygen;
        block.launch.hasAnyHit = true;
        const uint64_t tiles = devlib::gpuTiles(block.launch.dimensions);
        block.work = {0, tiles * devlib::kGpuTile, {}, 0, 0};
        std::fill(std::begin(block.work.patience), std::end(block.work.patience), patience);
        const unsigned tilesOfBlock = blockThreads / devlib::kGpuTile;
        const auto blocks = unsigned((tiles + tilesOfBlock - 1) / tilesOfBlock);
        CUdeviceptr address = memory.address();
        void* arguments[] = {&address, &block.constants.usual, &block.constants.known,
                             &block.constants.maxGraphDepth};
        EXPECT_EQ(driver().launchKernel(function_, blocks, 1, 1, blockThreads, 1, 1, 0, nullptr,
                                        arguments, nullptr),
                  CUDA_SUCCESS);
        EXPECT_EQ(driver().ctxSynchronize(), CUDA_SUCCESS);
        return block.report;
    }

private:
    static compiler::GpuCode linkReadyCode(const std::string& module, const Options& options) {
        const compiler::GpuPipelineRequest request = requestOf(module, options);
        const auto kernel = engine::readyKernelFor(request);
        CUcontext context = nullptr;
        EXPECT_EQ(driver().ctxGetCurrent(&context), CUDA_SUCCESS);
        const auto code =
            kernel ? engine::readyCodeOf(request, *kernel,
                                         engine::compileReadyKernel(*kernel, nullptr), context)
                   : std::nullopt;
        EXPECT_TRUE(code);
        return code.value_or(compiler::GpuCode());
    }

    static const device::cuda::Driver& driver() { return Device::get().driver(); }
    CUmodule module_ = nullptr;
    CUfunction function_ = nullptr;
};

} // namespace sunstone::gpu_tests
