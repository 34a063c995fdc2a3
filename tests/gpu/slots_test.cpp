// SPDX-License-Identifier: Apache-2.0
// Slots of launches on the CPU device: they are freed after every outcome of a launch, and a
// launch's report is logged once, with its own context.
#include "bvh/gpu/testing/device.h"
#include "engine/gpu/launch_slots.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace sunstone::engine {
namespace {

using bvh::gpu::testing::Device;

// Before the first use: the back end's table of the driver is that of the CPU device.
[[maybe_unused]] const int kBackEnd = setenv("SUNSTONE_GPU_BACK_END", "cpu-device", 1);

class Slots : public testing::Test {
protected:
    static void SetUpTestSuite() { Device::get(); }
    void SetUp() override {
        ASSERT_EQ(driver().ctxGetCurrent(&cuda_), CUDA_SUCCESS);
        slots_.emplace(cuda_);
        context_->log = [this](LogLevel level, std::string_view, std::string_view text) {
            lines_.push_back({level, std::string(text)});
            if (whenTold_)
                whenTold_();
        };
    }
    static const device::cuda::Driver& driver() { return Device::get().driver(); }

    // A launch that does no work and reports this.
    CUdeviceptr launch(const devlib::LaunchReport& report) {
        GpuLaunchSlots::Lease slot(*slots_, context_, nullptr, 16, false);
        *slot->host = {};
        for (uint32_t& dimension : slot->host->launch.dimensions)
            dimension = 4;
        *slot->report = report;
        slot.queued();
        return slot->memory;
    }
    void wait() { ASSERT_EQ(driver().ctxSynchronize(), CUDA_SUCCESS); }

    static constexpr uint64_t kNone = devlib::kNoReport;
    static constexpr devlib::LaunchReport kNothing{kNone, kNone, kNone};
    CUcontext cuda_ = nullptr;
    std::optional<GpuLaunchSlots> slots_;
    ContextPtr context_ = std::make_shared<Context>();
    std::vector<std::pair<LogLevel, std::string>> lines_;
    std::function<void()> whenTold_;
};

TEST_F(Slots, AreUsedAgain) {
    const CUdeviceptr first = launch(kNothing);
    wait();
    EXPECT_EQ(launch(kNothing), first);
    EXPECT_TRUE(lines_.empty());
}

TEST_F(Slots, ComeBackWhenALaunchFailsWhileItIsQueued) {
    CUdeviceptr first = 0;
    try {
        GpuLaunchSlots::Lease slot(*slots_, context_, nullptr, 16, false);
        first = slot->memory;
        *slot->report = {kNone, 5, kNone}; // never run: no report
        fail(Code::kCudaError, "no");
    } catch (const Error&) {
    }
    wait();
    EXPECT_EQ(launch(kNothing), first);
    wait();
    slots_->tellOfEnded(~0u);
    EXPECT_TRUE(lines_.empty());
}

TEST_F(Slots, ReportsAreToldOnce) {
    launch(kNothing);
    launch({kNone, uint64_t(6) << 32 | 77, kNone});
    launch({kNone, kNone, uint32_t(devlib::kExceptionTrap)});
    wait();
    slots_->tellOfEnded(~0u);
    slots_->tellOfEnded(~0u);
    ASSERT_EQ(lines_.size(), 2u);
    std::sort(lines_.begin(), lines_.end());
    EXPECT_EQ(lines_[0].first, LogLevel::kError);
    EXPECT_EQ(lines_[0].second, "launch 3: trap or a failed assertion, at launch index (0, 0, 0)");
    EXPECT_EQ(lines_[1].second, "launch 2: no exception program saw: user exception 77, at launch "
                                "index (2, 1, 0)");
}

TEST_F(Slots, LastReportsAreToldAtTheEnd) {
    launch({kNone, 9, kNone});
    slots_.reset();
    ASSERT_EQ(lines_.size(), 1u);
    EXPECT_NE(lines_[0].second.find("user exception 9"), std::string::npos);
}

TEST_F(Slots, LogCallbacksMayLaunch) {
    launch({kNone, 9, kNone});
    wait();
    whenTold_ = [this] {
        whenTold_ = nullptr;
        launch(kNothing);
    };
    launch(kNothing);
    EXPECT_EQ(lines_.size(), 1u);
}

TEST_F(Slots, AwaitedLaunchesAreToldByThoseWhoWait) {
    GpuLaunchSlots::Lease slot(*slots_, context_, nullptr, 16, true);
    *slot->host = {};
    for (uint32_t& dimension : slot->host->launch.dimensions)
        dimension = 1;
    *slot->report = {uint32_t(devlib::kExceptionTraceDepth), kNone, kNone};
    EXPECT_NE(slot.finish().find("trace depth exceeded (exception -2)"), std::string::npos);
    EXPECT_EQ(lines_.size(), 1u);
    slots_->tellOfEnded(~0u);
    EXPECT_EQ(lines_.size(), 1u);
}

} // namespace
} // namespace sunstone::engine
