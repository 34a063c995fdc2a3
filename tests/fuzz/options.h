// SPDX-License-Identifier: Apache-2.0
// The command lines of fuzzers: options that take a number, and further arguments.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace fuzz {

using Numbers = std::map<std::string, uint64_t*>;

// Reads the options; exits with the usage on request, for an unknown option, or for one without its
// number. Other arguments go to `rest`; without `rest` they, too, are unknown options.
inline void readOptions(int argc, char** argv, const char* usage, const Numbers& numbers,
                        std::vector<std::string>* rest = nullptr) {
    const auto leave = [&](FILE* to, int status) {
        std::fprintf(to, "usage: %s\n", usage);
        std::exit(status);
    };
    for (int i = 1; i < argc; ++i) {
        const std::string name = argv[i];
        const auto option = numbers.find(name);
        char* end = nullptr;
        if (name == "--help" || name == "-h")
            leave(stdout, 0);
        if (option != numbers.end() && i + 1 < argc) {
            *option->second = std::strtoull(argv[++i], &end, 0);
            if (end == argv[i] || *end != '\0')
                leave(stderr, 2);
        } else if (rest && option == numbers.end()) {
            rest->push_back(name);
        } else {
            leave(stderr, 2);
        }
    }
}

} // namespace fuzz
