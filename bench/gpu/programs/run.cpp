// SPDX-License-Identifier: Apache-2.0
// One program in one process: the times of its steps, frames, the picture.
#include "run.h"

#include "../measurements.h"

#include <algorithm>
#include <ctime>
#include <fstream>
#include <stdexcept>

namespace bench {

long long monotonicNow() {
    timespec now = {};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

std::string resultFile(const std::string& out, const std::string& name, const std::string& label,
                       const std::string& suffix) {
    return out + "/" + name + "." + label + "." + suffix;
}

const JobKind& jobNamed(const std::string& name) {
    for (const JobKind& kind : jobKinds())
        if (kind.name == name)
            return kind;
    throw std::runtime_error("there is no program '" + name + "' (see --help)");
}

namespace {

class Clock {
public:
    // Milliseconds since the last call.
    double lap() {
        const long long now = monotonicNow(), took = now - last_;
        last_ = now;
        return double(took) * 1e-6;
    }

private:
    long long last_ = monotonicNow();
};

// A program of the first set.
class JobApplication : public Application {
public:
    JobApplication(OptixDeviceContext context, Job job) : context_(context), job_(std::move(job)) {}

    void compile() override { pipeline_ = std::make_unique<JobPipeline>(context_, job_); }
    double compileTime() const override { return pipeline_->compileTime(); }
    void renderFrame() override {
        if (job_.prepare)
            job_.prepare(job_);
        for (unsigned i = 0; i < job_.launches; ++i) {
            job_.params.tile = i % job_.tiles;
            pipeline_->launch(job_.params, job_.launchWidth, job_.launchHeight);
        }
        ++job_.frame;
    }
    std::vector<float> picture() override { return job_.image.download<float>(); }

private:
    OptixDeviceContext context_;
    Job job_;
    std::unique_ptr<JobPipeline> pipeline_;
};

std::unique_ptr<Application> start(const JobKind& kind, OptixDeviceContext context,
                                   const JobSettings& settings) {
    if (kind.start)
        return kind.start(context, settings);
    return std::make_unique<JobApplication>(context, kind.make(context, settings));
}

void renderFrame(Application& application) {
    application.renderFrame();
    CUDA_CHECK(cudaDeviceSynchronize());
}

// FNV-1a of the bytes.
unsigned long long digestOf(const std::vector<float>& values) {
    unsigned long long digest = 14695981039346656037ull;
    const auto* const bytes = reinterpret_cast<const unsigned char*>(values.data());
    for (size_t i = 0; i < values.size() * sizeof(float); ++i)
        digest = (digest ^ bytes[i]) * 1099511628211ull;
    return digest;
}

void writePicture(const std::string& path, const std::vector<float>& pixels) {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(pixels.data()),
               std::streamsize(pixels.size() * sizeof(float)));
    if (!file)
        throw std::runtime_error("cannot write " + path);
}

void describePicture(const std::string& name, const std::vector<float>& pixels,
                     Measurements& measurements) {
    double sum = 0;
    size_t invalid = 0;
    for (size_t i = 0; i < pixels.size(); ++i) {
        if (i % 4 == 3)
            continue;
        if (pixels[i] == pixels[i])
            sum += double(pixels[i]);
        else
            ++invalid;
    }
    measurements.add(name, "picture, mean", sum / (double(pixels.size()) * 0.75), "");
    measurements.add(name, "picture, not a number", double(invalid), "values");
    std::printf("%-24s picture, digest %016llx\n", name.c_str(), digestOf(pixels));
}

} // namespace

void runJob(const JobKind& kind, const RunSettings& settings) {
    Measurements measurements(settings.label);
    const std::string name = kind.name;
    const auto add = [&](const char* what, double value) {
        measurements.add(name, what, value, "ms");
    };
    const long long started = settings.started ? settings.started : monotonicNow();
    Clock clock;
    const OptixDeviceContext context = createContext();
    add("context", clock.lap());
    std::vector<float> pixels;
    {
        const std::unique_ptr<Application> application = start(kind, context, settings.job);
        add("scene and structures", clock.lap());
        application->compile();
        add("compile", application->compileTime());
        clock.lap();
        renderFrame(*application);
        add("first frame", clock.lap());
        pixels = application->picture();
        add("start to picture", double(monotonicNow() - started) * 1e-6);
        double best = 1e30;
        for (unsigned i = 0; i < settings.repeats; ++i) {
            clock.lap();
            renderFrame(*application);
            best = std::min(best, clock.lap());
        }
        if (settings.repeats > 0)
            add("best frame", best);
    }
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    describePicture(name, pixels, measurements);
    if (settings.out.empty())
        return;
    measurements.write(resultFile(settings.out, name, settings.label, settings.phase + ".json"));
    if (settings.phase == "warm")
        writePicture(resultFile(settings.out, name, settings.label, "picture"), pixels);
}

} // namespace bench
