// SPDX-License-Identifier: Apache-2.0
#include "engine/cpu/pace.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

using sunstone::engine::cpu::Pace;
using sunstone::engine::cpu::Way;

namespace {

// Runs `pieces` of 1,000 indices with these costs; returns how many went in flight as a whole.
// `pictureCost(i)`: a factor of the costs.
template <class PictureCost>
unsigned run(Pace& pace, unsigned pieces, uint64_t alone, uint64_t inFlight,
             const PictureCost& pictureCost) {
    unsigned count = 0;
    for (unsigned i = 0; i < pieces; ++i) {
        const Pace::Plan plan = pace.next();
        if (!plan.isMeasured)
            count += plan.way == Way::kInFlight;
        else
            for (const Way way : {Way::kAlone, Way::kInFlight})
                pace.add(way, 500, (way == Way::kInFlight ? inFlight : alone) / 2 * pictureCost(i));
    }
    return count;
}
unsigned run(Pace& pace, unsigned pieces, uint64_t alone, uint64_t inFlight) {
    return run(pace, pieces, alone, inFlight, [](unsigned) { return 1; });
}

TEST(Pace, TheFasterWayIsTaken) {
    Pace faster, slower;
    EXPECT_GT(run(faster, 1000, 1'000'000, 700'000), 900u);
    EXPECT_LT(run(slower, 1000, 700'000, 1'000'000), 100u);
}

// The first pieces in flight touch the memory of stacks for the first time.
TEST(Pace, TheColdStartIsForgotten) {
    Pace pace;
    run(pace, 8, 1'000'000, 100'000'000);
    EXPECT_GT(run(pace, 1000, 1'000'000, 700'000), 900u);
}

TEST(Pace, TheChoiceFollowsTheScene) {
    Pace pace;
    run(pace, 1000, 1'000'000, 500'000);
    run(pace, 20'000, 500'000, 1'000'000);
    EXPECT_LT(run(pace, 640, 500'000, 1'000'000), 64u);
}

// A sky above a forest: the parts of a picture must not decide.
TEST(Pace, PartsOfAPictureCostDifferentTimes) {
    const auto forest = [](unsigned piece) { return piece % 250 < 125 ? 1 : 20; };
    Pace faster, slower;
    EXPECT_GT(run(faster, 5000, 1'000'000, 950'000, forest), 4500u);
    EXPECT_LT(run(slower, 5000, 950'000, 1'000'000, forest), 100u);
}

TEST(Pace, PiecesWithoutTimeAreNoMeasurement) {
    Pace pace;
    EXPECT_EQ(run(pace, 100, 0, 0), 0u);
    EXPECT_TRUE(pace.next().isMeasured);
}

// Sums are halved several times. The choices of threads during measurement depend on scheduling;
// the final choice does not.
TEST(Pace, ThreadsMeasureAtOnce) {
    Pace pace;
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([&] { run(pace, 10'000, 1'000'000, 700'000); });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_GT(run(pace, 1'000, 1'000'000, 700'000), 900u);
}

} // namespace
