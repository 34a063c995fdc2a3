// SPDX-License-Identifier: Apache-2.0
// Time from PTX text to a pipeline that can be launched: module, program groups, pipeline. Each
// round compiles another text (they differ in a comment), the same ones in each process: a later
// process finds the texts of the first in OptiX's disk cache. The driver has a cache below that;
// CUDA_CACHE_DISABLE=1 in the environment turns it off for cold rounds.
#include "benches.h"

#include <algorithm>
#include <chrono>
#include <string_view>

std::string_view path_tracer_ptx();

namespace bench {
namespace {

double compileOnce(OptixDeviceContext context, unsigned round) {
    // The comment follows the last brace, so that line numbers do not change.
    const std::string text =
        std::string(path_tracer_ptx()) + "\n// round " + std::to_string(round) + "\n";
    const auto start = std::chrono::steady_clock::now();
    Program program(context, text, 4, 2, OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);
    program.addRaygen("__raygen__paths");
    program.addMiss("__miss__radiance");
    program.addMiss("__miss__shadow");
    program.addHitgroup("__closesthit__mesh", nullptr, nullptr);
    program.link(1);
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

} // namespace

void benchCompile(OptixDeviceContext context, const std::string& name, const Settings& settings,
                  Measurements& measurements) {
    if (!settings.cache.empty())
        OPTIX_CHECK(optixDeviceContextSetCacheLocation(context, settings.cache.c_str()));
    OPTIX_CHECK(optixDeviceContextSetCacheEnabled(context, !settings.cache.empty()));
    constexpr unsigned kRounds = 5;
    std::vector<double> times;
    for (unsigned round = 0; round <= kRounds; ++round)
        times.push_back(compileOnce(context, round));
    measurements.add("path tracer", name + ", first in process", times[0], "ms");
    std::nth_element(times.begin() + 1, times.begin() + 1 + kRounds / 2, times.end());
    measurements.add("path tracer", name, times[1 + kRounds / 2], "ms");
}

} // namespace bench
