// SPDX-License-Identifier: Apache-2.0
#include "engine/cpu/pace.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

using sunstone::engine::cpu::Pace;
using sunstone::engine::cpu::Way;

namespace {

// Runs `pieces` of 1,000 indices with these costs; returns how many went in flight.
unsigned run(Pace& pace, unsigned pieces, uint64_t alone, uint64_t inFlight) {
    unsigned count = 0;
    for (unsigned i = 0; i < pieces; ++i) {
        const Way way = pace.next();
        count += way == Way::kInFlight;
        pace.add(way, 1000, way == Way::kInFlight ? inFlight : alone);
    }
    return count;
}

TEST(Pace, TheFasterWayIsTaken) {
    Pace faster, slower;
    EXPECT_GT(run(faster, 1000, 1'000'000, 700'000), 900u);
    EXPECT_LT(run(slower, 1000, 700'000, 1'000'000), 100u);
}

// The first pieces in flight touch the memory of stacks for the first time.
TEST(Pace, TheColdStartIsForgotten) {
    Pace pace;
    run(pace, 60, 1'000'000, 10'000'000);
    EXPECT_GT(run(pace, 1000, 1'000'000, 700'000), 900u);
}

TEST(Pace, TheChoiceFollowsTheScene) {
    Pace pace;
    run(pace, 1000, 1'000'000, 500'000);
    run(pace, 20'000, 500'000, 1'000'000);
    EXPECT_LT(run(pace, 640, 500'000, 1'000'000), 64u);
}

TEST(Pace, PiecesWithoutTimeAreNoMeasurement) {
    Pace pace;
    EXPECT_NEAR(run(pace, 100, 0, 0), 50, 1);
}

// Sums are halved several times. What threads choose while others measure depends on how they are
// scheduled; what they leave behind does not.
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
