// SPDX-License-Identifier: Apache-2.0
#include "api/prime/work_queue.h"

namespace sunstone::prime {

WorkQueue::~WorkQueue() {
    {
        std::lock_guard lock(mutex_);
        ending_ = true;
        changed_.notify_all();
    }
    if (thread_.joinable())
        thread_.join();
}

void WorkQueue::push(std::function<void()> work) {
    std::lock_guard lock(mutex_);
    if (!thread_.joinable())
        thread_ = std::thread([this] { loop(); });
    work_.push_back(std::move(work));
    changed_.notify_all();
}

void WorkQueue::drain() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return work_.empty() && !busy_; });
}

void WorkQueue::loop() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return ending_ || !work_.empty(); });
        if (work_.empty())
            return;
        std::function<void()> work = std::move(work_.front());
        work_.pop_front();
        busy_ = true;
        lock.unlock();
        work();
        work = nullptr;
        lock.lock();
        busy_ = false;
        changed_.notify_all();
    }
}

} // namespace sunstone::prime
