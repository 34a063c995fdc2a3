// SPDX-License-Identifier: Apache-2.0
// Steps shared by the compilation of pipelines and of kernels.
#pragma once

#include "base/log.h"
#include "compiler/machine.h"
#include "compiler/translate/unit.h"

#include <chrono>

namespace sunstone::compiler {

// One line per compilation with the time of each step, at level debug.
class StepTimes {
public:
    explicit StepTimes(std::string what) : text_(std::move(what)) {}
    void step(const char* name);
    ~StepTimes();

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point last_ = Clock::now();
    std::string text_;
};

// Throws kInternal with the name of the step if the IR is invalid, which is a defect of the
// compiler.
void verify(Unit& unit, const char* step);

// Sets the unit's data layout and triple to those of the target machine.
void prepare(Unit& unit, LentMachine& machine);

// Module-scope variables by name. Of several private variables with one name, the first counts.
class VariableTable {
public:
    void add(const std::vector<const ptx::Module*>& modules, const VariableId& id, void* address);
    bool find(std::string_view name, void** address, uint64_t* size) const;

private:
    struct Entry {
        void* address = nullptr;
        uint64_t size = 0;
    };
    std::map<std::string, Entry, std::less<>> entries_;
};

} // namespace sunstone::compiler
