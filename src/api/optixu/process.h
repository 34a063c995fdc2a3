// SPDX-License-Identifier: Apache-2.0
// A program that runs to its end.
#pragma once

#include <string>
#include <vector>

namespace sunstone::optixu {

struct Outcome {
    bool started = false; // false: there is no such program
    int status = -1;      // what it returned; -1 after a signal
    std::string output;   // its stdout
    std::string errors;   // its stderr
};

// The program is looked for in PATH. Its stdin is `input`. No shell reads the arguments.
Outcome runProcess(const std::vector<std::string>& arguments, const std::string& input);

} // namespace sunstone::optixu
