// SPDX-License-Identifier: Apache-2.0
// parallelFor: each index runs once, in shrinking pieces; nesting and exceptions.
#include "base/threads/threads.h"

#include "base/threads/thread_team.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace sunstone {
namespace {

TEST(ParallelFor, CoversEveryIndexOnceInPiecesOfTheGrain) {
    for (size_t count : {0u, 1u, 2u, 7u, 100u, 12345u})
        for (size_t grain : {0u, 1u, 3u, 64u, 100000u}) {
            std::vector<std::atomic<int>> visits(count);
            std::atomic<size_t> small{0};
            parallelFor(count, grain, [&](size_t begin, size_t end) {
                EXPECT_LT(begin, end);
                EXPECT_LE(end, count);
                small += end - begin < std::min(std::max<size_t>(grain, 1), count);
                for (size_t i = begin; i < end; ++i)
                    ++visits[i];
            });
            EXPECT_LE(small, 1u) << "only the last piece may be smaller";
            for (size_t i = 0; i < count; ++i)
                EXPECT_EQ(visits[i], 1) << i;
        }
}

TEST(ParallelFor, PiecesShrinkTowardsTheEnd) {
    std::atomic<size_t> lastPiece{0};
    constexpr size_t kCount = 100000;
    parallelFor(kCount, 1, [&](size_t begin, size_t end) {
        if (end == kCount)
            lastPiece = end - begin;
    });
    EXPECT_EQ(lastPiece, 1u);
}

TEST(ParallelFor, NestsAndRethrows) {
    std::atomic<size_t> sum{0};
    parallelFor(10, 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            parallelFor(100, 1, [&](size_t b, size_t e) { sum += e - b; });
    });
    EXPECT_EQ(sum, 1000u);

    std::atomic<size_t> started{0};
    EXPECT_THROW(parallelFor(1000000, 1,
                             [&](size_t, size_t) {
                                 ++started;
                                 throw std::runtime_error("no");
                             }),
                 std::runtime_error);
    EXPECT_LE(started, threadCount()) << "nothing is started after a failure";
}

TEST(ThreadTeam, LimitsTheThreadsOfItsWork) {
    ThreadTeam team(1);
    EXPECT_EQ(team.threads(), 1u);
    EXPECT_LE(ThreadTeam(1000).threads(), threadCount());
    EXPECT_EQ(ThreadTeam(0).threads(), 1u);
    std::mutex mutex;
    std::set<std::thread::id> threads;
    std::atomic<size_t> items{0};
    team.run([&] {
        parallelFor(1000, 1, [&](size_t begin, size_t end) {
            items += end - begin;
            std::this_thread::sleep_for(std::chrono::microseconds(10));
            std::lock_guard lock(mutex);
            threads.insert(std::this_thread::get_id());
        });
    });
    EXPECT_EQ(items, 1000u);
    EXPECT_EQ(threads.size(), 1u);
}

} // namespace
} // namespace sunstone
