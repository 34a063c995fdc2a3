// SPDX-License-Identifier: Apache-2.0
// Measures whether denoising makes pictures worse: pictures of the hard scenes with 1, 4, 16 and 64
// samples, denoised by every kind, against references of 4,096 samples. A class of pixels counts as
// worse if it is further from its reference than the input. Fails if more classes are worse, or the
// mean gain is less, than docs/denoiser.md states.
//
//   denoise_hard_scenes REFERENCES              six variants: the test
//   denoise_hard_scenes REFERENCES --all        all variants
//   denoise_hard_scenes REFERENCES --held-out   the scenes that no constant was chosen on
//   denoise_hard_scenes REFERENCES --table      prints each comparison
//   denoise_hard_scenes REFERENCES --record     renders the references (minutes)
#include "reference.h"

#include "denoise/model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace hard {
namespace {

using sunstone::denoise::Frame;
using sunstone::denoise::Kind;
using sunstone::denoise::Layer;
using sunstone::denoise::Model;

constexpr uint32_t kSamples[] = {1, 4, 16, 64};
constexpr uint32_t kReferenceSamples = 4096;
constexpr size_t kLeastPixels = 40; // of a class
// docs/denoiser.md has the figures; they may only improve.
constexpr double kMostWorse = 0.18, kLeastGain = 2.9;
// Rounding of references and inputs, in squared units of the screen.
constexpr double kSlack = 2e-6;

struct Variant {
    const char* name;
    Kind kind;
    bool albedo, normal;
    bool isTested; // without --all
};
constexpr Variant kVariants[] = {
    {"LDR", Kind::kLimited, true, true, true},
    {"LDR, no guides", Kind::kLimited, false, false, false},
    {"LDR, linear", Kind::kLimited, true, true, true}, // linear colours above 1, as programs pass
    {"HDR", Kind::kHighRange, true, true, true},
    {"HDR, albedo", Kind::kHighRange, true, false, false},
    {"HDR, normals", Kind::kHighRange, false, true, false},
    {"HDR, no guides", Kind::kHighRange, false, false, true},
    {"AOV", Kind::kLayers, true, true, false},
    {"TEMPORAL", Kind::kTemporal, true, true, false},
    {"TEMPORAL_AOV", Kind::kTemporalLayers, true, true, true},
    {"UPSCALE2X", Kind::kTwice, true, true, true},
    {"TEMPORAL_UPSCALE2X", Kind::kTemporalTwice, true, true, false},
};
constexpr unsigned kFrames = 3; // of temporal kinds
constexpr size_t kLinearLdr = 2;

float shown(float value) {
    return std::pow(std::clamp(value, 0.0f, 1.0f), 1 / 2.2f);
}
Picture encoded(const Picture& picture) {
    Picture result = picture;
    for (size_t i = 0; i < result.values.size(); ++i)
        if (i % 4 != 3)
            result.values[i] = shown(result.values[i]);
    return result;
}
Picture decoded(const Picture& picture) {
    Picture result = picture;
    for (size_t i = 0; i < result.values.size(); ++i)
        if (i % 4 != 3)
            result.values[i] = std::pow(std::max(result.values[i], 0.0f), 2.2f);
    return result;
}

// Mean squared errors by class: of screen values, and relative to the light.
struct Errors {
    double screen[kClassCount] = {}, relative[kClassCount] = {};
    size_t pixels[kClassCount] = {};

