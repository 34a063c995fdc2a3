// SPDX-License-Identifier: Apache-2.0
// The denoiser's gain on path-traced scenes of 4 samples a pixel (samples/optix7/denoiser) for each
// kind; its preservation of edges in the guides; the flicker of images of a moving camera. Prints
// tables, and fails if a figure misses its limit in docs/denoiser.md.
#include "arguments.h"
#include "image_denoiser.h"
#include "path_tracer.h"
#include "quality.h"
#include "views.h"

#include <optix_function_table_definition.h>

#include <cstdio>

namespace {

using Image = std::vector<float>; // 4 floats a pixel

constexpr unsigned kSamples = 4;
// Promised limits, beside a gain of 6 dB.
constexpr double kLeastEdgeGain = 1.5;
constexpr double kLeastContrast = 0.85, kMostContrast = 1.15;
constexpr double kMostFlicker = 0.75; // of the flicker of single frames

struct Options {
    unsigned width = 320, height = 240, reference = 256, leastGain = 6;
};

// Two images of the same scene with independent noise. The product of an image's differences from
// both estimates its error without their noise, with far fewer samples than a clean reference
// needs.
struct Reference {
    Image halves[2], mean;
};

template <class Counts>
double psnr(const Image& image, const Reference& reference, Counts counts) {
    double sum = 0.0;
    size_t values = 0;
    for (size_t i = 0; i < image.size(); ++i) {
        if (i % 4 == 3 || !counts(i / 4))
            continue;
        double value = shown(image[i]);
        sum += (value - shown(reference.halves[0][i])) * (value - shown(reference.halves[1][i]));
        ++values;
    }
    return 10.0 * std::log10(double(std::max<size_t>(values, 1)) / std::max(sum, 1e-12));
}
double psnr(const Image& image, const Reference& reference) {
    return psnr(image, reference, [](size_t) { return true; });
}

int gFailures = 0;

void require(bool condition, const char* scene, const char* what, double value) {
    if (condition)
        return;
    std::printf("FAILED: %s, %s: %.2f\n", scene, what, value);
    ++gFailures;
}

// One tracer with a reference of its present camera.
class Stage {
public:
    Stage(OptixDeviceContext context, unsigned number, const Options& options)
        : options_(options), number_(number), view_(at(0.0f)),
          tracer_(context, view_.scene, view_.lights, view_.camera, options.width, options.height) {
        tracer_.wantGuides(view_.camera);
    }
    const char* name() const { return view_.name; }
    View at(float turn) const {
        return makeView(number_, float(options_.width) / float(options_.height), turn);
    }
    PathTracer& tracer() { return tracer_; }

