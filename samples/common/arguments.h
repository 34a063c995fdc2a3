// SPDX-License-Identifier: Apache-2.0
// Command-line options of the samples: `--name value`, `-o value`, `--help`.
#pragma once

#include <functional>
#include <string>
#include <vector>

class Arguments {
public:
    // `summary` is the first line of --help.
    explicit Arguments(std::string summary) : summary_(std::move(summary)) {}

    // Options write into the caller's variable. Its present value is the default that --help
    // prints. `names` is "--output" or "-o,--output".
    void add(const std::string& names, unsigned& value, unsigned low, unsigned high,
             const std::string& help);
    void add(const std::string& names, std::string& value, const std::string& help);
    // One optional argument without a name.
    void addPositional(const std::string& name, std::string& value, const std::string& help);

    enum class Result { kRun, kHelp };
    // Throws std::runtime_error that names the wrong argument. kHelp: help was printed.
    Result parse(int argc, char** argv) const;

private:
    struct Option {
        std::vector<std::string> names;
        std::string shown; // default value for --help
        std::string help;
        std::function<void(const std::string& name, const std::string& text)> set;
    };
    void printHelp(const char* program) const;
    const Option* find(const std::string& name) const;

    std::string summary_;
    std::vector<Option> options_;
    std::vector<Option> positional_; // none or one
};

// Runs a sample's body: prints an exception as one line and turns it into exit code 1.
int runSample(const char* name, const std::function<int()>& body);
