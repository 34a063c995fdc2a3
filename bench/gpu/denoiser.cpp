// SPDX-License-Identifier: Apache-2.0
// The denoiser: milliseconds per megapixel, its gain on a drawn scene with a known reference, and
// whether two runs of Sunstone, on the CPU and on a GPU, give the same bits.
#include "benches.h"
#include "world.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace bench {
namespace {

using Pixels = std::vector<float>; // 4 floats a pixel

// A number in [0, 1) for a place and a purpose.
float chance(uint32_t x, uint32_t y, uint32_t purpose) {
    uint32_t h = x * 0x9E3779B1u ^ (y + 0x7F4A7C15u) * 0x85EBCA77u ^ (purpose + 1) * 0xC2B2AE3Du;
    for (int i = 0; i < 2; ++i) {
        h ^= h >> 15;
        h *= 0x2C1B3C6Du;
        h ^= h >> 12;
        h *= 0x297A2D39u;
    }
    return float(h >> 8) * 0x1p-24f;
}
// Noise with mean 1, as of four paths.
float noise(uint32_t x, uint32_t y, uint32_t purpose) {
    float product = 1;
    for (uint32_t i = 0; i < 4; ++i)
        product *= 1 - chance(x, y, 4 * purpose + i);
    return -0.25f * std::log(product);
}

// Balls before a chequered wall, one lamp, highlights.
struct Drawing {
    unsigned width, height;
    Pixels truth, noisy, albedo, normal;

    Drawing(unsigned w, unsigned h, uint32_t seed)
        : width(w), height(h), truth(size_t(w) * h * 4), noisy(truth), albedo(truth),
          normal(truth) {
        tbb::parallel_for(0u, height, [&](uint32_t y) {
            for (uint32_t x = 0; x < width; ++x)
                draw(x, y, seed);
        });
    }

private:
    void draw(uint32_t x, uint32_t y, uint32_t seed) {
        const float cell = float(height) / 4;
        const float u = (float(x) + 0.5f) / cell, v = (float(y) + 0.5f) / cell;
        const float dx = (u - std::floor(u) - 0.5f) / 0.42f,
                    dy = (v - std::floor(v) - 0.5f) / 0.42f;
        const float square = dx * dx + dy * dy;
        const bool ball = square < 1;
        const float n[3] = {ball ? dx : 0, ball ? dy : 0, ball ? std::sqrt(1 - square) : 1};
        const bool dark = (int(u * 20) + int(v * 20)) % 2 != 0;
        const float light = 0.2f + std::max(0.0f, -0.5f * n[0] - 0.6f * n[1] + 0.62f * n[2]);
        const float shine = std::max(0.0f, -0.28f * n[0] - 0.33f * n[1] + 0.9f * n[2]);
        const float highlight = ball ? 2 * std::pow(shine, 60.0f) : 0;
        const size_t at = (size_t(y) * width + x) * 4;
        for (uint32_t c = 0; c < 3; ++c) {
            const float wall = (dark ? 0.2f : 0.8f) * (c == 2 ? 0.8f : 1.0f);
            albedo[at + c] = ball ? 0.25f + 0.7f * chance(uint32_t(u), uint32_t(v), c) : wall;
            normal[at + c] = n[c];
            truth[at + c] = albedo[at + c] * light + highlight;
            noisy[at + c] =
                albedo[at + c] * light * noise(x, y, seed) + highlight * noise(x, y, seed + 1000);
        }
        truth[at + 3] = noisy[at + 3] = albedo[at + 3] = normal[at + 3] = 1;
    }
};

float shown(float value) {
    return std::pow(std::clamp(value, 0.0f, 1.0f), 1 / 2.2f);
}
double psnr(const Pixels& a, const Pixels& b, bool areEncoded) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        const double d = areEncoded ? double(a[i]) - b[i] : double(shown(a[i])) - shown(b[i]);
        sum += i % 4 == 3 ? 0 : d * d;
    }
    return 10 * std::log10(double(a.size()) * 0.75 / std::max(sum, 1e-12));
}

