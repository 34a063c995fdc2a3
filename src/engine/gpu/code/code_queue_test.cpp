// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/code/code_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <thread>
#include <vector>

namespace sunstone::engine {
namespace {

TEST(GpuCodeQueue, JobsRunInOrderAndOneAtATime) {
    GpuCodeQueue queue;
    std::vector<int> order;
    std::atomic<int> running = 0;
    for (int round = 0; round < 3; ++round) { // the thread has ended between two rounds
        for (int i = 0; i < 5; ++i)
            queue.add(&queue, [&, i] {
                EXPECT_EQ(++running, 1);
                order.push_back(i);
                --running;
            });
        std::promise<void> last;
        queue.add(&queue, [&] { last.set_value(); });
        last.get_future().wait();
        queue.finish(&queue);
        EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
        order.clear();
    }
}

TEST(GpuCodeQueue, FinishWaitsForTheJobThatRunsAndRemovesOthers) {
    GpuCodeQueue queue;
    const int mine = 0, others = 0;
    std::promise<void> begun, mayEnd;
    std::shared_future<void> end = mayEnd.get_future().share();
    std::atomic<int> ran = 0, ranOthers = 0;
    queue.add(&mine, [&] {
        begun.set_value();
        end.wait();
        ++ran;
    });
    queue.add(&mine, [&] { ran += 100; });
    queue.add(&others, [&] { ++ranOthers; });
    begun.get_future().wait();
    std::thread release([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        mayEnd.set_value();
    });
    queue.finish(&mine);
    EXPECT_EQ(ran, 1);
    release.join();
    std::promise<void> last;
    queue.add(&others, [&] { last.set_value(); });
    last.get_future().wait();
    EXPECT_EQ(ranOthers, 1);
    queue.finish(&others);
    EXPECT_EQ(ran, 1);
}

// What a job holds is destroyed when the job has run or is removed.
TEST(GpuCodeQueue, JobsAreDestroyed) {
    GpuCodeQueue queue;
    const auto held = std::make_shared<int>(0);
    std::promise<void> mayEnd;
    std::shared_future<void> end = mayEnd.get_future().share();
    queue.add(&queue, [held, end] { end.wait(); });
    queue.add(&queue, [held] {});
    mayEnd.set_value();
    queue.finish(&queue);
    EXPECT_EQ(held.use_count(), 1);
}

TEST(GpuCodeQueue, NothingRunsAfterTheEnd) {
    GpuCodeQueue queue;
    std::atomic<bool> ran = false;
    queue.end();
    queue.add(&queue, [&] { ran = true; });
    queue.finish(&queue);
    EXPECT_FALSE(ran);
}

TEST(GpuCodeQueue, JobsSeeThatTheyAreUnwanted) {
    GpuCodeQueue queue;
    const int mine = 0, others = 0;
    std::promise<void> begun;
    queue.add(&mine, [&] {
        EXPECT_FALSE(queue.isUnwanted(&mine));
        begun.set_value();
        while (!queue.isUnwanted(&mine))
            std::this_thread::yield();
        EXPECT_FALSE(queue.isUnwanted(&others));
    });
    begun.get_future().wait();
    queue.finish(&mine);
    EXPECT_FALSE(queue.isUnwanted(&mine));
    queue.end();
    EXPECT_TRUE(queue.isUnwanted(&mine));
}

} // namespace
} // namespace sunstone::engine
