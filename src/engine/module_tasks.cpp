// SPDX-License-Identifier: Apache-2.0
#include "engine/module_tasks.h"

#include "base/error.h"

#include <algorithm>

namespace sunstone::engine {

namespace {

// All forms that a pipeline may request: a program is compiled once per supported payload type.
std::vector<compiler::ProgramRequest> requestsOf(const Module& module) {
    std::vector<compiler::ProgramRequest> requests;
    for (const auto& program : module.summary.programs) {
        compiler::ProgramRequest request{module.source,
                                         program.name,
                                         program.kind,
                                         module.optLevel,
                                         module.debugLevel,
                                         module.moduleRules,
                                         -1,
                                         module.prepared,
                                         module.summary.selfContained};
        const size_t types = module.moduleRules->payloadTypes.size();
        bool typed = false;
        for (size_t type = 0; type < types; ++type) {
            if (!(program.payloadTypes >> type & 1))
                continue;
            typed = true;
            request.payloadType = int(type);
            requests.push_back(request);
        }
        if (!typed)
            requests.push_back(request);
    }
    return requests;
}

// The heaviest first, each to the lightest part so far.
std::vector<std::vector<compiler::ProgramRequest>>
share(const Module& module, std::vector<compiler::ProgramRequest> requests, size_t parts) {
    const auto weightOf = [&](const compiler::ProgramRequest& request) {
        return size_t(module.findProgram(request.function)->statements) + 1;
    };
    std::sort(requests.begin(), requests.end(), [&](const auto& a, const auto& b) {
        return std::make_pair(weightOf(b), a.function) < std::make_pair(weightOf(a), b.function);
    });
    std::vector<std::vector<compiler::ProgramRequest>> result(parts);
    std::vector<size_t> weights(parts);
    for (const auto& request : requests) {
        const auto part = size_t(std::min_element(weights.begin(), weights.end()) - weights.begin());
        weights[part] += weightOf(request);
        result[part].push_back(request);
    }
    return result;
}

} // namespace

ModuleTasks::ModuleTasks(Make make) : make_(std::move(make)), tasks_(1) {}

void ModuleTasks::start(size_t number) {
    std::lock_guard lock(mutex_);
    SUNSTONE_CHECK(number < tasks_.size());
    Task& task = tasks_[number];
    if (task.phase != Phase::kWaiting)
        fail(Code::kInvalidOperation, "the task ",
             task.phase == Phase::kRunning ? "is being executed" : "has been executed");
    task.phase = Phase::kRunning;
    started_ = true;
}

std::vector<size_t> ModuleTasks::run(size_t number, size_t most) {
    if (number == kFirst)
        return runFirst(most);
    std::vector<compiler::ProgramRequest> programs;
    {
        std::lock_guard lock(mutex_);
        programs = std::move(tasks_[number].programs);
    }
    for (const auto& program : programs)
        compiler::precompile(program, module_->rules);
    return {};
}

std::vector<size_t> ModuleTasks::runFirst(size_t most) {
    std::string feedback;
    std::shared_ptr<Module> module = make_(feedback);
    make_ = nullptr; // releases the text
    std::vector<compiler::ProgramRequest> requests;
    if (module->forCpu && module->summary.selfContained)
        requests = requestsOf(*module);
    {
        std::lock_guard lock(mutex_);
        module_ = module;
        notes_ += feedback;
    }
    if (most == 0 || requests.size() < 2) {
        for (const auto& request : requests)
            compiler::precompile(request, module->rules);
        return {};
    }
    std::vector<size_t> created;
    const size_t parts = std::min(most, requests.size());
    std::lock_guard lock(mutex_);
    for (auto& part : share(*module, std::move(requests), parts)) {
        created.push_back(tasks_.size());
        tasks_.push_back({Phase::kWaiting, std::move(part)});
    }
    return created;
}

void ModuleTasks::finish(size_t number, bool good) {
    std::lock_guard lock(mutex_);
    tasks_[number].phase = Phase::kDone;
    failed_ |= !good;
}

TaskState ModuleTasks::state() const {
    std::lock_guard lock(mutex_);
    if (!started_)
        return TaskState::kNotStarted;
    const bool done = std::all_of(tasks_.begin(), tasks_.end(),
                                  [](const Task& task) { return task.phase == Phase::kDone; });
    if (failed_)
        return done ? TaskState::kFailed : TaskState::kImpendingFailure;
    return done ? TaskState::kCompleted : TaskState::kStarted;
}

bool ModuleTasks::isExecuting() const {
    std::lock_guard lock(mutex_);
    return std::any_of(tasks_.begin(), tasks_.end(),
                       [](const Task& task) { return task.phase == Phase::kRunning; });
}

std::shared_ptr<Module> ModuleTasks::module() const {
    const bool completed = state() == TaskState::kCompleted;
    std::lock_guard lock(mutex_);
    return completed ? module_ : nullptr;
}

std::string ModuleTasks::feedback() const {
    std::lock_guard lock(mutex_);
    return errors_ + notes_;
}

void ModuleTasks::addError(const std::string& line) {
    std::lock_guard lock(mutex_);
    errors_ += line;
}

} // namespace sunstone::engine
