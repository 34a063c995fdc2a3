// SPDX-License-Identifier: Apache-2.0
#include "arguments.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

namespace {

std::vector<std::string> splitNames(const std::string& names) {
    std::vector<std::string> list;
    std::istringstream stream(names);
    for (std::string name; std::getline(stream, name, ',');)
        list.push_back(name);
    return list;
}

unsigned parseUnsigned(const std::string& name, const std::string& text, unsigned low,
                       unsigned high) {
    errno = 0;
    char* end = nullptr;
    unsigned long value = std::strtoul(text.c_str(), &end, 10);
    bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
    if (!digits || *end != 0 || errno != 0 || value < low || value > high)
        throw std::runtime_error(name + " " + text + ": expected a whole number from " +
                                 std::to_string(low) + " to " + std::to_string(high));
    return unsigned(value);
}

} // namespace

void Arguments::add(const std::string& names, unsigned& value, unsigned low, unsigned high,
                    const std::string& help) {
    options_.push_back({splitNames(names), std::to_string(value), help,
                        [&value, low, high](const std::string& name, const std::string& text) {
                            value = parseUnsigned(name, text, low, high);
                        }});
}

void Arguments::add(const std::string& names, std::string& value, const std::string& help) {
    options_.push_back({splitNames(names), value, help,
                        [&value](const std::string&, const std::string& text) { value = text; }});
}

void Arguments::addPositional(const std::string& name, std::string& value,
                              const std::string& help) {
    positional_.push_back(
        {{name}, value, help, [&value](const std::string&, const std::string& text) {
             value = text;
         }});
}

const Arguments::Option* Arguments::find(const std::string& name) const {
    for (const Option& option : options_)
        if (std::find(option.names.begin(), option.names.end(), name) != option.names.end())
            return &option;
    return nullptr;
}

Arguments::Result Arguments::parse(int argc, char** argv) const {
    size_t positionals = 0;
    for (int i = 1; i < argc; ++i) {
        std::string name = argv[i];
        if (name == "--help" || name == "-h") {
            printHelp(argv[0]);
            return Result::kHelp;
        }
        std::string value;
        size_t equals = name.rfind("--", 0) == 0 ? name.find('=') : std::string::npos;
        bool joined = equals != std::string::npos;
        if (joined) {
            value = name.substr(equals + 1);
            name.resize(equals);
        }
        if (const Option* option = find(name)) {
            if (!joined) {
                if (i + 1 >= argc)
                    throw std::runtime_error(name + " needs a value (see --help)");
                value = argv[++i];
            }
            option->set(name, value);
        } else if (name.rfind("-", 0) != 0 && positionals < positional_.size()) {
            positional_[positionals++].set(name, name);
        } else {
            throw std::runtime_error("unknown argument " + name + " (see --help)");
        }
    }
    return Result::kRun;
}

void Arguments::printHelp(const char* program) const {
    std::printf("%s\n\nUsage: %s [options]", summary_.c_str(), program);
    for (const Option& option : positional_)
        std::printf(" [%s]", option.names[0].c_str());
    std::printf("\n\n");
    for (const Option& option : positional_)
        std::printf("  %-22s %s\n", option.names[0].c_str(), option.help.c_str());
    for (const Option& option : options_) {
        std::string names;
        for (const std::string& name : option.names)
            names += (names.empty() ? "" : ", ") + name;
        std::printf("  %-22s %s (default: %s)\n", (names + " VALUE").c_str(), option.help.c_str(),
                    option.shown.c_str());
    }
    std::printf("  %-22s %s\n", "-h, --help", "show this text");
}

int runSample(const char* name, const std::function<int()>& body) {
    try {
        return body();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", name, error.what());
        return 1;
    }
}
