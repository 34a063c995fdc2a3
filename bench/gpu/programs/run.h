// SPDX-License-Identifier: Apache-2.0
// Running the programs of bench_programs and comparing two libraries; main.cpp has the command
// line.
#pragma once

#include "job.h"

#include <string>
#include <vector>

namespace bench {

struct RunSettings {
    JobSettings job;
    std::string out;                                 // folder of results
    std::string label = "sunstone";                  // whose they are
    std::string phase = "warm";                      // "cold": caches are empty
    std::vector<std::string> names;                  // empty: all of the set
    std::string set = "first";                       // first, second, third, fourth, fifth or all
    unsigned repeats = 5, seconds = 600, limit = 60; // of all programs; of one process
    long long started = 0; // CLOCK_MONOTONIC in ns at the start of the process; 0: unknown
};

const JobKind& jobNamed(const std::string& name);

// Runs in this process: builds, compiles, renders, and writes OUT/NAME.LABEL.PHASE.json and, in the
// phase "warm", the picture.
void runJob(const JobKind& kind, const RunSettings& settings);
// Runs each job in two processes of `program`, the first with empty caches. Returns the number of
// failures.
int runAll(const char* program, const RunSettings& settings);
// The table of two labels' results in a folder, and OUT/report.json. Returns the number of programs
// that failed or whose pictures differ too much.
int reportRuns(const std::string& out, const std::string& reference, const std::string& ours);

long long monotonicNow();
std::string resultFile(const std::string& out, const std::string& name, const std::string& label,
                       const std::string& suffix);

} // namespace bench
