// SPDX-License-Identifier: Apache-2.0
// Compilations of pipelines while launches use code that was ready (ready_code.h): one after the
// other, in a thread of the process.
#pragma once

#include "compiler/gpu/pipeline.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>

namespace sunstone::engine {

// Code that the queue's thread compiles. After `isReady` the thread does not change `code`, whose
// machine code is empty if compilation has failed.
struct GpuLaterCode {
    std::atomic<bool> isReady = false;
    compiler::GpuCode code;
};

// Returns when the code is ready, or after three seconds: a pipeline may wait for the compilation
// of others.
void waitFor(const GpuLaterCode& later);

class GpuCodeQueue {
public:
    GpuCodeQueue() = default;
    ~GpuCodeQueue() { end(); }
    GpuCodeQueue(const GpuCodeQueue&) = delete;
    // The job must not throw.
    void add(const void* owner, std::function<void()> job);
    // Removes the owner's jobs that have not begun, and waits for one that has.
    void finish(const void* owner);
    // Whether a thread waits for the owner's job to end, so that the job need not complete.
    bool isUnwanted(const void* owner);
    // Ends the thread when the process ends.
    void end();

private:
    struct Job {
        const void* owner = nullptr;
        std::function<void()> run;
    };
    void run();

    std::mutex mutex_;
    std::condition_variable ended_;
    std::deque<Job> jobs_;
    const void* running_ = nullptr;  // owner of the job that the thread runs
    const void* unwanted_ = nullptr; // the same, while finish() waits for it
    bool hasThread_ = false;         // it ends when there are no jobs
    bool ends_ = false;              // the process ends
};

} // namespace sunstone::engine
