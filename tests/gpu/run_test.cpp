// SPDX-License-Identifier: Apache-2.0
// The kernel of a GPU pipeline on the CPU device, which runs PTX too: launch indices, records and
// what the launch reports. So the code for GPUs is tested where there is none.
#include "bvh/gpu/test_device.h"
#include "devlib/gpu/launch_block.h"
#include "gpu/pipelines.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace sunstone {
namespace {

using namespace gpu_tests;
using bvh::gpu::testing::Buffer;
using bvh::gpu::testing::Device;

constexpr uint32_t kFirstGroup = 5; // what group 1 of a pipeline of these tests is in its context

struct alignas(16) Record {
    devlib::SbtHeader header{};
    uint32_t data[4] = {};
};

Record recordOf(uint32_t group, devlib::GroupKind kind) {
    Record record;
    record.header.magic = devlib::kSbtMagic;
    record.header.group = group;
    record.header.kind = kind;
    return record;
}

// Launches the pipeline of a module; params is one address.
devlib::LaunchReport launch(const std::string& module, const Record& raygenRecord, void* output,
                            uint32_t width, uint32_t height, uint32_t depth) {
    const auto& driver = Device::get().driver();
    const std::string ptx = compile(module);
    CUmodule loaded = nullptr;
    CUfunction kernel = nullptr;
    EXPECT_EQ(driver.moduleLoadDataEx(&loaded, ptx.c_str(), 0, nullptr, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(driver.moduleGetFunction(&kernel, loaded, compiler::kGpuKernel), CUDA_SUCCESS);
    Buffer record(sizeof(Record)), memory(sizeof(devlib::LaunchBlock), 0), params(16, 0);
    std::memcpy(record.data(), &raygenRecord, sizeof(Record));
    std::memcpy(params.data(), &output, sizeof(output));
    auto& block = *static_cast<devlib::LaunchBlock*>(memory.data());
    block.launch.params = params.data();
    block.launch.dimensions[0] = width;
    block.launch.dimensions[1] = height;
    block.launch.dimensions[2] = depth;
    block.launch.sbt.raygenRecord = record.address();
    block.report = {devlib::kNoReport, devlib::kNoReport, devlib::kNoReport};
    block.firstGroup = kFirstGroup - 1;
    const uint32_t tiles = (width + 7) / 8 * ((height + 3) / 4) * depth;
    const uint32_t threads = height == 1 ? width * depth : tiles * 32;
    CUdeviceptr address = memory.address();
    void* arguments[] = {&address};
    EXPECT_EQ(driver.launchKernel(
                  kernel, (threads + devlib::kGpuBlockThreads - 1) / devlib::kGpuBlockThreads, 1, 1,
                  devlib::kGpuBlockThreads, 1, 1, 0, nullptr, arguments, nullptr),
              CUDA_SUCCESS);
    EXPECT_EQ(driver.ctxSynchronize(), CUDA_SUCCESS);
    driver.moduleUnload(loaded);
    return block.report;
}

// Adds 1 to the word of each launch index, and the record's first word times 16.
const char* const kCount = R"(
    call (%r1), _optix_get_launch_index_x, ();
    call (%r2), _optix_get_launch_index_y, ();
    call (%r3), _optix_get_launch_index_z, ();
    call (%r4), _optix_get_launch_dimension_x, ();
    call (%r5), _optix_get_launch_dimension_y, ();
    mad.lo.u32 %r6, %r3, %r5, %r2;
    mad.lo.u32 %r6, %r6, %r4, %r1;
    mul.wide.u32 %rd2, %r6, 4;
    add.s64 %rd3, %rd1, %rd2;
    call (%rd4), _optix_get_sbt_data_ptr_64, ();
    ld.u32 %r7, [%rd4];
    shl.b32 %r7, %r7, 4;
    add.u32 %r7, %r7, 1;
    atom.global.add.u32 %r1, [%rd3], %r7;
)";

TEST(GpuRun, EveryLaunchIndexRunsOnce) {
    Record record = recordOf(kFirstGroup, devlib::kGroupRaygen);
    record.data[0] = 3;
    const uint32_t sizes[][3] = {{1, 1, 1}, {100, 1, 1}, {13, 7, 1}, {64, 4, 3}, {5, 1, 9}};
    for (const auto& size : sizes) {
        const uint32_t count = size[0] * size[1] * size[2];
        Buffer output(count * 4 + 64, 0);
        const devlib::LaunchReport report =
            launch(raygen(kCount), record, output.data(), size[0], size[1], size[2]);
        EXPECT_EQ(report.fatal, devlib::kNoReport);
        EXPECT_EQ(report.unseen, devlib::kNoReport);
        const auto* words = static_cast<const uint32_t*>(output.data());
        for (uint32_t i = 0; i < count; ++i)
            ASSERT_EQ(words[i], 49u)
                << i << " of " << size[0] << " x " << size[1] << " x " << size[2];
        EXPECT_EQ(words[count], 0u);
    }
}

TEST(GpuRun, RecordsOfOtherGroupsAreReported) {
    Buffer output(256, 0);
    const auto failureOf = [&](const Record& record) {
        return launch(raygen(kCount), record, output.data(), 4, 4, 1).fatal;
    };
    const uint64_t wanted = uint32_t(devlib::kFatalRaygenRecord); // at index 0
    EXPECT_EQ(failureOf(recordOf(kFirstGroup - 1, devlib::kGroupRaygen)), wanted);
    EXPECT_EQ(failureOf(recordOf(kFirstGroup + 1, devlib::kGroupRaygen)), wanted);
    EXPECT_EQ(failureOf(recordOf(kFirstGroup, devlib::kGroupMiss)), wanted);
    EXPECT_EQ(failureOf(Record()), wanted);
    EXPECT_EQ(*static_cast<const uint32_t*>(output.data()), 0u);
}

TEST(GpuRun, ExceptionsNobodySeesAreReported) {
    Buffer output(256, 0);
    const std::string throws = raygen(R"(
    mov.u32 %r2, 77;
    call _optix_throw_exception_0, (%r2);
)");
    const Record record = recordOf(kFirstGroup, devlib::kGroupRaygen);
    const devlib::LaunchReport report = launch(throws, record, output.data(), 9, 2, 1);
    EXPECT_EQ(report.unseen, 77u); // of launch index 0
    EXPECT_EQ(report.fatal, devlib::kNoReport);
    const devlib::LaunchReport trapped =
        launch(raygen("    trap;\n"), record, output.data(), 2, 1, 1);
    EXPECT_EQ(trapped.fatal, uint64_t(uint32_t(devlib::kExceptionTrap)));
}

} // namespace
} // namespace sunstone
