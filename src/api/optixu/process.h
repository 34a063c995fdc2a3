// SPDX-License-Identifier: Apache-2.0
// Runs a program until it ends.
#pragma once

#include <string>
#include <vector>

namespace sunstone::optixu {

struct Outcome {
    bool started = false; // false: there is no such program
    int status = -1;      // exit code; -1 after a signal
    std::string output;   // its stdout
    std::string errors;   // its stderr
};

// Searches the program in PATH. Its stdin is `input`. No shell reads the arguments.
Outcome runProcess(const std::vector<std::string>& arguments, const std::string& input);

} // namespace sunstone::optixu
