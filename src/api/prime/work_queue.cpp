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
    ++pushed_;
    changed_.notify_all();
}

uint64_t WorkQueue::ticket() {
    std::lock_guard lock(mutex_);
    return pushed_;
}

void WorkQueue::waitFor(uint64_t ticket) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return done_ >= ticket; });
}

void WorkQueue::loop() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return ending_ || !work_.empty(); });
        if (work_.empty())
            return;
        std::function<void()> work = std::move(work_.front());
        work_.pop_front();
        lock.unlock();
        work();
        work = nullptr;
        lock.lock();
        ++done_;
        changed_.notify_all();
    }
}

} // namespace sunstone::prime
