// SPDX-License-Identifier: Apache-2.0
// A library's answers, case by case. A file is a series of blocks, so that files may be joined: a
// text line with the case's name, its state and the size of the data, then either rays (array of
// Seen) or text (lines of name and answer).
#pragma once

#include "programs.h"

#include <string>
#include <vector>

namespace differential {

struct Answer {
    std::string name;
    std::string state; // "ok", or why the case could not run
    std::vector<Seen> seen;
    std::string text;
};

// Both throw std::runtime_error with the path if the file cannot be used. Files that end in .zst
// are compressed.
void write(const std::string& path, const std::vector<Answer>& answers);
std::vector<Answer> read(const std::string& path);

} // namespace differential
