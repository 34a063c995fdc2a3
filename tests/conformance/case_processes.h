// SPDX-License-Identifier: Apache-2.0
// Runs cases in separate processes: if a case ends its process, another one continues after it.
#pragma once

#include "driver.h"
#include "forms/run_forms.h"

#include <functional>
#include <string>
#include <vector>

namespace conformance {

// Allocates zeroed memory that processes forked later share. Ends the process if there is none.
void* shareMemory(size_t bytes);
template <class T>
T* share(size_t count) {
    return static_cast<T*>(shareMemory(count * sizeof(T)));
}

struct CaseOutcomes {
    std::string device;
    std::vector<Status> status; // by case
};

// Called once in each process; returns a function that runs a case and returns whether the driver
// accepted it. Its results must be in shared memory.
using CaseSetup = std::function<std::function<bool(size_t)>(const Driver&)>;

// Runs the cases `names`, in `workers` processes at a time. Cases without `only` in their names
// stay pending. Ends the process if there is no device; `what` names the purpose for the message.
CaseOutcomes runCases(const std::vector<std::string>& names, const std::string& only,
                      unsigned workers, const char* what, const CaseSetup& setup);

} // namespace conformance