struct Kind {
    const char* name;
    OptixDenoiserModelKind kind;
    bool withGuides;
};
constexpr Kind kKinds[] = {
    {"HDR, albedo and normals", OPTIX_DENOISER_MODEL_KIND_HDR, true},
    {"HDR, no guides", OPTIX_DENOISER_MODEL_KIND_HDR, false},
    {"LDR, albedo and normals", OPTIX_DENOISER_MODEL_KIND_LDR, true},
    {"AOV, two layers", OPTIX_DENOISER_MODEL_KIND_AOV, true},
    {"TEMPORAL, fourth frame", OPTIX_DENOISER_MODEL_KIND_TEMPORAL, true},
};

class DenoiserBench {
public:
    DenoiserBench(OptixDeviceContext context, const Kind& kind, unsigned width, unsigned height)
        : kind_(kind), width_(width), height_(height) {
        OptixDenoiserOptions options = {};
        options.guideAlbedo = options.guideNormal = kind.withGuides;
        OPTIX_CHECK(optixDenoiserCreate(context, kind.kind, &options, &denoiser_));
        OptixDenoiserSizes sizes = {};
        OPTIX_CHECK(optixDenoiserComputeMemoryResources(denoiser_, width, height, &sizes));
        state_.allocate(sizes.stateSizeInBytes);
        scratch_.allocate(std::max<size_t>(sizes.withoutOverlapScratchSizeInBytes,
                                           sizeof(int) * (2 + size_t(width) * height)));
        intensity_.allocate(sizeof(float));
        flow_.upload(std::vector<float>(size_t(width) * height * 2, 0.0f));
        OPTIX_CHECK(optixDenoiserSetup(denoiser_, nullptr, width, height, state_.address(),
                                       state_.size(), scratch_.address(), scratch_.size()));
    }
    DenoiserBench(const DenoiserBench&) = delete;
    ~DenoiserBench() { optixDenoiserDestroy(denoiser_); }

    bool isLimited() const { return kind_.kind == OPTIX_DENOISER_MODEL_KIND_LDR; }

    // Uploads a frame. Its previous frame is the one uploaded before; for the first frame, itself.
    void show(const Drawing& drawing) {
        Pixels noisy = drawing.noisy;
        if (isLimited())
            std::transform(noisy.begin(), noisy.end(), noisy.begin(), shown);
        input_.upload(noisy);
        if (output_.size() == 0)
            output_.upload(noisy);
        albedo_.upload(drawing.albedo);
        normal_.upload(drawing.normal);
        second_.allocate(output_.size());
    }
    void queueIntensity() {
        const OptixImage2D image = describe(input_, OPTIX_PIXEL_FORMAT_FLOAT4);
        OPTIX_CHECK(optixDenoiserComputeIntensity(denoiser_, nullptr, &image, intensity_.address(),
                                                  scratch_.address(), scratch_.size()));
    }
    void queue() {
        OptixDenoiserGuideLayer guides = {};
        if (kind_.withGuides) {
            guides.albedo = describe(albedo_, OPTIX_PIXEL_FORMAT_FLOAT4);
            guides.normal = describe(normal_, OPTIX_PIXEL_FORMAT_FLOAT4);
        }
        OptixDenoiserLayer layers[2] = {};
        for (OptixDenoiserLayer& layer : layers) {
            layer.input = describe(input_, OPTIX_PIXEL_FORMAT_FLOAT4);
            layer.output =
                describe(&layer == layers ? output_ : second_, OPTIX_PIXEL_FORMAT_FLOAT4);
        }
        if (kind_.kind == OPTIX_DENOISER_MODEL_KIND_TEMPORAL) {
            guides.flow = describe(flow_, OPTIX_PIXEL_FORMAT_FLOAT2);
            layers[0].previousOutput = layers[0].output;
        }
        OptixDenoiserParams params = {};
        if (kind_.kind == OPTIX_DENOISER_MODEL_KIND_HDR)
            params.hdrIntensity = intensity_.address();
        const unsigned count = kind_.kind == OPTIX_DENOISER_MODEL_KIND_AOV ? 2 : 1;
        OPTIX_CHECK(optixDenoiserInvoke(denoiser_, nullptr, &params, state_.address(),
                                        state_.size(), &guides, layers, count, 0, 0,
                                        scratch_.address(), scratch_.size()));
    }
    Pixels result() const {
        CUDA_CHECK(cudaDeviceSynchronize());
        return output_.download<float>();
    }
    // Denoises as many frames as the kind needs; returns the last.
    Pixels denoised(const Drawing& first) {
        const unsigned frames = kind_.kind == OPTIX_DENOISER_MODEL_KIND_TEMPORAL ? 4 : 1;
        for (unsigned i = 0; i < frames; ++i) {
            show(i == 0 ? first : Drawing(width_, height_, i));
            queueIntensity();
            queue();
        }
        return result();
    }

private:
    OptixImage2D describe(const DeviceBuffer& memory, OptixPixelFormat format) const {
        const unsigned pixel = format == OPTIX_PIXEL_FORMAT_FLOAT2 ? 8 : 16;
        return {memory.address(), width_, height_, width_ * pixel, pixel, format};
    }

