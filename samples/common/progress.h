// SPDX-License-Identifier: Apache-2.0
// Progress on stderr: a bar with the time left on a terminal, one line every ten percent elsewhere.
#pragma once

#include <chrono>
#include <string>

class Progress {
public:
    // Counts from 0 to `total` (at least 1); `label` precedes the bar.
    Progress(std::string label, unsigned total);
    void update(unsigned done);
    double seconds() const; // since construction

private:
    void drawBar(unsigned done);

    std::string label_;
    unsigned total_;
    unsigned printedTenths_ = 0;
    bool terminal_;
    std::chrono::steady_clock::time_point start_;
};
