// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/code/code_queue.h"

#include "base/float_mode.h"
#include "base/forked.h"
#include "base/log.h"
#include "engine/gpu/process.h"

#include <cstdlib>
#include <system_error>
#include <thread>

namespace sunstone::engine {

void waitFor(const GpuLaterCode& later) {
    constexpr std::chrono::milliseconds kLimit(3000), kStep(1);
    const auto start = std::chrono::steady_clock::now();
    while (!later.isReady && std::chrono::steady_clock::now() - start < kLimit)
        std::this_thread::sleep_for(kStep);
}

void GpuCodeQueue::add(const void* owner, std::function<void()> job) {
    // Static objects that a job uses are destroyed at exit. The handler that is registered last
    // runs first, and these objects exist by now.
    static std::once_flag registered;
    std::call_once(registered, [] { std::atexit([] { gpuProcess().codeQueue.end(); }); });
    std::lock_guard lock(mutex_);
    if (ends_)
        return;
    jobs_.push_back({owner, std::move(job)});
    if (hasThread_)
        return;
    try {
        std::thread([this] { run(); }).detach();
        hasThread_ = true;
    } catch (const std::system_error& error) { // launches keep the code that is ready
        jobs_.clear();
        log(LogLevel::kWarning, "engine",
            message("no thread to compile pipelines in: ", error.what()));
    }
}

void GpuCodeQueue::run() {
    setDeviceFloatMode();
    std::unique_lock lock(mutex_);
    while (!jobs_.empty() && !ends_) {
        Job job = std::move(jobs_.front());
        jobs_.pop_front();
        running_ = job.owner;
        lock.unlock();
        job.run();
        job.run = nullptr; // destroys what it holds without the lock
        lock.lock();
        running_ = unwanted_ = nullptr;
        ended_.notify_all();
    }
    hasThread_ = false;
    ended_.notify_all();
}

void GpuCodeQueue::finish(const void* owner) {
    if (isForkedChild()) // which has no thread to wait for
        return;
    std::deque<Job> removed; // destroyed without the lock
    std::unique_lock lock(mutex_);
    for (auto job = jobs_.begin(); job != jobs_.end();) {
        if (job->owner != owner) {
            ++job;
            continue;
        }
        removed.push_back(std::move(*job));
        job = jobs_.erase(job);
    }
    if (running_ == owner)
        unwanted_ = owner;
    ended_.wait(lock, [&] { return running_ != owner; });
}

bool GpuCodeQueue::isUnwanted(const void* owner) {
    std::lock_guard lock(mutex_);
    return ends_ || unwanted_ == owner;
}

void GpuCodeQueue::end() {
    if (isForkedChild())
        return;
    std::unique_lock lock(mutex_);
    ends_ = true;
    ended_.wait(lock, [&] { return !hasThread_; });
}

} // namespace sunstone::engine