    const Kind& kind_;
    unsigned width_, height_;
    OptixDenoiser denoiser_ = nullptr;
    DeviceBuffer state_, scratch_, intensity_, input_, output_, second_, albedo_, normal_, flow_;
};

void measure(OptixDeviceContext context, const Kind& kind, const Drawing& drawing,
             const Settings& settings, Measurements& measurements) {
    const std::string scene =
        "denoiser " + std::to_string(drawing.width) + " x " + std::to_string(drawing.height);
    DenoiserBench bench(context, kind, drawing.width, drawing.height);
    const Pixels result = bench.denoised(drawing);
    const double megapixels = double(drawing.width) * drawing.height * 1e-6;
    const int repeats = int(settings.repeats);
    measurements.add(scene, kind.name, fastest(repeats, [&] { bench.queue(); }) / megapixels,
                     "ms/Mpixel");
    if (&kind == kKinds)
        measurements.add(scene, "intensity",
                         fastest(repeats, [&] { bench.queueIntensity(); }) / megapixels,
                         "ms/Mpixel");
    Pixels truth = drawing.truth;
    if (bench.isLimited())
        std::transform(truth.begin(), truth.end(), truth.begin(), shown);
    measurements.add(
        scene, std::string(kind.name) + ", gain",
        psnr(result, truth, bench.isLimited()) - psnr(drawing.noisy, drawing.truth, false), "dB");
}

} // namespace

void benchDenoiser(OptixDeviceContext context, const Settings& settings,
                   Measurements& measurements) {
    for (const unsigned part : {2u, 3u, 6u}) { // thirds of the settings' sides
        const Drawing drawing(settings.width * part / 3, settings.height * part / 3, 0);
        for (const Kind& kind : kKinds)
            if (part == 3 || &kind == kKinds)
                measure(context, kind, drawing, settings, measurements);
    }
}

void compareDenoisers(OptixDeviceContext context, const Settings& settings,
                      Measurements& measurements) {
    const Drawing drawing(settings.width / 6, settings.height / 6, 0);
    for (const Kind& kind : kKinds) {
        DenoiserBench bench(context, kind, drawing.width, drawing.height);
        Pixels result = bench.denoised(drawing), known(result.size());
        if (!exchange(settings, std::string("denoiser ") + kind.name, result.data(),
                      result.size() * sizeof(float), known.data()))
            continue;
        size_t differing = 0;
        float largest = 0;
        for (size_t i = 0; i < result.size(); ++i) {
            differing += std::memcmp(&result[i], &known[i], sizeof(float)) != 0;
            largest = std::max(largest, std::fabs(result[i] - known[i]));
        }
        measurements.add("denoiser, two runs", std::string(kind.name) + ", other values",
                         double(differing), "");
        if (differing != 0)
            measurements.addDifferences(
                "denoiser", kind.name,
                {{"values", result.size()}, {"differ", differing}, {"by at most", largest}});
    }
}

} // namespace bench
