// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/patience.h"

#include <gtest/gtest.h>

namespace sunstone::engine {
namespace {

constexpr uint64_t kMany = 1 << 20;

devlib::LaunchWork next(WarpPatience& patience, bool mayTry = true, bool withBlocks = false) {
    devlib::LaunchWork work = {};
    patience.choose(work, mayTry, withBlocks);
    return work;
}

using Paces = devlib::WarpPace[devlib::kPatienceWays];
// The report of a launch that tries all ways.
void learn(WarpPatience& patience, const Paces& paces) {
    patience.learn(paces, next(patience));
}

TEST(WarpPatience, FirstLaunchTriesAll) {
    WarpPatience patience;
    const devlib::LaunchWork work = next(patience);
    EXPECT_TRUE(work.isMeasured);
    EXPECT_EQ(work.patience[0], devlib::kShortPatience);
    EXPECT_EQ(work.patience[1], devlib::kLongPatience);
    EXPECT_EQ(work.patience[2], devlib::kTilePatience);
    EXPECT_EQ(work.patience[3], devlib::kDepthPatience);
}

TEST(WarpPatience, TheFastestWayIsTaken) {
    constexpr uint32_t kWays[] = {devlib::kShortPatience, devlib::kLongPatience,
                                  devlib::kTilePatience, devlib::kDepthPatience};
    for (size_t fastest = 0; fastest < std::size(kWays); ++fastest) {
        WarpPatience patience;
        next(patience);
        devlib::WarpPace paces[] = {{kMany, 1000}, {kMany, 1000}, {kMany, 1000}, {kMany, 1000}};
        paces[fastest].time -= 10;
        learn(patience, paces);
        const devlib::LaunchWork work = next(patience);
        EXPECT_FALSE(work.isMeasured);
        for (const uint32_t each : work.patience)
            EXPECT_EQ(each, kWays[fastest]);
    }
}

TEST(WarpPatience, FewRaysDecideNothing) {
    WarpPatience patience;
    for (int launch = 0; launch < 10; ++launch) {
        EXPECT_TRUE(next(patience).isMeasured);
        learn(patience, {{100, 1}, {100, 2}, {100, 3}, {100, 4}});
    }
    learn(patience, {{kMany, 100}, {kMany, 200}, {kMany, 300}, {kMany, 400}});
    EXPECT_EQ(next(patience).patience[1], devlib::kShortPatience);
}

// Kernels whose warps take no launch indices report zeros.
TEST(WarpPatience, LaunchesWithoutAReport) {
    WarpPatience patience;
    for (int launch = 0; launch < 200; ++launch) {
        learn(patience, {{0, 0}, {0, 0}, {0, 0}, {0, 0}});
        EXPECT_TRUE(next(patience).isMeasured);
    }
}

TEST(WarpPatience, CapturedLaunchesTryNothing) {
    WarpPatience patience;
    const devlib::LaunchWork work = next(patience, false);
    EXPECT_FALSE(work.isMeasured);
    EXPECT_EQ(work.patience[0], work.patience[1]);
    EXPECT_TRUE(next(patience).isMeasured);
}

TEST(WarpPatience, ChoicesAreMadeAgain) {
    WarpPatience patience;
    learn(patience, {{kMany, 100}, {kMany, 200}, {kMany, 300}, {kMany, 400}});
    int measured = 0;
    for (int launch = 0; launch < 100; ++launch)
        measured += next(patience).isMeasured != 0;
    EXPECT_GT(measured, 0);
    learn(patience, {{kMany, 200}, {kMany, 100}, {kMany, 150}, {kMany, 300}});
    EXPECT_EQ(next(patience).patience[0], devlib::kLongPatience);
}

TEST(WarpPatience, TwoLaunchesCompareBlocksThatWait) {
    using devlib::kDepthPatience, devlib::kWithBlock;
    for (const bool isFaster : {false, true}) {
        WarpPatience patience;
        learn(patience, {{kMany, 4}, {kMany, 4}, {kMany, 4}, {kMany, 3}});
        devlib::LaunchWork work = next(patience, true, true);
        EXPECT_TRUE(work.isMeasured);
        EXPECT_EQ(work.patience[0], kDepthPatience);
        patience.learn({{kMany, 100}, {kMany, 100}, {kMany, 100}, {kMany, 100}}, work);
        EXPECT_EQ(next(patience, false, true).patience[1], kDepthPatience) << "captured";
        work = next(patience, true, true);
        EXPECT_TRUE(work.isMeasured);
        EXPECT_EQ(work.patience[1], kDepthPatience | kWithBlock);
        const uint64_t time = isFaster ? 99 : 101;
        patience.learn({{kMany, time}, {kMany, time}, {kMany, time}, {kMany, time}}, work);
        work = next(patience, true, true);
        EXPECT_FALSE(work.isMeasured);
        EXPECT_EQ(work.patience[3], isFaster ? kDepthPatience | kWithBlock : kDepthPatience);
        EXPECT_EQ(next(patience, true, false).patience[3], kDepthPatience);
    }
}

TEST(WarpPatience, BlocksWaitOnlyWithTheWayForLongPrograms) {
    WarpPatience patience;
    learn(patience, {{kMany, 4}, {kMany, 3}, {kMany, 4}, {kMany, 4}});
    const devlib::LaunchWork work = next(patience, true, true);
    EXPECT_FALSE(work.isMeasured);
    EXPECT_EQ(work.patience[0], devlib::kLongPatience);
}

} // namespace
} // namespace sunstone::engine
