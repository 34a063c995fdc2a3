// SPDX-License-Identifier: Apache-2.0
// Which launches of a new pipeline wait for its compilation.
#include "engine/gpu/code/code.h"

#include <gtest/gtest.h>

namespace sunstone::engine {
namespace {

TEST(WaitsForWhole, TheThirdLargeLaunchWaits) {
    WaitsForWhole waits;
    for (unsigned i = 0; i < 2; ++i)
        EXPECT_FALSE(waits.next(WaitsForWhole::kLargeLaunch));
    EXPECT_TRUE(waits.next(WaitsForWhole::kLargeLaunch));
    EXPECT_TRUE(waits.next(uint64_t(1) << 30));
}

TEST(WaitsForWhole, IsPatientForAFewLaunches) {
    WaitsForWhole waits;
    const auto first = waits.patience();
    unsigned patient = 0;
    for (unsigned i = 0; i < 100; ++i) {
        waits.next(WaitsForWhole::kLargeLaunch);
        patient += waits.patience() > first;
    }
    EXPECT_GT(patient, 0u);
    EXPECT_LT(patient, 20u);
    EXPECT_EQ(first, waits.patience());
}

TEST(WaitsForWhole, SmallLaunchesNeitherWaitNorCount) {
    WaitsForWhole waits;
    for (unsigned i = 0; i < 100; ++i)
        EXPECT_FALSE(waits.next(WaitsForWhole::kLargeLaunch - 1));
    for (unsigned i = 0; i < 2; ++i)
        EXPECT_FALSE(waits.next(WaitsForWhole::kLargeLaunch));
    EXPECT_FALSE(waits.next(1));
    EXPECT_TRUE(waits.next(WaitsForWhole::kLargeLaunch));
}

} // namespace
} // namespace sunstone::engine