    Errors(const Picture& picture, const Reference& reference) {
        for (size_t pixel = 0; pixel < reference.classes.size(); ++pixel) {
            double onScreen = 0, light = 0;
            for (size_t c = 0; c < 3; ++c) {
                const float value = picture.values[4 * pixel + c],
                            right = reference.color.values[4 * pixel + c];
                const double d = shown(value) - shown(right), e = value - right;
                onScreen += d * d / 3;
                light += e * e / (3 * (double(right) * right + 0.01));
            }
            for (unsigned k = 0; k < kClassCount; ++k) {
                if (!reference.has(pixel, Class(k)))
                    continue;
                screen[k] += onScreen;
                relative[k] += light;
                ++pixels[k];
            }
        }
        for (unsigned k = 0; k < kClassCount; ++k)
            for (double* sum : {&screen[k], &relative[k]})
                *sum /= double(std::max<size_t>(pixels[k], 1));
    }
};

Picture bilinear(const Picture& small) {
    Picture large(2 * small.width, 2 * small.height);
    const auto next = [](uint32_t at, uint32_t size) {
        return at % 2 ? std::min(at / 2 + 1, size - 1) : at / 2 - std::min(at / 2, 1u);
    };
    for (uint32_t y = 0; y < large.height; ++y)
        for (uint32_t x = 0; x < large.width; ++x)
            for (unsigned c = 0; c < 4; ++c) {
                const auto row = [&](uint32_t from) {
                    return 0.75f * small.at(x / 2, from)[c] +
                           0.25f * small.at(next(x, small.width), from)[c];
                };
                large.at(x, y)[c] = 0.75f * row(y / 2) + 0.25f * row(next(y, small.height));
            }
    return large;
}

class Sequence {
public:
    explicit Sequence(const Variant& variant)
        : model_{variant.kind, variant.albedo, variant.normal, {}},
          filter_(sunstone::denoise::makeFilter(model_)) {}

    // `second`: a further layer of the AOV kinds.
    std::vector<Picture> next(Rendering& noisy, Picture* second) {
        const uint32_t width = noisy.color.width, height = noisy.color.height;
        const uint32_t factor = filter_->factor();
        std::vector<Picture*> inputs = {&noisy.color};
        if (second && takesLayers(model_.kind))
            inputs.push_back(second);
        std::vector<Picture> outputs(inputs.size(), Picture(factor * width, factor * height));
        Picture flow(width, height);
        std::fill(flow.values.begin(), flow.values.end(), 0.0f);
        Frame frame;
        if (model_.usesAlbedo)
            frame.albedo = noisy.albedo.image();
        if (model_.usesNormal)
            frame.normal = noisy.normal.image();
        frame.flow = flow.image();
        frame.isLimited = model_.kind == Kind::kLimited;
        frame.isTemporal = isTemporal(model_.kind);
        frame.hasPrevious = !previous_.empty();
        for (size_t i = 0; i < inputs.size(); ++i)
            frame.layers.push_back(
                {inputs[i]->image(),
                 frame.hasPrevious ? previous_[i].image() : sunstone::denoise::Image{},
                 outputs[i].image()});
        std::vector<uint8_t> scratch(filter_->scratchSize(width, height));
        filter_->run(frame, scratch.data());
        previous_ = outputs;
        return outputs;
    }

private:
    Model model_;
    std::unique_ptr<sunstone::denoise::Filter> filter_;
    std::vector<Picture> previous_;
};

struct Options {
    bool table = false, record = false, all = false, heldOut = false;
    std::string folder;
};

class Judge {
public:
    explicit Judge(const Options& options) : options_(options) {}

