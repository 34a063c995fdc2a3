// SPDX-License-Identifier: Apache-2.0
// A program of NVRTC: its texts, name expressions and results.
#pragma once

#include "api/nvrtc/compiler.h"
#include "api/nvrtc/options.h"

#include <map>
#include <mutex>
#include <nvrtc.h>
#include <string>
#include <vector>

namespace sunstone::nvrtc {

struct Header {
    std::string name, text;
};

class Program {
public:
    Program(std::string source, std::string name, std::vector<Header> headers)
        : source_(std::move(source)), name_(std::move(name)), headers_(std::move(headers)) {}

    nvrtcResult compile(const std::vector<std::string>& words, int defaultArchitecture);
    nvrtcResult addName(const std::string& expression);
    nvrtcResult loweredName(const std::string& expression, const char** name);

    // Copies of results. The image of a real architecture is PTX, which cuModuleLoadData loads.
    std::string log();
    std::string ptx();
    std::string image();

private:
    nvrtcResult run(const Options& options);
    ChildResult runClang(const Options& options, const std::vector<std::string>& folders,
                         const std::string& source, const std::string& output) const;
    bool takeNames();

    std::mutex mutex_;
    std::string source_, name_;
    std::vector<Header> headers_;
    std::vector<std::string> expressions_;
    std::map<std::string, std::string> lowered_;
    std::string log_, ptx_, image_;
    bool isCompiled_ = false; // once successfully
};

} // namespace sunstone::nvrtc
