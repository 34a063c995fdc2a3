// SPDX-License-Identifier: Apache-2.0
// Whole programs, as applications write them, on the OptiX library that the loader finds. Measures
// compile time, time from process start to picture, and frame time, and compares the pictures of
// two libraries.
//   bench_programs --all 1 --label reference --out FOLDER  with the other library
//   bench_programs --all 1 --out FOLDER                    with Sunstone
//   bench_programs --report FOLDER                         the table; 1 if pictures differ
//   bench_programs --program paths_16                      one, in this process
// Sunstone is tuned on the first set of programs and on the second (second/list.cpp, --set second).
// The third, the fourth and the fifth set have programs of other kinds, which did not serve to tune
// Sunstone before their first run.
#include "arguments.h"
#include "run.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace {

using namespace bench;

struct Choice {
    RunSettings run;
    std::string program, report, names, scale = "1", started = "0", reference = "reference";
    unsigned all = 0;
};

std::vector<std::string> wordsOf(std::string list) {
    for (char& c : list)
        c = c == ',' ? ' ' : c;
    std::istringstream stream(list);
    std::vector<std::string> words;
    for (std::string word; stream >> word;)
        words.push_back(word);
    return words;
}

std::string programHelp() {
    std::string help = "one program, in this process:";
    for (const JobKind& kind : jobKinds())
        help += std::string(&kind == &jobKinds().front() ? " " : "; ") + kind.name + " (" +
                kind.summary + ")";
    return help;
}

int run(int argc, char** argv) {
    Choice choice;
    RunSettings& s = choice.run;
    Arguments arguments("Whole programs on the OptiX library the loader finds.");
    arguments.add("--program", choice.program, programHelp());
    arguments.add("--all", choice.all, 0, 1, "1: all programs of the set, each in two processes");
    arguments.add("--set", s.set, "with --all: first, second, third, fourth, fifth or all");
    arguments.add("--only", choice.names, "with --all: names of any set, separated by commas");
    arguments.add("--report", choice.report, "folder of results to make a table of");
    arguments.add("--reference", choice.reference, "with --report: the other label");
    arguments.add("--out", s.out, "folder of results");
    arguments.add("--label", s.label, "whose results these are");
    arguments.add("--phase", s.phase, "warm, or cold: caches are empty");
    arguments.add("--scale", choice.scale, "of numbers of primitives, above 0 to 1");
    arguments.add("--width", s.job.width, 8, 8192, "of the picture");
    arguments.add("--height", s.job.height, 8, 8192, "of the picture");
    arguments.add("--repeats", s.repeats, 0, 100, "frames after the first; the fastest counts");
    arguments.add("--seconds", s.seconds, 1, 100000, "with --all: begin no program later");
    arguments.add("--limit", s.limit, 1, 10000, "seconds of one process");
    arguments.add("--started", choice.started, "monotonic time when the process was asked for, ns");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    s.job.scale = std::stod(choice.scale);
    if (!(s.job.scale > 0 && s.job.scale <= 1))
        throw std::runtime_error("--scale " + choice.scale + " is not above 0 and at most 1");
    constexpr std::string_view kSets[] = {"first", "second", "third", "fourth", "fifth", "all"};
    if (std::find(std::begin(kSets), std::end(kSets), s.set) == std::end(kSets))
        throw std::runtime_error("--set " + s.set +
                                 " is not first, second, third, fourth, fifth or all");
    s.started = std::stoll(choice.started);
    s.names = wordsOf(choice.names);
    for (const std::string& name : s.names)
        jobNamed(name);
    if (!choice.report.empty())
        return reportRuns(choice.report, choice.reference, s.label) == 0 ? 0 : 1;
    if (choice.all == 1 && s.out.empty())
        throw std::runtime_error("--all needs --out");
    if (choice.all == 1)
        return runAll(std::filesystem::read_symlink("/proc/self/exe").c_str(), s) == 0 ? 0 : 1;
    if (choice.program.empty())
        throw std::runtime_error("--program, --all or --report is missing");
    runJob(jobNamed(choice.program), s);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("bench_programs", [&] { return run(argc, argv); });
}
