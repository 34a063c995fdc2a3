// SPDX-License-Identifier: Apache-2.0
// Frames of the samples' path tracer: a generated knot of a million triangles, eight samples a
// pixel.
#include "path_tracer.h"
#include "benches.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace bench {
namespace {

double milliseconds(PathTracer& tracer, unsigned samples) {
    tracer.restart();
    const auto start = std::chrono::steady_clock::now();
    tracer.addSamples(samples);
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

} // namespace

void benchPathTracer(OptixDeviceContext context, const Settings& settings,
                     Measurements& measurements) {
    constexpr unsigned kSamples = 8;
    HostScene scene = makeKnot(unsigned(std::max(1000.0, 1e6 * settings.scale)));
    const Bounds bounds = boundsOf(scene);
    addGround(scene, bounds, bounds.low.y, {vec(0.36f, 0.35f, 0.34f), 0.5f, vec(0.0f), 0.0f});
    Scene studio = makeStudio(bounds);
    studio.maxSegments = 4;
    const Camera camera =
        orbitCamera(bounds, 38.0f, 24.0f, 1.0f, float(settings.width) / float(settings.height));
    PathTracer tracer(context, scene, studio, camera, settings.width, settings.height);
    milliseconds(tracer, 1);
    double best = INFINITY;
    for (unsigned i = 0; i < settings.repeats; ++i)
        best = std::min(best, milliseconds(tracer, kSamples));
    measurements.add("path tracer 1 M", "frame of 8 samples", best, "ms/frame");

    comparePictures(settings, "path_tracer", tracer.image(), measurements, "path tracer 1 M");
}

void comparePictures(const Settings& settings, const std::string& name, std::vector<float> image,
                     Measurements& measurements, const std::string& scene) {
    std::vector<float> known(image.size());
    if (!exchange(settings, name, image.data(), image.size() * sizeof(float), known.data()))
        return;
    double difference = 0, sum = 0;
    for (size_t i = 0; i < image.size(); ++i) {
        if (i % 4 == 3)
            continue;
        difference += std::fabs(double(image[i]) - double(known[i]));
        sum += std::fabs(double(known[i]));
    }
    if (difference > 0)
        measurements.addDifferences(scene, "picture",
                                    {{"mean difference over mean", difference / sum}});
}

} // namespace bench
