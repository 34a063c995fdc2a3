// SPDX-License-Identifier: Apache-2.0
// Timing for programs that check kernels against the same work in C++. Given a factor for their
// size (PROGRAM 16), they print both times on stderr. Times are processor time of all threads, so
// that a ratio does not depend on the number of cores.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <ctime>

class Clock {
public:
    Clock(int argc, char** argv) : factor_(argc > 1 ? std::atoi(argv[1]) : 0) {}

    int factor() const { return factor_ > 0 ? factor_ : 1; }
    void start() { begin_ = now(); }
    void kernels() { kernels_ = now() - begin_; }
    void host(const char* what) {
        const double host = now() - begin_;
        if (factor_ > 0)
            std::fprintf(stderr, "%-24s kernels %9.3f ms, C++ %9.3f ms, ratio %.2f\n", what,
                         kernels_, host, host / kernels_);
    }

private:
    static double now() {
        timespec time;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
        return double(time.tv_sec) * 1e3 + double(time.tv_nsec) * 1e-6;
    }
    const int factor_;
    double begin_ = 0, kernels_ = 0;
};
