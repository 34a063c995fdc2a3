// SPDX-License-Identifier: Apache-2.0
// Runs forms on the device in separate processes: a form that a compiler refuses, or that ends a
// process or its context, does not affect the results of other forms.
#pragma once

#include "forms/forms.h"

#include <cstdint>
#include <string>
#include <vector>

namespace conformance {

enum class Status : uint8_t { kPending, kDone, kRefused, kCrashed };

struct Results {
    std::vector<Status> status;                // by form
    std::vector<std::vector<uint8_t>> results; // by form; empty unless done
    std::string device;
};

// Runs the forms with these numbers on `workers` processes (0: as many as there are processors).
Results runForms(const std::vector<Form>& forms, const std::vector<size_t>& numbers,
                 unsigned workers);

} // namespace conformance
