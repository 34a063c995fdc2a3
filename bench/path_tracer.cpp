// SPDX-License-Identifier: Apache-2.0
// A whole path tracer: OptiX programs through optixLaunch against the same mathematics in C++ over
// Embree, on the same scene, camera and samples. Frames alternate between the two, so that other
// load disturbs both equally. The benchmark compares medians and images. Run with `sunstone run`,
// or directly from the build tree.
#include "path_tracer.h"
#include "arguments.h"
#include "embree_tracer.h"
#include "model/model.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>

namespace {

struct Options {
    std::string model;
    unsigned width = 960, height = 540, samples = 4, frames = 7, triangles = 1000000;
};

HostScene loadScene(const Options& options) {
    if (options.model.empty())
        return makeKnot(options.triangles);
    model::Model source = model::load(options.model);
    HostScene scene;
    for (const model::Vec3& p : source.positions)
        scene.positions.push_back(vec(p.x, p.y, p.z));
    for (const model::Vec3& n : source.normals)
        scene.normals.push_back(vec(n.x, n.y, n.z));
    for (const model::Triangle& t : source.triangles) {
        uint3 triangle;
        triangle.x = t.a;
        triangle.y = t.b;
        triangle.z = t.c;
        scene.triangles.push_back(triangle);
    }
    scene.materialOfTriangle = source.materialOfTriangle;
    for (const model::Material& m : source.materials)
        scene.materials.push_back({vec(m.color.x, m.color.y, m.color.z), m.roughness,
                                   vec(m.emission.x, m.emission.y, m.emission.z), m.metallic});
    return scene;
}

// Elapsed time, and processor time, which other programs on the machine disturb less.
struct FrameTimes {
    std::vector<double> wall, processors; // milliseconds
};

double processMilliseconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * double(t.tv_sec) + 1e-6 * double(t.tv_nsec);
}

template <class Tracer>
void traceFrame(Tracer& tracer, unsigned samples, FrameTimes& times) {
    tracer.restart();
    double processors = processMilliseconds();
    auto start = std::chrono::steady_clock::now();
    tracer.addSamples(samples);
    times.wall.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
    times.processors.push_back(processMilliseconds() - processors);
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
    return values[values.size() / 2];
}

// Mean absolute difference over the mean of `b`. Both trace the same random paths, so only rounding
// differs.
double relativeDifference(const std::vector<float>& a, const std::vector<float>& b) {
    double difference = 0.0, sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) {
        if (i % 4 == 3)
            continue;
        difference += std::fabs(double(a[i]) - double(b[i]));
        sum += std::fabs(double(b[i]));
    }
    return difference / sum;
}

void measure(OptixDeviceContext context, const Options& options) {
    HostScene scene = loadScene(options);
    Bounds bounds = boundsOf(scene);
    addGround(scene, bounds, bounds.low.y, {vec(0.36f, 0.35f, 0.34f), 0.5f, vec(0.0f), 0.0f});
    Scene studio = makeStudio(bounds);
    studio.maxSegments = 4;
    Camera camera =
        orbitCamera(bounds, 38.0f, 24.0f, 1.0f, float(options.width) / float(options.height));
    PathTracer optix(context, scene, studio, camera, options.width, options.height);
    EmbreeTracer embree(scene, studio, camera, options.width, options.height);

    FrameTimes optixTimes, embreeTimes, warmUp;
    traceFrame(optix, 1, warmUp);
    traceFrame(embree, 1, warmUp);
    for (unsigned frame = 0; frame < options.frames; ++frame) {
        traceFrame(optix, options.samples, optixTimes);
        traceFrame(embree, options.samples, embreeTimes);
    }
    double optixTime = median(optixTimes.wall), embreeTime = median(embreeTimes.wall);
    double optixWork = median(optixTimes.processors), embreeWork = median(embreeTimes.processors);
    std::printf("%zu triangles, %u x %u, %u samples a frame, median of %u frames\n",
                scene.triangles.size(), options.width, options.height, options.samples,
                options.frames);
    std::printf("optixLaunch  %8.1f ms/frame, %8.1f ms of all processors\n", optixTime, optixWork);
    std::printf("Embree C++   %8.1f ms/frame, %8.1f ms of all processors\n", embreeTime, embreeWork);
    std::printf("speed        %8.2f x Embree, %5.2f x by processor time\n", embreeTime / optixTime,
                embreeWork / optixWork);
    std::printf("pictures differ by %.3f %% of their mean\n",
                100.0 * relativeDifference(optix.image(), embree.image()));
}

int run(int argc, char** argv) {
    Options options;
    Arguments arguments("Path tracer frames: optixLaunch against C++ over Embree.");
    arguments.addPositional("MODEL", options.model, "model (default: a generated knot)");
    arguments.add("--width", options.width, 1, 8192, "pixels across");
    arguments.add("--height", options.height, 1, 8192, "pixels down");
    arguments.add("--spp", options.samples, 1, 1024, "samples for each pixel of a frame");
    arguments.add("--frames", options.frames, 1, 1000, "frames of each");
    arguments.add("--triangles", options.triangles, 1000, 50000000, "size of the generated knot");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    OptixDeviceContext context = createContext();
    measure(context, options);
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("bench_path_tracer", [&] { return run(argc, argv); });
}
