// SPDX-License-Identifier: Apache-2.0
// What the log says about a launch. The record of exceptions of its device programs keeps the one
// at the lowest launch index, so that reports are the same in every run.
#pragma once

#include "base/faults.h"
#include "base/log.h"
#include "devlib/launch_notes.h"
#include "engine/wording.h"

#include <atomic>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::engine {

// One line about an exception: its name and known details. `instruction`: the one that raised it,
// or null if unknown.
std::string describeException(const devlib::ThreadState& thread, const Wording& wording,
                              const void* instruction = nullptr);

// A line for the log.
struct LaunchRemark {
    LogLevel level;
    std::string text;
};

// The lines about a launch that did not fail: what it ignored or left out. `launch`: for its SBT
// and limits. Where programs did not run the picture is wrong, and the line is an error.
std::vector<LaunchRemark> remarksOf(const devlib::LaunchNotes& notes,
                                    const devlib::LaunchState& launch, const Wording& wording);

// Lowest address that frames of the calling thread may reach, with room left for functions of the
// run-time that do not check.
uint64_t stackLimitOfThread();

class ExceptionRecord {
public:
    explicit ExceptionRecord(const Wording& wording) : wording_(wording) {}

    // Called once for each launch index that ended with an exception, raised by `instruction`.
    void add(const devlib::ThreadState& thread, const devlib::LaunchState& launch,
             const void* instruction);
    // The same for an index that ended with a fault of the processor.
    void add(const FaultFrame& fault, const devlib::ThreadState& thread,
             const devlib::LaunchState& launch);

    bool any() const { return any_; }
    const std::string& text() const { return text_; }

private:
    template <class Describe>
    void addWith(Describe describe, const devlib::ThreadState& thread,
                 const devlib::LaunchState& launch);

    const Wording& wording_;
    std::atomic<bool> any_{false};
    std::atomic<uint64_t> lowest_{~uint64_t(0)};
    std::mutex mutex_;
    std::string text_; // of the lowest index
};

} // namespace sunstone::engine
