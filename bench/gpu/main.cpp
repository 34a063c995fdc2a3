// SPDX-License-Identifier: Apache-2.0
// Rays per second, build times, memory, frames of a path tracer, denoising, compile times and times
// of first builds on a GPU, through the OptiX API and by events on the stream. It measures the
// libnvoptix that the loader finds, so that the same binary and PTX run on Sunstone and on another
// library. The second run starts secondary rays at the hits of the first run and reports the
// differences between the hits of both; in scenes of triangles, also which side is right.
//   bench_gpu --hits /tmp/h --label reference --json ref.json     with the other library
//   bench_gpu --hits /tmp/h --json ours.json                      with Sunstone
//   bench_gpu --report "ref.json ours.json"                       the table; 1 if a bar is missed
#include "arguments.h"
#include "benches.h"
#include "world.h"

#include <optix_function_table_definition.h>

#include <cstdio>
#include <sstream>
#include <stdexcept>

namespace {

using namespace bench;

struct Choice {
    Settings settings;
    std::string scene = "all", report, scale = "1";
};

int report(const std::string& list) {
    std::istringstream words(list);
    std::vector<std::string> files;
    for (std::string file; words >> file;)
        files.push_back(file);
    return printReport(files) == 0 ? 0 : 1;
}

void measure(const Choice& choice, Measurements& measurements) {
    for (const bool moves : {false, true})
        for (const char* name : {"cold", "cached"})
            if (choice.scene == std::string(moves ? "first-motion-" : "first-build-") + name)
                return benchFirstBuild(name, moves, choice.settings, measurements);
    const OptixDeviceContext context = createContext();
    const std::string& scene = choice.scene;
    bool known = false;
    for (size_t i = 0; i < worldNames().size(); ++i)
        if (scene == "all" || scene == std::to_string(i)) {
            benchWorld(context, worldNames()[i], choice.settings, measurements);
            known = true;
        }
    if (scene == "all" || scene == "path-tracer") {
        benchPathTracer(context, choice.settings, measurements);
        known = true;
    }
    if (scene == "all" || scene == "recursion") {
        benchRecursion(context, choice.settings, measurements);
        known = true;
    }
    if (scene == "denoiser") {
        benchDenoiser(context, choice.settings, measurements);
        known = true;
    }
    if (scene == "denoiser-bits") {
        compareDenoisers(context, choice.settings, measurements);
        known = true;
    }
    if (scene == "compile-cold" || scene == "compile-cached") {
        benchCompile(context, scene == "compile-cold" ? "compile, cold" : "compile, cached",
                     choice.settings, measurements);
        known = true;
    }
    if (!known)
        throw std::runtime_error("there is no scene '" + scene + "' (see --help)");
    OPTIX_CHECK(optixDeviceContextDestroy(context));
}

std::string sceneHelp() {
    std::string help =
        "all; path-tracer; recursion; denoiser; denoiser-bits; compile-cold; compile-cached; "
        "first-build-cold; first-build-cached; first-motion-cold; first-motion-cached; or a "
        "number:";
    for (size_t i = 0; i < worldNames().size(); ++i)
        help += (i == 0 ? " " : ", ") + std::to_string(i) + " " + worldNames()[i];
    return help;
}

int run(int argc, char** argv) {
    Choice choice;
    Settings& s = choice.settings;
    Arguments arguments(
        "Rays, builds, frames, denoising and compile times of the OptiX library the loader finds.");
    arguments.add("--scene", choice.scene, sceneHelp());
    arguments.add("--hits", s.hits,
                  "prefix of files that carry hits from the first run to the second");
    arguments.add("--label", s.label, "whose numbers these are: reference or sunstone");
    arguments.add("--json", s.json, "file for the measurements");
    arguments.add("--report", choice.report, "files of measurements to make a table of");
    arguments.add("--cache", s.cache,
                  "folder of the disk cache, for compile times; none: no cache");
    arguments.add("--scale", choice.scale, "of the number of primitives, above 0 to 1");
    arguments.add("--width", s.width, 8, 8192, "camera rays across");
    arguments.add("--height", s.height, 8, 8192, "camera rays down");
    arguments.add("--repeats", s.repeats, 1, 100, "how often to launch");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    if (!choice.report.empty())
        return report(choice.report);
    s.scale = std::stod(choice.scale);
    if (!(s.scale > 0 && s.scale <= 1))
        throw std::runtime_error("--scale " + choice.scale + " is not above 0 and at most 1");
    if (s.hits.empty() && choice.scene.rfind("compile", 0) != 0 &&
        choice.scene.rfind("first-", 0) != 0 && choice.scene != "denoiser")
        throw std::runtime_error("--hits is missing");
    Measurements measurements(s.label);
    measure(choice, measurements);
    if (!s.json.empty())
        measurements.write(s.json);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("bench_gpu", [&] { return run(argc, argv); });
}
