// SPDX-License-Identifier: Apache-2.0
// Device programs that access unmapped memory: the launch fails, the log names the place, and the
// process continues.
#include "device/faults.h"
#include "rig.h"

#include <algorithm>
#include <sstream>

namespace tests::api {
namespace {

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SUNSTONE_SANITIZED 1
#endif
#endif

class Faults : public DeviceTest {
protected:
    void SetUp() override {
#ifdef SUNSTONE_SANITIZED
        GTEST_SKIP() << "a sanitizer reports faults";
#endif
        DeviceTest::SetUp();
        rig_ = rig("faults", compileOptions(0));
        rig_->raygenRecord(rig_->raygen("__raygen__faults"));
        rig_->link();
    }
    void TearDown() override {
        if (rig_) // takes the error of the stream if the test has left it
            (void)launch({results_.as<unsigned>(), 0, 0, 0}, rig_->table());
        rig_.reset();
        DeviceTest::TearDown();
    }
    OptixResult launch(const FaultParams& values, OptixShaderBindingTable sbt) {
        log_.clear();
        *params_.as<FaultParams>() = values;
        const OptixResult result = optixLaunch(rig_->pipeline(), nullptr, params_.address(),
                                               sizeof values, &sbt, kIndices, 1, 1);
        waitForDevice();
        return result;
    }
    static constexpr unsigned kIndices = 1000, kAt = 517;
    std::unique_ptr<Rig> rig_;
    Buffer results_{kIndices * 4}, params_{sizeof(FaultParams)};
};

TEST_P(Faults, EndTheLaunchAndNameTheLine) {
    auto* results = results_.as<unsigned>();
    for (const unsigned long long wild :
         {0x10ull, 0x7ff012345678ull & ~4095ull, 0xdead000000000000ull})
        for (const unsigned writes : {0u, 1u}) {
            SCOPED_TRACE(testing::Message() << std::hex << wild << " writes " << writes);
            std::fill(results, results + kIndices, 0u);
            (void)launch({results, wild, kAt, writes}, rig_->table());
            EXPECT_TRUE(log_.hasError("invalid memory access", "launch index (517, 0, 0)"))
                << log_.all();
            EXPECT_TRUE(log_.hasError("__raygen__faults", "faults.cu:")) << log_.all();
            std::ostringstream address;
            address << "to address 0x" << std::hex << wild;
            EXPECT_TRUE(log_.hasError(address.str(), "")) << log_.all();
            EXPECT_EQ(0u, results[kAt]) << "the index ended there";
            // The stream's next call returns the error, and later calls work.
            EXPECT_EQ(OPTIX_ERROR_LAUNCH_FAILURE, launch({results, 0, 0, 0}, rig_->table()));
            EXPECT_OK(launch({results, 0, 0, 0}, rig_->table()));
            for (unsigned i = 0; i < kIndices; ++i)
                ASSERT_EQ(i + 1, results[i]);
        }
}

TEST_P(Faults, OfEveryIndexAreOneFailure) {
    (void)launch({nullptr, 0, 0, 0}, rig_->table());
    EXPECT_TRUE(log_.hasError("invalid memory access to address", "launch index (0, 0, 0)"))
        << log_.all();
    EXPECT_EQ(OPTIX_ERROR_LAUNCH_FAILURE,
              launch({results_.as<unsigned>(), 0, 0, 0}, rig_->table()));
}

TEST_P(Faults, TrapsNameProgramAndLine) {
    (void)launch({results_.as<unsigned>(), 0, kAt, 0, kFaultTrap}, rig_->table());
    EXPECT_TRUE(log_.hasError("trap", ", in __raygen__faults, at ")) << log_.all();
    EXPECT_TRUE(log_.hasError("faults.cu:", "launch index (517, 0, 0)")) << log_.all();
}

TEST_P(Faults, TrapsFailTheStream) {
    (void)launch({results_.as<unsigned>(), 0, kAt, 0, kFaultTrap}, rig_->table());
    EXPECT_EQ(OPTIX_ERROR_LAUNCH_FAILURE,
              launch({results_.as<unsigned>(), 0, 0, 0}, rig_->table()));
}

TEST_P(Faults, StackOverflowsNameFunctionAndLine) {
    (void)launch({results_.as<unsigned>(), 0, kAt, 0, kFaultRecursion}, rig_->table());
    EXPECT_TRUE(log_.hasError("stack overflow", "descend")) << log_.all();
    EXPECT_TRUE(log_.hasError("faults.cu:", "launch index (517, 0, 0)")) << log_.all();
    EXPECT_EQ(OPTIX_ERROR_LAUNCH_FAILURE,
              launch({results_.as<unsigned>(), 0, 0, 0}, rig_->table()));
}

// Without line information, the log names the function.
TEST_P(Faults, WithoutLinesNameTheProgram) {
    Rig rig(context_, log_,
            ptxModule(".visible .entry __raygen__plain()\n{\n.reg .b64 %rd<2>;\n"
                      "mov.u64 %rd1, 64;\nst.u32 [%rd1], 1;\nret;\n}\n"),
            compileOptions(0));
    rig.raygenRecord(rig.raygen("__raygen__plain"));
    rig.link();
    const OptixShaderBindingTable table = rig.table();
    log_.clear();
    (void)optixLaunch(rig.pipeline(), nullptr, 0, 0, &table, 1, 1, 1);
    waitForDevice();
    EXPECT_TRUE(log_.hasError("to address 0x40, in __raygen__plain, at launch index", ""))
        << log_.all();
    (void)optixLaunch(rig.pipeline(), nullptr, 0, 0, &table, 1, 1, 1); // takes the error
    waitForDevice();
}

// A context without a callback: the first failure of a launch goes to stderr.
TEST_P(Faults, GoToStderrOnceWithoutACallback) {
    for (const unsigned level : {0u, 4u}) {
        ASSERT_OK(optixDeviceContextSetLogCallback(
            context_, level == 0 ? nullptr : LogRecord::callback, &log_, level));
        testing::internal::CaptureStderr();
        for (int round = 0; round < 3; ++round) {
            (void)launch({results_.as<unsigned>(), 0x10, kAt, 0}, rig_->table());
            (void)launch({results_.as<unsigned>(), 0, 0, 0}, rig_->table()); // takes the error
        }
        const std::string text = testing::internal::GetCapturedStderr();
        const std::string fault = "invalid memory access to address 0x10, in __raygen__faults";
        const size_t first = text.find(fault);
        if (level == 0) {
            ASSERT_NE(std::string::npos, first) << text;
            EXPECT_NE(std::string::npos, text.find("faults.cu:", first)) << text;
            EXPECT_EQ(std::string::npos, text.find(fault, first + 1)) << text;
        } else {
            EXPECT_EQ("", text);
            EXPECT_TRUE(log_.hasError(fault, "")) << log_.all();
        }
    }
}

INSTANTIATE_DEVICE_TEST(Faults);

} // namespace
} // namespace tests::api
