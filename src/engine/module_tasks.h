// SPDX-License-Identifier: Apache-2.0
// A module made by tasks (OptiX 7.4, sections 3.6.2.3 and 3.7). The first task parses and checks.
// Then as many tasks as the caller takes make the machine code of the module's programs, or the
// first task if it takes none. The module keeps the code for the pipelines that use it. A module
// that needs others, or one for a GPU, cannot be compiled ahead: it has only the first task.
#pragma once

#include "engine/module.h"

#include <mutex>
#include <vector>

namespace sunstone::engine {

enum class TaskState : uint8_t { kNotStarted, kStarted, kImpendingFailure, kFailed, kCompleted };

class ModuleTasks {
public:
    // make: does the work of the first task; parses and checks.
    using Make = std::function<std::shared_ptr<Module>(std::string& feedback)>;
    explicit ModuleTasks(Make make);

    static constexpr size_t kFirst = 0;

    // Executing a task takes three calls, so that the caller can deliver the task's messages before
    // the module counts as done. start throws kInvalidOperation if the task has run or runs; run
    // does the work on this thread, returns the numbers of up to `most` new tasks and passes
    // exceptions on; finish must follow.
    void start(size_t number);
    std::vector<size_t> run(size_t number, size_t most);
    void finish(size_t number, bool good);

    TaskState state() const;
    bool isExecuting() const; // some task
    // Once completed; null before.
    std::shared_ptr<Module> module() const;
    // Messages of finished tasks, errors first.
    std::string feedback() const;
    void addError(const std::string& line);

private:
    enum class Phase : uint8_t { kWaiting, kRunning, kDone };
    struct Task {
        Phase phase = Phase::kWaiting;
        std::vector<compiler::ProgramRequest> programs;
    };

    std::vector<size_t> runFirst(size_t most);

    Make make_;
    mutable std::mutex mutex_;
    std::vector<Task> tasks_;
    std::shared_ptr<Module> module_;
    std::string errors_, notes_;
    bool started_ = false, failed_ = false;
};

} // namespace sunstone::engine
