// SPDX-License-Identifier: Apache-2.0
// The differential suite: one client program with its PTX runs the same cases on any OptiX library
// and records the values that its programs see; answers of two libraries are compared. The loader's
// choice of libnvoptix decides which library answers.
//   differential list
//   differential record FILE [CASE...]       FILE.zst is compressed
//   differential join FILE PART...           puts several files into one
//   differential compare REFERENCE OURS DIFFERENCES [NOT_YET]
//   differential replay REFERENCE DIFFERENCES [NOT_YET [CASE...]]
//                                            records, and compares with another library's answers
// DIFFERENCES lists the known differences, NOT_YET names cases that may fail ("differential.CASE").
// Exit code 1: other differences.
#include "compare.h"
#include "lab.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace {

using namespace differential;

std::vector<Answer> record(const std::vector<std::string>& names) {
    std::vector<Answer> answers;
    const Lab lab;
    for (const Case& one : allCases()) {
        if (std::find(names.begin(), names.end(), one.name) == names.end())
            continue;
        Answer answer{one.name, "ok", {}, {}};
        try {
            one.run(lab, answer);
        } catch (const std::exception& error) {
            answer = {one.name, error.what(), {}, {}};
        }
        answers.push_back(std::move(answer));
    }
    return answers;
}

std::vector<std::string> caseNames() {
    std::vector<std::string> names;
    for (const Case& one : allCases())
        names.push_back(one.name);
    return names;
}

std::set<std::string> readNames(const std::string& path) {
    std::set<std::string> names;
    std::ifstream file(path);
    if (!file)
        throw std::runtime_error("cannot read " + path);
    for (std::string line; std::getline(file, line);)
        names.insert(line.substr(0, line.find(' ')));
    return names;
}

// Cases given by name; all of them if there are none.
std::vector<std::string> chosen(const std::vector<std::string>& words, size_t first) {
    const std::vector<std::string> all = caseNames();
    std::vector<std::string> names;
    for (size_t i = first; i < words.size(); ++i) {
        if (std::find(all.begin(), all.end(), words[i]) == all.end())
            throw std::runtime_error("there is no case '" + words[i] + "'");
        names.push_back(words[i]);
    }
    return names.empty() ? all : names;
}

int run(const std::vector<std::string>& words) {
    const auto missing = [&](size_t i) {
        return words.size() > i ? readNames(words[i]) : std::set<std::string>();
    };
    if (words.size() == 1 && words[0] == "list") {
        for (const Case& one : allCases())
            std::printf("%s\n", one.name);
        return 0;
    }
    if (words.size() >= 2 && words[0] == "record") {
        write(words[1], record(chosen(words, 2)));
        return 0;
    }
    if (words.size() >= 3 && words[0] == "join") {
        std::vector<Answer> all;
        for (size_t i = 2; i < words.size(); ++i)
            for (Answer& answer : read(words[i]))
                all.push_back(std::move(answer));
        write(words[1], all);
        return 0;
    }
    if ((words.size() == 4 || words.size() == 5) && words[0] == "compare")
        return compare(caseNames(), caseNames(), read(words[1]), read(words[2]), words[3],
                       missing(4))
                   ? 0
                   : 1;
    if (words.size() >= 3 && words[0] == "replay") {
        const std::vector<std::string> names = chosen(words, 4);
        return compare(names, caseNames(), read(words[1]), record(names), words[2], missing(3)) ? 0
                                                                                                : 1;
    }
    std::fprintf(stderr,
                 "usage: differential list | record FILE [CASE...] | join FILE PART... | "
                 "compare REFERENCE OURS "
                 "DIFFERENCES [NOT_YET] | replay REFERENCE DIFFERENCES [NOT_YET [CASE...]]\n");
    return 2;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return run({argv + 1, argv + argc});
    } catch (const std::exception& error) {
        std::fprintf(stderr, "differential: %s\n", error.what());
        return 2;
    }
}