    // A noisy picture with its guides, and the picture without noise.
    NoisyImage noisy(unsigned seed) {
        tracer_.restart(seed);
        tracer_.addSamples(kSamples);
        NoisyImage image;
        image.layers = {tracer_.image()};
        image.albedo = tracer_.albedo();
        image.normal = tracer_.normal();
        image.flow = tracer_.flow();
        return image;
    }
    Reference reference() {
        Reference result;
        for (unsigned half = 0; half < 2; ++half) {
            tracer_.restart(12345 + half);
            tracer_.addSamples((options_.reference + 1) / 2);
            result.halves[half] = tracer_.image();
        }
        cleanAlbedo_ = tracer_.albedo();
        cleanNormal_ = tracer_.normal();
        result.mean = result.halves[0];
        for (size_t i = 0; i < result.mean.size(); ++i)
            result.mean[i] = 0.5f * (result.halves[0][i] + result.halves[1][i]);
        return result;
    }
    // Pixels whose albedo or normal differs strongly from that of the right or lower neighbour.
    std::vector<bool> edges() const {
        std::vector<bool> found(size_t(options_.width) * options_.height);
        auto differs = [](const Image& guide, size_t a, size_t b, float limit) {
            float sum = 0.0f;
            for (int c = 0; c < 3; ++c)
                sum += std::abs(guide[4 * a + c] - guide[4 * b + c]);
            return sum > limit;
        };
        for (unsigned y = 0; y + 1 < options_.height; ++y)
            for (unsigned x = 0; x + 1 < options_.width; ++x) {
                size_t pixel = size_t(y) * options_.width + x;
                for (size_t other : {pixel + 1, pixel + options_.width})
                    if (differs(cleanAlbedo_, pixel, other, 0.3f) ||
                        differs(cleanNormal_, pixel, other, 0.6f))
                        found[pixel] = true;
            }
        return found;
    }
    const Options& options() const { return options_; }

private:
    Options options_;
    unsigned number_;
    View view_;
    PathTracer tracer_;
    Image cleanAlbedo_, cleanNormal_;
};

// The input of LDR kinds: screen values. psnr() reverses the encoding.
Image encoded(const Image& image, bool forth) {
    Image result = image;
    for (size_t i = 0; i < image.size(); ++i)
        if (i % 4 != 3)
            result[i] = forth ? shown(image[i]) : std::pow(std::max(image[i], 0.0f), 2.2f);
    return result;
}

// Mean step from edge pixels to their right neighbours, relative to the reference's. One half of
// the reference determines the direction, the other the distance, so that noise cancels.
double edgeContrast(const Image& image, const Reference& reference,
                    const std::vector<bool>& edges) {
    double own = 0.0, right = 0.0;
    for (size_t pixel = 0; pixel + 1 < edges.size(); ++pixel) {
        if (!edges[pixel])
            continue;
        for (size_t c = 4 * pixel; c < 4 * pixel + 3; ++c) {
            auto step = [&](const Image& from) { return shown(from[c]) - shown(from[c + 4]); };
            double way = step(reference.halves[0]) < 0 ? -1 : 1;
            own += step(image) * way;
            right += step(reference.halves[1]) * way;
        }
    }
    return own / std::max(right, 1e-9);
}

void measureKinds(OptixDeviceContext context, Stage& stage) {
    unsigned width = stage.options().width, height = stage.options().height;
    NoisyImage noisy = stage.noisy(1);
    Image other = stage.noisy(2).layers[0];
    Reference reference = stage.reference();
    std::vector<bool> edges = stage.edges();
    auto onEdges = [&](size_t pixel) { return bool(edges[pixel]); };
    double before = psnr(noisy.layers[0], reference);

    auto denoise = [&](OptixDenoiserModelKind kind, const NoisyImage& image, bool guided) {
        ImageDenoiser denoiser(context, kind, guided, guided, width, height);
        return denoiser.denoise(image);
    };
    Image hdr = denoise(OPTIX_DENOISER_MODEL_KIND_HDR, noisy, true)[0];
    Image plain = denoise(OPTIX_DENOISER_MODEL_KIND_HDR, noisy, false)[0];
    NoisyImage screen = noisy;
    screen.layers[0] = encoded(noisy.layers[0], true);
    Image ldr = encoded(denoise(OPTIX_DENOISER_MODEL_KIND_LDR, screen, true)[0], false);
    NoisyImage layers = noisy;
    layers.layers.push_back(other);
    std::vector<Image> aov = denoise(OPTIX_DENOISER_MODEL_KIND_AOV, layers, true);

    double gains[] = {psnr(ldr, reference) - before, psnr(hdr, reference) - before,
                      psnr(aov[0], reference) - before,
                      psnr(aov[1], reference) - psnr(other, reference)};
    double edgeGain = psnr(hdr, reference, onEdges) - psnr(noisy.layers[0], reference, onEdges);
    double contrast = edgeContrast(hdr, reference, edges);
    std::printf("| %-8s | %5.1f | %5.1f | %5.1f | %5.1f | %5.1f | %5.1f | %5.1f | %4.2f |\n",
                stage.name(), before, gains[0], gains[1], gains[2], gains[3],
                psnr(plain, reference) - before, edgeGain, contrast);
    const char* names[] = {"LDR gain", "HDR gain", "AOV gain", "AOV gain, second layer"};
    for (int i = 0; i < 4; ++i)
        require(gains[i] >= stage.options().leastGain, stage.name(), names[i], gains[i]);
    require(edgeGain >= kLeastEdgeGain, stage.name(), "gain at edges", edgeGain);
    require(contrast >= kLeastContrast && contrast <= kMostContrast, stage.name(),
            "contrast of edges", contrast);
}

// Root mean square of the change of the error from one frame to the next.
double flicker(const Image& before, const Image& beforeReference, const Image& after,
               const Image& afterReference) {
    double sum = 0.0;
    for (size_t i = 0; i < after.size(); ++i) {
        if (i % 4 == 3)
            continue;
        double change = (shown(after[i]) - shown(afterReference[i])) -
                        (shown(before[i]) - shown(beforeReference[i]));
        sum += change * change;
    }
    return std::sqrt(sum / double(after.size() / 4 * 3));
}

// A camera that moves a third of a degree from frame to frame.
void measureTemporal(OptixDeviceContext context, Stage& stage, OptixDenoiserModelKind kind) {
    constexpr unsigned kFrames = 8;
    unsigned width = stage.options().width, height = stage.options().height;
    ImageDenoiser temporal(context, kind, true, true, width, height);
    ImageDenoiser single(context, OPTIX_DENOISER_MODEL_KIND_HDR, true, true, width, height);
    Image last[2], lastSingle[2], noisy;
    Reference references[2];
    for (unsigned frame = 0; frame < kFrames; ++frame) {
        stage.tracer().moveTo(stage.at(float(frame) / 3.0f).camera);
        NoisyImage image = stage.noisy(100 + frame);
        if (frame == 0) // no motion before
            std::fill(image.flow.begin(), image.flow.end(), 0.0f);
        unsigned slot = frame % 2;
        last[slot] = temporal.denoise(image)[0];
        lastSingle[slot] = single.denoise(image)[0];
        noisy = image.layers[0];
        if (frame + 2 >= kFrames)
            references[slot] = stage.reference();
    }
    double before = psnr(noisy, references[1]);
    double gain = psnr(last[1], references[1]) - before;
    double singleGain = psnr(lastSingle[1], references[1]) - before;
    double own = flicker(last[0], references[0].mean, last[1], references[1].mean);
    double frames = flicker(lastSingle[0], references[0].mean, lastSingle[1], references[1].mean);
    std::printf("| %-8s | %-12s | %5.1f | %5.1f | %5.1f | %.4f | %.4f |\n", stage.name(),
                kind == OPTIX_DENOISER_MODEL_KIND_TEMPORAL ? "TEMPORAL" : "TEMPORAL_AOV", before,
                singleGain, gain, frames, own);
    require(gain >= stage.options().leastGain, stage.name(), "temporal gain", gain);
    require(own <= kMostFlicker * frames, stage.name(), "flicker against single frames",
            own / frames);
}

// The alternative for a denoised image without an upscaling denoiser.
Image bilinear(const Image& small, unsigned width, unsigned height) {
    Image large(4 * small.size());
    auto next = [](unsigned at, unsigned size) { // the other pixel that counts
        return at % 2 ? std::min(at / 2 + 1, size - 1) : at / 2 - std::min(at / 2, 1u);
    };
    for (unsigned y = 0; y < 2 * height; ++y)
        for (unsigned x = 0; x < 2 * width; ++x)
            for (unsigned c = 0; c < 4; ++c) {
                auto row = [&](unsigned from) {
                    size_t at = size_t(from) * width;
                    return 0.75f * small[4 * (at + x / 2) + c] +
                           0.25f * small[4 * (at + next(x, width)) + c];
                };
                large[4 * (size_t(y) * 2 * width + x) + c] =
                    0.75f * row(y / 2) + 0.25f * row(next(y, height));
            }
    return large;
}

// Against a reference twice as wide and high.
void measureUpscaling(OptixDeviceContext context, Stage& stage, Stage& large) {
    unsigned width = stage.options().width, height = stage.options().height;
    auto denoise = [&](OptixDenoiserModelKind kind, const NoisyImage& image) {
        ImageDenoiser denoiser(context, kind, true, true, width, height);
        return denoiser.denoise(image)[0];
    };
    NoisyImage noisy = stage.noisy(1);
    Reference reference = large.reference();
    double before = psnr(bilinear(noisy.layers[0], width, height), reference);
    Image plain = bilinear(denoise(OPTIX_DENOISER_MODEL_KIND_HDR, noisy), width, height);
    double interpolated = psnr(plain, reference);
    double upscaled = psnr(denoise(OPTIX_DENOISER_MODEL_KIND_UPSCALE2X, noisy), reference);

    ImageDenoiser temporal(context, OPTIX_DENOISER_MODEL_KIND_TEMPORAL_UPSCALE2X, true, true, width,
                           height);
    Image last;
    for (unsigned frame = 0; frame < 4; ++frame) { // with a fixed camera
        NoisyImage image = stage.noisy(1 + frame);
        std::fill(image.flow.begin(), image.flow.end(), 0.0f);
        last = temporal.denoise(image)[0];
    }
    double stable = psnr(last, reference);
    std::printf("| %-8s | %5.1f | %5.2f | %5.2f | %5.2f |\n", stage.name(), before,
                interpolated - before, upscaled - before, stable - before);
    require(upscaled > interpolated, stage.name(), "upscaled, against bilinear",
            upscaled - interpolated);
    require(stable > upscaled, stage.name(), "fourth frame upscaled, against the first",
            stable - upscaled);
}

int run(int argc, char** argv) {
    Options options;
    Arguments arguments("Measures what the denoiser gains on path-traced scenes.");
    arguments.add("--width", options.width, 32, 4096, "pixels across");
    arguments.add("--height", options.height, 32, 4096, "pixels down");
    arguments.add("--reference", options.reference, 16, 65536, "samples of the reference pictures");
    arguments.add("--least-gain", options.leastGain, 0, 60, "decibels that every kind has to gain");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    OptixDeviceContext context = createContext();
    std::printf("%u x %u pixels, %u samples against %u; decibels\n\n", options.width,
                options.height, kSamples, options.reference);
    std::printf(
        "| scene | noisy | LDR gain | HDR gain | AOV gain | AOV layer 2 | HDR without guides | "
        "HDR at edges | edge contrast |\n|---|---|---|---|---|---|---|---|---|\n");
    for (unsigned number = 0; number < kViewCount; ++number) {
        Stage stage(context, number, options);
        measureKinds(context, stage);
    }
    std::printf(
        "\n| scene | kind | noisy | gain of single frames | gain | flicker of single frames | "
        "flicker |\n|---|---|---|---|---|---|---|\n");
    for (unsigned number : {1u, 3u}) {
        Stage stage(context, number, options);
        measureTemporal(context, stage,
                        number == 1 ? OPTIX_DENOISER_MODEL_KIND_TEMPORAL
                                    : OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV);
    }
    std::printf("\n| scene | noisy, bilinear to twice the size | HDR, then bilinear | UPSCALE2X | "
                "TEMPORAL_UPSCALE2X, fourth frame |\n|---|---|---|---|---|\n");
    Options half = options;
    half.width /= 2;
    half.height /= 2;
    Options whole = half;
    whole.width *= 2;
    whole.height *= 2;
    for (unsigned number = 0; number < kViewCount; ++number) {
        Stage small(context, number, half), large(context, number, whole);
        measureUpscaling(context, small, large);
    }
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    return gFailures == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("denoise_quality", [&] { return run(argc, argv); });
}
