// SPDX-License-Identifier: Apache-2.0
// Time from PTX text to a pipeline that can be launched: module, program groups, pipeline. Measures
// first without the disk cache, then with it: each text is compiled and stored, then loaded. A
// comment makes the text of each round new.
#include "arguments.h"
#include "optix_setup.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>

std::string_view path_tracer_ptx();

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
    return values[values.size() / 2];
}

// Compiles the path tracer once; returns the times until the module and until the pipeline were
// complete.
void compileOnce(OptixDeviceContext context, unsigned round, std::vector<double>& moduleTimes,
                 std::vector<double>& totalTimes) {
    // The comment follows the last brace, so that line numbers do not change.
    std::string text =
        std::string(path_tracer_ptx()) + "\n// round " + std::to_string(round) + "\n";
    auto start = Clock::now();
    Program program(context, text, 4, 2, OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);
    auto module = Clock::now();
    program.addRaygen("__raygen__paths");
    program.addMiss("__miss__radiance");
    program.addMiss("__miss__shadow");
    program.addHitgroup("__closesthit__mesh", nullptr, nullptr);
    program.link(1);
    moduleTimes.push_back(milliseconds(start, module));
    totalTimes.push_back(milliseconds(start, Clock::now()));
}

int run(int argc, char** argv) {
    unsigned rounds = 9;
    Arguments arguments("Compile time: PTX to pipeline.");
    arguments.add("--rounds", rounds, 1, 1000, "how often to compile");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    OptixDeviceContext context = createContext();
    OPTIX_CHECK(optixDeviceContextSetCacheEnabled(context, 0));
    std::vector<double> moduleTimes, totalTimes;
    for (unsigned round = 0; round < rounds; ++round)
        compileOnce(context, round, moduleTimes, totalTimes);
    std::string_view text = path_tracer_ptx();
    std::printf("path tracer: %ld lines of PTX\n",
                long(std::count(text.begin(), text.end(), '\n')));
    std::printf("first in the process: module %.1f ms, module + pipeline %.1f ms\n", moduleTimes[0],
                totalTimes[0]);
    std::printf("median of %u:          module %.1f ms, module + pipeline %.1f ms\n", rounds,
                median(moduleTimes), median(totalTimes));
    for (const char* pass : {"compiled and stored", "found in the cache "}) {
        moduleTimes.clear();
        totalTimes.clear();
        const std::string folder = std::filesystem::temp_directory_path() / "sunstone_bench_cache";
        if (pass[0] == 'c')
            std::filesystem::remove_all(folder);
        OPTIX_CHECK(optixDeviceContextSetCacheLocation(context, folder.c_str()));
        OPTIX_CHECK(optixDeviceContextSetCacheEnabled(context, 1));
        for (unsigned round = 0; round < rounds; ++round)
            compileOnce(context, rounds + round, moduleTimes, totalTimes);
        std::printf("%s:   module %.1f ms, module + pipeline %.1f ms\n", pass,
                    median(moduleTimes), median(totalTimes));
    }
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("bench_compile_time", [&] { return run(argc, argv); });
}
