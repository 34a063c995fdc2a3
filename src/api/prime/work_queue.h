// SPDX-License-Identifier: Apache-2.0
// A context's work in order of submission, on a thread that starts with the first item.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace sunstone::prime {

class WorkQueue {
public:
    WorkQueue() = default;
    // Finishes all work.
    ~WorkQueue();
    WorkQueue(const WorkQueue&) = delete;
    WorkQueue& operator=(const WorkQueue&) = delete;

    // The work must not throw, and must not own the queue's owner.
    void push(std::function<void()> work);
    // The number of the latest work; waitFor waits for the end of that work.
    uint64_t ticket();
    void waitFor(uint64_t ticket);

private:
    void loop();

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::function<void()>> work_;
    uint64_t pushed_ = 0, done_ = 0;
    bool ending_ = false;
    std::thread thread_;
};

} // namespace sunstone::prime
