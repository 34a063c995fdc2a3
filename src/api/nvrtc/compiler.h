// SPDX-License-Identifier: Apache-2.0
// The clang that compiles programs. It runs as a separate process, so that no source can crash the
// application.
#pragma once

#include <string>
#include <vector>

namespace sunstone::nvrtc {

struct Compiler {
    std::string path;    // of clang++; empty if there is none
    std::string headers; // the folder of cuda_runtime.h
    std::string fault;   // why there is none, and the remedy
};
// The compiler of the process; the first call searches it.
const Compiler& compiler();

struct ChildResult {
    bool started = false;
    int code = 0; // the exit code, or 128 and the number of the signal
    std::string output;
};
// Runs a program with these arguments; its output and errors go through a file in `folder`.
ChildResult runChild(const std::vector<std::string>& command, const std::string& folder);

// A folder that exists as long as the object.
class TemporaryFolder {
public:
    TemporaryFolder(); // throws Error if it cannot be made
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

} // namespace sunstone::nvrtc
