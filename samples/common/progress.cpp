// SPDX-License-Identifier: Apache-2.0
#include "progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>

Progress::Progress(std::string label, unsigned total)
    : label_(std::move(label)), total_(std::max(total, 1u)), terminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {
    if (terminal_)
        drawBar(0);
}

double Progress::seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::update(unsigned done) {
    done = std::min(done, total_);
    if (terminal_) {
        drawBar(done);
        return;
    }
    unsigned tenths = unsigned(10ull * done / total_);
    if (tenths > printedTenths_) {
        printedTenths_ = tenths;
        std::fprintf(stderr, "%s %u%%\n", label_.c_str(), tenths * 10);
    }
}

void Progress::drawBar(unsigned done) {
    constexpr unsigned kWidth = 30;
    unsigned filled = unsigned(uint64_t(kWidth) * done / total_);
    std::string bar(filled, '#');
    bar.resize(kWidth, '.');
    std::fprintf(stderr, "\r%s [%s] %3u%%", label_.c_str(), bar.c_str(),
                 unsigned(100ull * done / total_));
    if (done == total_)
        std::fprintf(stderr, "  %.1f s        \n", seconds());
    else if (done > 0)
        std::fprintf(stderr, "  %.0f s left   ", seconds() * (total_ - done) / done);
    std::fflush(stderr);
}
