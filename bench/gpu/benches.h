// SPDX-License-Identifier: Apache-2.0
// The parts of bench_gpu. Each adds its results to the measurements.
#pragma once

#include "measurements.h"
#include "optix_setup.h"

#include <string>
#include <vector>

namespace bench {

struct Settings {
    std::string hits; // prefix of files that carry results from the first library to the second
    std::string json; // file for the measurements; empty: none
    std::string label = "sunstone";
    std::string cache; // folder of OptiX's disk cache, for compile times
    double scale = 1;  // of the number of primitives
    unsigned width = 1920, height = 1080, repeats = 10;
};

// Builds a scene with every preference, then traces rays through it.
void benchWorld(OptixDeviceContext context, const std::string& name, const Settings& settings,
                Measurements& measurements);
// Frames of the samples' path tracer.
void benchPathTracer(OptixDeviceContext context, const Settings& settings,
                     Measurements& measurements);
// Frames of a ray tracer whose closest-hit programs trace.
void benchRecursion(OptixDeviceContext context, const Settings& settings,
                    Measurements& measurements);
// Time from PTX to pipeline. `name` is "compile cold" or "compile cached"; the content of the cache
// folder decides which of the two is measured.
void benchCompile(OptixDeviceContext context, const std::string& name, const Settings& settings,
                  Measurements& measurements);

// The first context of this process and its first structures: triangles, or instances with motion.
// `name`: "cold" or
// "cached".
void benchFirstBuild(const std::string& name, bool moves, const Settings& settings,
                     Measurements& measurements);

// Kinds of denoisers at several sizes.
void benchDenoiser(OptixDeviceContext context, const Settings& settings,
                   Measurements& measurements);
// Compares denoised pictures with those of the first run bit for bit, for two runs of Sunstone, on
// a CPU and on a GPU.
void compareDenoisers(OptixDeviceContext context, const Settings& settings,
                      Measurements& measurements);

// Exchanges an array between the first and the second library through a file. Returns whether the
// file existed; if not, writes `mine`.
bool exchange(const Settings& settings, const std::string& name, void* mine, size_t size,
              void* theirs);

// The difference of a picture, four floats a pixel, from the first library's.
void comparePictures(const Settings& settings, const std::string& name, std::vector<float> image,
                     Measurements& measurements, const std::string& scene);

} // namespace bench
