// SPDX-License-Identifier: Apache-2.0
// The queue of a context's asynchronous work.
#include "api/prime/work_queue.h"

#include <gtest/gtest.h>

#include <future>
#include <vector>

namespace sunstone::prime {
namespace {

TEST(WorkQueue, KeepsTheOrder) {
    std::vector<int> done;
    {
        WorkQueue queue;
        for (int i = 0; i < 100; ++i)
            queue.push([&, i] { done.push_back(i); });
        queue.waitFor(queue.ticket());
        EXPECT_EQ(done.size(), 100u);
        queue.push([&] { done.push_back(100); });
    }
    for (int i = 0; i <= 100; ++i)
        EXPECT_EQ(done.at(size_t(i)), i);
}

// A waiting thread does not wait for work that other threads push meanwhile.
TEST(WorkQueue, WaitingEndsBeforeLaterWork) {
    std::promise<void> first, second;
    WorkQueue queue;
    queue.push([&] { first.get_future().wait(); });
    const uint64_t ticket = queue.ticket();
    queue.push([&] { second.get_future().wait(); });
    first.set_value();
    queue.waitFor(ticket);
    second.set_value();
    queue.waitFor(queue.ticket());
}

TEST(WorkQueue, WithoutWorkNothingWaits) {
    WorkQueue queue;
    EXPECT_EQ(queue.ticket(), 0u);
    queue.waitFor(0);
}

} // namespace
} // namespace sunstone::prime
