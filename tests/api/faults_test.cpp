// SPDX-License-Identifier: Apache-2.0
// Device programs that access unmapped memory: the launch fails, the log names the place, and the
// process continues.
#include "faults.h"
#include "rig.h"

#include <algorithm>

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
            if (wild == 0x10)
                EXPECT_TRUE(log_.hasError("0x10", "")) << log_.all();
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

INSTANTIATE_DEVICE_TEST(Faults);

} // namespace
} // namespace tests::api
