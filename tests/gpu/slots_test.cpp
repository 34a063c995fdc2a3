// SPDX-License-Identifier: Apache-2.0
// Slots of launches on the CPU device: they are freed after every outcome of a launch, and a
// launch's report is logged once, with its own context. Pools of memory that warps claim.
#include "base/error.h"
#include "bvh/gpu/testing/device.h"
#include "engine/gpu/lane_memory.h"
#include "engine/gpu/launch_slots.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <dlfcn.h>
#include <thread>

namespace sunstone::engine {
namespace {

using bvh::gpu::testing::Device;

// Set before the first use: the back end calls the driver of the CPU device.
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

    // A launch that does no work and leaves this report.
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

// Slots of launches that graphs own.
class CapturedSlots : public Slots {
protected:
    void SetUp() override {
        Slots::SetUp();
        ASSERT_EQ(driver().streamCreate(&stream_, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    }
    void TearDown() override { EXPECT_EQ(driver().streamDestroy(stream_), CUDA_SUCCESS); }

    // A driver function that the engine itself does not call.
    template <class Function>
    static Function* get(const char* name) {
        static void* const library = dlopen(TEST_CUDA_LIBRARY, RTLD_NOW);
        return reinterpret_cast<Function*>(dlsym(library, name));
    }
    // Captures a launch of the pipeline that does no work and leaves this report.
    CUgraph capture(const devlib::LaunchReport& report) {
        CUgraph graph = nullptr;
        EXPECT_EQ(get<CUresult(CUstream, CUstreamCaptureMode)>("cuStreamBeginCapture_v2")(
                      stream_, CU_STREAM_CAPTURE_MODE_RELAXED),
                  CUDA_SUCCESS);
        {
            GpuLaunchSlots::Lease slot(*slots_, context_, stream_, 16, false);
            slot->findings = pipeline_;
            *slot->host = {};
            for (uint32_t& dimension : slot->host->launch.dimensions)
                dimension = 4;
            *slot->report = report;
            memory_ = slot->memory;
            slot.queued();
        }
        EXPECT_EQ(get<CUresult(CUstream, CUgraph*)>("cuStreamEndCapture")(stream_, &graph),
                  CUDA_SUCCESS);
        return graph;
    }
    static void destroy(CUgraph graph) {
        EXPECT_EQ(get<CUresult(CUgraph)>("cuGraphDestroy")(graph), CUDA_SUCCESS);
    }
    // Whether launches use the memory of the last captured one again within this time: the driver
    // frees what graphs own on a thread of its own.
    bool comesBack(unsigned milliseconds) {
        for (unsigned i = 0; i <= milliseconds; ++i) {
            const CUdeviceptr next = launch(kNothing);
            wait();
            if (next == memory_)
                return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return false;
    }

    static constexpr devlib::LaunchReport kRaised{kNone, 9, kNone};
    CUstream stream_ = nullptr;
    CUdeviceptr memory_ = 0;
    std::shared_ptr<LaunchFindings> pipeline_ = std::make_shared<LaunchFindings>();
};

TEST_F(CapturedSlots, ComeBackWhenTheGraphIsDestroyed) {
    destroy(capture(kNothing));
    const CUdeviceptr first = memory_;
    for (unsigned i = 0; i < 3; ++i) {
        ASSERT_TRUE(comesBack(5000));
        destroy(capture(kNothing));
        EXPECT_EQ(memory_, first);
    }
    EXPECT_TRUE(lines_.empty());
}

TEST_F(CapturedSlots, BelongToExecutableGraphsToo) {
    const CUgraph graph = capture(kRaised);
    CUgraphExec exec = nullptr;
    ASSERT_EQ(get<CUresult(CUgraphExec*, CUgraph, unsigned long long)>(
                  "cuGraphInstantiateWithFlags")(&exec, graph, 0),
              CUDA_SUCCESS);
    destroy(graph);
    EXPECT_FALSE(comesBack(50));
    EXPECT_TRUE(lines_.empty());
    EXPECT_EQ(get<CUresult(CUgraphExec)>("cuGraphExecDestroy")(exec), CUDA_SUCCESS);
    EXPECT_TRUE(comesBack(5000));
    ASSERT_EQ(lines_.size(), 1u);
    EXPECT_NE(lines_[0].second.find("user exception 9"), std::string::npos);
}

// A run of the graph may be writing the report.
TEST_F(CapturedSlots, ReportsAreLeftAloneWhileTheGraphMayRun) {
    const CUgraph graph = capture(kRaised);
    slots_->tellOfEnded(~0u);
    EXPECT_TRUE(lines_.empty());
    pipeline_.reset();
    slots_->tellOfEnded(~0u);
    slots_->tellOfEnded(~0u);
    ASSERT_EQ(lines_.size(), 1u);
    EXPECT_NE(lines_[0].second.find("user exception 9"), std::string::npos);
    EXPECT_FALSE(comesBack(5)) << "the graph exists";
    destroy(graph);
    EXPECT_TRUE(comesBack(5000));
    EXPECT_EQ(lines_.size(), 1u);
}

TEST_F(CapturedSlots, GraphsThatNeverRanReportNothing) {
    launch(kRaised);
    wait();
    slots_->tellOfEnded(~0u);
    ASSERT_EQ(lines_.size(), 1u);
    lines_.clear();
    EXPECT_EQ(get<CUresult(CUstream, CUstreamCaptureMode)>("cuStreamBeginCapture_v2")(
                  stream_, CU_STREAM_CAPTURE_MODE_RELAXED),
              CUDA_SUCCESS);
    {
        GpuLaunchSlots::Lease slot(*slots_, context_, stream_, 16, false);
        memory_ = slot->memory;
        slot.queued(); // the report is that of the launch before
    }
    CUgraph graph = nullptr;
    EXPECT_EQ(get<CUresult(CUstream, CUgraph*)>("cuStreamEndCapture")(stream_, &graph),
              CUDA_SUCCESS);
    destroy(graph);
    EXPECT_TRUE(comesBack(5000));
    slots_->tellOfEnded(~0u);
    EXPECT_TRUE(lines_.empty());
}

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

class LaneMemory : public Slots {
protected:
    void TearDown() override { memory_.release(); }
    GpuLaneMemory memory_;
};

TEST_F(LaneMemory, PipelinesShareSlotsOfTheirSize) {
    const devlib::LaneMemory first = memory_.obtain(9000, 100, false);
    EXPECT_GE(first.slotBytes, 9000u);
    EXPECT_EQ(first.words, 4u) << "sets of 32 warps";
    EXPECT_EQ(memory_.obtain(12000, 10, true).slots, first.slots);
    EXPECT_NE(memory_.obtain(13000, 10, false).slots, first.slots) << "larger slots";
    EXPECT_NE(memory_.obtain(9000, 1000, false).slots, first.slots) << "more warps";
    std::vector<uint32_t> free(first.words);
    ASSERT_EQ(driver().memcpyDtoH(free.data(), first.freeSlots, free.size() * 4), CUDA_SUCCESS);
    EXPECT_EQ(free, std::vector<uint32_t>(first.words, ~0u));
}

TEST_F(LaneMemory, WithoutRoomForAFewIsAnError) {
    const auto codeOf = [&](uint64_t bytes, uint32_t warps, bool inStep = false) {
        try {
            memory_.obtain(bytes, warps, inStep);
        } catch (const Error& error) {
            return error.code();
        }
        return Code::kOk;
    };
    CUdevice device = 0;
    size_t total = 0;
    ASSERT_EQ(driver().ctxGetDevice(&device), CUDA_SUCCESS);
    ASSERT_EQ(driver().deviceTotalMem(&total, device), CUDA_SUCCESS);
    constexpr uint64_t kLarge = uint64_t(3) << 30; // 32 of these are the least that is tried
    if (total / 32 < kLarge)
        EXPECT_EQ(codeOf(kLarge, 4096), Code::kOutOfMemory);
    EXPECT_EQ(codeOf(total >> 18, 1u << 19, true), Code::kOutOfMemory) << "all or none";
    EXPECT_EQ(codeOf(uint64_t(5) << 30, 1), Code::kNotSupported);
    EXPECT_EQ(codeOf(4096, 1), Code::kOk) << "nothing is lost";
}

} // namespace
} // namespace sunstone::engine