    void compare(const char* scene, const char* variant, uint32_t samples, const Errors& before,
                 const Errors& after) {
        for (unsigned k = 0; k < kClassCount; ++k) {
            if (before.pixels[k] < kLeastPixels)
                continue;
            const bool worse = after.screen[k] > before.screen[k] + kSlack,
                       further = after.relative[k] > before.relative[k] + 10 * kSlack;
            ++count_;
            failures_ += worse || further;
            if (options_.table)
                std::printf("%s %-16s %-18s %2u samples, %-10s (%5zu pixels): screen %9.2f -> "
                            "%8.2f (%5.2f), relative %8.5f -> %8.5f (%5.2f)\n",
                            worse || further ? "WORSE" : "     ", scene, variant, samples,
                            kClassNames[k], before.pixels[k], before.screen[k] * 65025,
                            after.screen[k] * 65025, after.screen[k] / before.screen[k],
                            before.relative[k], after.relative[k],
                            after.relative[k] / before.relative[k]);
            sumLog_ += std::log(after.screen[k] / before.screen[k] + 1e-3);
        }
    }
    int finish() const {
        std::printf("%d of %d comparisons are worse; mean gain %.2f dB\n", failures_, count_,
                    -10 / std::log(10.0) * sumLog_ / count_);
        return failures_ > kMostWorse * count_ ||
               -10 / std::log(10.0) * sumLog_ / count_ < kLeastGain;
    }

private:
    const Options& options_;
    int failures_ = 0, count_ = 0;
    double sumLog_ = 0;
};

struct Inputs {
    Rendering frames[kFrames];
};
Inputs inputsOf(const Scene& scene, uint32_t factor, uint32_t samples) {
    Inputs inputs;
    for (unsigned i = 0; i < kFrames; ++i)
        inputs.frames[i] =
            render(scene, kWidth / factor, kHeight / factor, samples, 1 + i + 16 * samples);
    return inputs;
}

void measureVariant(const Scene& scene, const Reference& reference, size_t index, Inputs inputs,
                    uint32_t samples, Judge& judge) {
    const Variant& variant = kVariants[index];
    Sequence sequence(variant);
    const unsigned frames = isTemporal(variant.kind) ? kFrames : 1;
    for (unsigned i = 0; i < frames; ++i) {
        Rendering& noisy = inputs.frames[i];
        Picture second = inputs.frames[(i + 1) % kFrames].color;
        const Picture given = noisy.color;
        const bool isEncoded = variant.kind == Kind::kLimited && index != kLinearLdr;
        if (isEncoded)
            noisy.color = encoded(noisy.color);
        std::vector<Picture> outputs = sequence.next(noisy, &second);
        if (isEncoded)
            outputs[0] = decoded(outputs[0]);
        const auto errors = [&](const Picture& picture) { return Errors(picture, reference); };
        const auto before = [&](const Picture& input) {
            if (variant.kind == Kind::kLimited) { // what it can show
                Picture cut = input;
                for (float& value : cut.values)
                    value = std::min(value, 1.0f);
                return errors(cut);
            }
            return errors(isTwice(variant.kind) ? bilinear(input) : input);
        };
        if (i + 1 != frames && i != 0)
            continue;
        judge.compare(scene.name, variant.name, samples, before(given), errors(outputs[0]));
        if (outputs.size() > 1)
            judge.compare(scene.name, "  second layer", samples, before(second),
                          errors(outputs[1]));
    }
}

void measure(const Scene& scene, const Reference& full, const Options& options, Judge& judge) {
    Reference cut = full; // for limited colours
    for (float& value : cut.color.values)
        value = std::min(value, 1.0f);
    for (uint32_t samples : kSamples) {
        const Inputs large = inputsOf(scene, 1, samples), small = inputsOf(scene, 2, samples);
        for (size_t v = 0; v < std::size(kVariants); ++v)
            if (options.all || kVariants[v].isTested)
                measureVariant(scene, kVariants[v].kind == Kind::kLimited ? cut : full, v,
                               isTwice(kVariants[v].kind) ? small : large, samples, judge);
    }
}

int run(const Options& options) {
    Judge judge(options);
    const unsigned first = options.heldOut ? kTunedCount : 0;
    const unsigned last = options.heldOut || options.record ? kSceneCount : kTunedCount;
    for (unsigned i = first; i < last; ++i) {
        const Scene scene = makeScene(i);
        std::string name = scene.name;
        std::replace(name.begin(), name.end(), ' ', '_');
        const std::string path = options.folder + "/" + name + ".reference";
        if (options.record)
            saveReference(renderReference(scene, kReferenceSamples), path);
        else
            measure(scene, loadReference(path), options, judge);
    }
    return options.record ? 0 : judge.finish();
}

} // namespace
} // namespace hard

int main(int argc, char** argv) {
    hard::Options options;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--table") == 0)
            options.table = true;
        else if (std::strcmp(argv[i], "--record") == 0)
            options.record = true;
        else if (std::strcmp(argv[i], "--held-out") == 0)
            options.heldOut = true;
        else if (std::strcmp(argv[i], "--all") == 0)
            options.all = true;
        else
            options.folder = argv[i];
    }
    try {
        return hard::run(options);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
