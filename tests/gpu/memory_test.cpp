// SPDX-License-Identifier: Apache-2.0
// The GPU back end's knowledge of its memory, on the CPU device: which structures exist, and how
// much memory host and GPU can share.
#include "base/error.h"
#include "bvh/gpu/testing/device.h"
#include "devlib/graph.h"
#include "engine/gpu/handle_table.h"
#include "engine/gpu/shared_memory.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>

namespace sunstone::engine {
namespace {

using bvh::gpu::testing::Buffer;
using bvh::gpu::testing::Device;

// Set before the first use: the back end calls the driver of the CPU device.
[[maybe_unused]] const int kBackEnd = setenv("SUNSTONE_GPU_BACK_END", "cpu-device", 1);

class GpuHandles : public testing::Test {
protected:
    static void SetUpTestSuite() { Device::get(); }
    std::unique_ptr<Buffer> note(devlib::HandleTag tag) {
        auto memory = std::make_unique<Buffer>(256);
        table_.note(devlib::makeHandle(memory->data(), tag), false);
        return memory;
    }
    GpuHandleTable table_;
};

TEST_F(GpuHandles, TwoInstanceStructuresMayBeOneGraph) {
    const auto mesh = note(devlib::kTagGas), other = note(devlib::kTagGas);
    auto first = note(devlib::kTagIas);
    table_.note(devlib::makeHandle(first->data(), devlib::kTagIas), false);
    EXPECT_FALSE(table_.graphs().deep) << "one, built twice";
    first.reset();
    auto second = note(devlib::kTagIas);
    EXPECT_FALSE(table_.graphs().deep) << "the memory of the first is freed";
    auto third = note(devlib::kTagIas);
    EXPECT_TRUE(table_.graphs().deep);
    third.reset();
    EXPECT_TRUE(table_.graphs().deep) << "programs may have been made for it";
}

TEST_F(GpuHandles, TransformsMayBeAboveAnything) {
    const auto instances = note(devlib::kTagIas);
    EXPECT_FALSE(table_.graphs().deep);
    const auto transform = note(devlib::kTagStatic);
    EXPECT_TRUE(table_.graphs().deep);
}

TEST(GpuSharedMemory, MoreThanHostAndGpuHaveIsRefusedWithoutTheDriver) {
    Device::get();
    CUcontext context = nullptr;
    ASSERT_EQ(device::cuda::driver().ctxGetCurrent(&context), CUDA_SUCCESS);
    GpuSharedMemory memory(context);
    static bool isAsked;
    isAsked = false;
    auto& driver = device::cuda::driverForTests();
    const auto original = driver.memAllocManaged;
    driver.memAllocManaged = [](CUdeviceptr* address, size_t, unsigned) {
        isAsked = true;
        *address = 0;
        return CUDA_ERROR_OUT_OF_MEMORY;
    };
    Code code = Code::kOk;
    try {
        memory.allocate(size_t(1) << 50);
    } catch (const Error& error) {
        code = error.code();
    }
    driver.memAllocManaged = original;
    EXPECT_EQ(code, Code::kOutOfMemory);
    EXPECT_FALSE(isAsked) << "drivers grant it";
    void* const piece = memory.allocate(1 << 20);
    EXPECT_NE(piece, nullptr) << "nothing is lost";
    memory.free(piece);
}

} // namespace
} // namespace sunstone::engine
