// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/patience.h"

#include <gtest/gtest.h>

namespace sunstone::engine {
namespace {

constexpr uint64_t kMany = 1 << 20;

devlib::LaunchWork next(WarpPatience& patience, bool mayTry = true) {
    devlib::LaunchWork work = {};
    work.count = kMany;
    patience.choose(work, mayTry);
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

using devlib::kDepthPatience, devlib::kWithBlock;

// After launches that tell that the setting for long programs is the fastest.
void preferLongPrograms(WarpPatience& patience, std::vector<GpuBlockSize> sizes) {
    patience.setBlocks(std::move(sizes), 4);
    learn(patience, {{kMany, 4}, {kMany, 4}, {kMany, 4}, {kMany, 3}});
}

// Threads of the blocks of the next launch, all of whose warps report that they take `time`.
unsigned tryNext(WarpPatience& patience, uint64_t time) {
    devlib::LaunchWork work = {};
    work.count = kMany;
    const unsigned threads = patience.choose(work, true);
    EXPECT_TRUE(work.isMeasured);
    EXPECT_EQ(work.patience[1], threads == 64 ? kDepthPatience : kDepthPatience | kWithBlock);
    patience.learn({{kMany, time}, {kMany, time}, {kMany, time}, {kMany, time}}, work);
    return threads;
}

// The same of launches that report nothing.
unsigned chosen(WarpPatience& patience, uint64_t count = kMany, bool mayTry = true) {
    devlib::LaunchWork work = {};
    work.count = count;
    const unsigned threads = patience.choose(work, mayTry);
    EXPECT_FALSE(work.isMeasured);
    return threads;
}

TEST(WarpPatience, BlocksGrowWhileTheyAreFaster) {
    WarpPatience patience;
    preferLongPrograms(patience, {{64, 2048}, {128, 2048}, {256, 2048}, {512, 2048}});
    EXPECT_EQ(tryNext(patience, 100), 64u);
    EXPECT_EQ(tryNext(patience, 90), 128u);
    EXPECT_EQ(chosen(patience, kMany, false), 128u) << "captured";
    EXPECT_EQ(tryNext(patience, 95), 256u);
    EXPECT_EQ(chosen(patience), 128u);
}

TEST(WarpPatience, TheLargestBlocksMayBeTheFastest) {
    WarpPatience patience;
    preferLongPrograms(patience, {{64, 2048}, {128, 2048}});
    EXPECT_EQ(tryNext(patience, 100), 64u);
    EXPECT_EQ(tryNext(patience, 99), 128u);
    EXPECT_EQ(chosen(patience), 128u);
}

TEST(WarpPatience, WarpsMayNeedNoWaiting) {
    WarpPatience patience;
    preferLongPrograms(patience, {{64, 2048}, {128, 2048}, {256, 2048}});
    EXPECT_EQ(tryNext(patience, 100), 64u);
    EXPECT_EQ(tryNext(patience, 101), 128u);
    EXPECT_EQ(chosen(patience), 64u);
}

// Warps that share a multiprocessor with fewer others are faster, all of them together may not be.
TEST(WarpPatience, FewerWarpsAtATimeMustBeFaster) {
    WarpPatience patience;
    preferLongPrograms(patience, {{64, 2048}, {128, 1024}});
    EXPECT_EQ(tryNext(patience, 100), 64u);
    EXPECT_EQ(tryNext(patience, 60), 128u);
    EXPECT_EQ(chosen(patience), 64u);
}

TEST(WarpPatience, SmallLaunchesHaveSmallBlocks) {
    WarpPatience patience;
    preferLongPrograms(patience, {{64, 2048}, {128, 2048}});
    EXPECT_EQ(tryNext(patience, 100), 64u);
    EXPECT_EQ(tryNext(patience, 50), 128u);
    EXPECT_EQ(chosen(patience, 512), 128u);
    EXPECT_EQ(chosen(patience, 511), 64u);
}

TEST(WarpPatience, BlocksWaitOnlyWithTheSettingsForLongPrograms) {
    WarpPatience patience;
    patience.setBlocks({{64, 2048}, {128, 2048}}, 4);
    learn(patience, {{kMany, 4}, {kMany, 3}, {kMany, 4}, {kMany, 4}});
    EXPECT_EQ(chosen(patience), 64u);
    EXPECT_EQ(next(patience).patience[0], devlib::kLongPatience);
}

} // namespace
} // namespace sunstone::engine
