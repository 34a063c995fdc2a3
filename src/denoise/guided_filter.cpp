// SPDX-License-Identifier: Apache-2.0
#include "denoise/guided_filter.h"

#include "denoise/history.h"
#include "denoise/rows.h"
#include "denoise/upsampler.h"

#include "base/error.h"
#include "base/threads.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace sunstone::denoise {
namespace {

constexpr size_t kPlaneCount = 25;
constexpr size_t kLargePlaneCount = 7; // of the output's size, where that is larger
constexpr size_t kAlignment = 64;
constexpr size_t kRowsPerTask = 4;
// Beyond this a value is as good as infinite; its square still fits into a float with room.
constexpr float kLargestColor = 1e8f;
// Albedo below which a colour is taken for emitted or mirrored rather than for diffuse, gradually
// (and so are pixels at the rim of an object before the sky).
constexpr float kDarkAlbedo = 0.2f;
constexpr float kLeastDivisor = 0.02f;

size_t rowStride(uint32_t width) {
    return (size_t(width) + 15) / 16 * 16;
}
size_t planeSize(uint32_t width, uint32_t height) {
    return rowStride(width) * height;
}

// Limited colours are encoded for a screen. The mean of noisy encoded colours is too dark: they are
// averaged as light, by a curve that is near to all in use.
float decoded(float value) {
    return value > 0.0f ? value * value : 0.0f;
}
float encoded(float value) {
    return value > 0.0f ? std::sqrt(value) : 0.0f;
}

bool isUsable(float value) {
    return std::abs(value) < INFINITY; // false for NaN
}

// What diffuse colours are divided by, for one pixel.
struct Divisor {
    float values[3];

    explicit Divisor(const float (&albedo)[3]) {
        float brightest = std::max(albedo[0], std::max(albedo[1], albedo[2]));
        float diffuse = std::min(1.0f, brightest / kDarkAlbedo);
        for (int c = 0; c < 3; ++c)
            values[c] = std::max(albedo[c], kLeastDivisor) * diffuse + (1.0f - diffuse);
    }
};

class Run {
public:
    Run(const Frame& frame, const FilterSettings& settings, uint32_t factor, void* scratch)
        : frame_(frame), settings_(settings), factor_(factor), first_(frame.layers.at(0).input) {
        pass_ = Pass{};
        pass_.width = first_.width;
        pass_.height = first_.height;
        pass_.stride = rowStride(first_.width);
        pass_.colorTolerance = settings.colorTolerance * settings.colorTolerance;
        uintptr_t address = reinterpret_cast<uintptr_t>(scratch);
        next_ = reinterpret_cast<float*>((address + kAlignment - 1) / kAlignment * kAlignment);
        for (Planes* planes : {&a_, &b_}) {
            for (float*& plane : planes->color)
                plane = takePlane();
            planes->variance = takePlane();
            planes->alpha = takePlane();
        }
        for (float*& plane : pilot_.color)
            plane = takePlane();
        pilot_.variance = takePlane();
        for (float*& plane : pass_.detail)
            plane = takePlane();
        for (float*& plane : guides_)
            plane = takePlane();
        valid_ = takePlane();
        alpha_ = takePlane();
        pass_.valid = valid_;
        outputStride_ = pass_.stride;
        if (factor_ == 1)
            return;
        outputStride_ = rowStride(factor_ * pass_.width);
        for (float** plane :
             {&large_.color[0], &large_.color[1], &large_.color[2], &large_.variance,
              &blended_.color[0], &blended_.color[1], &blended_.color[2]})
            *plane = takePlane(factor_);
    }

    void all() {
        loadGuides();
        for (size_t i = 0; i < frame_.layers.size(); ++i)
            denoise(frame_.layers[i], i == 0);
    }

private:
    using RowFunction = void (*)(const Pass&, uint32_t);

    float* takePlane(uint32_t factor = 1) {
        float* plane = next_;
        next_ += planeSize(factor * pass_.width, factor * pass_.height);
        return plane;
    }

    template <class Body>
    void forRows(Body body) const {
        parallelFor(pass_.height, kRowsPerTask, [&](size_t begin, size_t end) {
            for (size_t y = begin; y < end; ++y)
                body(uint32_t(y));
        });
    }
    template <class Body>
    void forPixels(Body body) const {
        forRows([&](uint32_t y) {
            for (uint32_t x = 0; x < pass_.width; ++x)
                body(x, y, y * pass_.stride + x);
        });
    }
    void run(RowFunction row, const Planes& from, const Planes& to) {
        pass_.from = from;
        pass_.to = to;
        forRows([&](uint32_t y) { row(pass_, y); });
    }

    // Guide planes hold values divided by their tolerance, so that the kernels add up squares.
    void loadGuides() {
        int count = 0;
        if (frame_.albedo) {
            loadGuide(frame_.albedo, 3, settings_.albedoTolerance, 0.0f, count);
            count += 3;
        }
        if (frame_.normal) {
            int channels = frame_.isTemporal ? 3 : 2;
            loadGuide(frame_.normal, channels, settings_.normalTolerance, -1.0f, count);
            count += channels;
        }
        pass_.guideCount = count;
        for (int g = 0; g < kMaxGuides; ++g)
            pass_.guides[g] = guides_[g];
    }
    void loadGuide(const Image& image, int channels, float tolerance, float least, int plane) {
        forPixels([&](uint32_t x, uint32_t y, size_t at) {
            float values[4] = {};
            readPixel(image, x, y, values);
            for (int c = 0; c < channels; ++c) {
                float value = isUsable(values[c]) ? values[c] : 0.0f;
                guides_[plane + c][at] = std::clamp(value, least, 1.0f) / tolerance;
            }
        });
    }
    Divisor divisorAt(size_t at) const {
        float albedo[3];
        for (int c = 0; c < 3; ++c)
            albedo[c] = guides_[c][at] * settings_.albedoTolerance;
        return Divisor(albedo);
    }

    void denoise(const Layer& layer, bool isFirst) {
        bool hasAlpha = channelsOf(layer.input.format) == 4;
        isDivided_ = isFirst && frame_.albedo && !frame_.isLimited;
        for (int c = 0; c < 3; ++c)
            scale_[c] = isFirst ? frame_.scale[c] : 1.0f;
        if (hasAlpha)
            loadAlpha(layer);
        pass_.hasAlpha = false;
        if (hasAlpha && frame_.alpha == AlphaMode::kSeparate)
            filterAlpha();
        pass_.hasAlpha = hasAlpha && frame_.alpha == AlphaMode::kTogether;
        loadColor(layer.input);
        Planes& result = smooth();
        Planes& other = &result == &a_ ? b_ : a_;
        if (pass_.hasAlpha)
            std::swap(alpha_, result.alpha);
        multiply(result);
        if (factor_ != 1)
            upsample(result, other);
        const Planes& present = factor_ == 1 ? result : large_;
        const Planes& blended = factor_ == 1 ? other : blended_;
        bool isBlended = frame_.isTemporal && frame_.hasPrevious;
        if (isBlended)
            blendHistory(layer, present, blended);
        write(layer, isBlended ? blended : present);
    }

    // From `from` to large_.
    void upsample(const Planes& from, const Planes& scratch) const {
        Upsampler upsampler{pass_.width,
                            pass_.height,
                            pass_.stride,
                            pass_.guideCount,
                            guides_,
                            from.color,
                            from.variance,
                            {scratch.color[0], scratch.color[1], scratch.color[2]},
                            {pass_.detail[0], pass_.detail[1], pass_.detail[2]},
                            outputStride_,
                            large_};
        forRows([&](uint32_t y) { upsampler.compressRow(y); });
        forRows([&](uint32_t y) { upsampler.tensorRow(y); });
        forRows([&](uint32_t y) { upsampler.upsampleRow(y); });
    }

    void loadAlpha(const Layer& layer) {
        bool isCopied = frame_.alpha == AlphaMode::kCopy;
        forPixels([&](uint32_t x, uint32_t y, size_t at) {
            float values[4] = {};
            readPixel(layer.input, x, y, values);
            bool keep = isCopied || isUsable(values[3]);
            alpha_[at] = keep ? values[3] : 1.0f;
        });
    }

    // Alpha as an image of its own, with the same guides.
    void filterAlpha() {
        forPixels([&](uint32_t, uint32_t, size_t at) {
            valid_[at] = 1.0f;
            a_.color[0][at] = std::clamp(alpha_[at], -kLargestColor, kLargestColor);
            a_.color[1][at] = 0.0f;
            a_.color[2][at] = 0.0f;
        });
        const Planes& result = smooth();
        forPixels([&](uint32_t, uint32_t, size_t at) { alpha_[at] = result.color[0][at]; });
    }

    void loadColor(const Image& image) {
        forPixels([&](uint32_t x, uint32_t y, size_t at) {
            float values[4] = {};
            readPixel(image, x, y, values);
            bool usable = isUsable(values[0]) && isUsable(values[1]) && isUsable(values[2]);
            valid_[at] = usable ? 1.0f : 0.0f;
            Divisor divisor = isDivided_ ? divisorAt(at) : Divisor({1, 1, 1});
            for (int c = 0; c < 3; ++c) {
                float value = usable ? values[c] : 0.0f;
                value = frame_.isLimited ? decoded(value) : value * scale_[c] / divisor.values[c];
                a_.color[c][at] = std::clamp(value, -kLargestColor, kLargestColor);
            }
        });
    }

    // From a_ to what is returned, one of a_ and b_.
    Planes& smooth() {
        const RowKernels& kernels = rowKernels();
        pass_.pilot = pilot_;
        run(kernels.repair, a_, b_);
        run(kernels.residual, b_, a_);
        run(kernels.spread, a_, b_);
        Planes* from = &b_;
        Planes* to = &a_;
        bool hasDetail = pass_.guideCount != 0;
        if (hasDetail) {
            run(kernels.detail, *from, *to);
            std::swap(from, to);
        }
        if (pass_.hasAlpha)
            forPixels([&](uint32_t, uint32_t, size_t at) { from->alpha[at] = alpha_[at]; });
        for (uint32_t i = 0; i < settings_.passes; ++i) {
            pass_.step = 1 << i;
            if (i > 0) // what is smooth already speaks for itself
                pass_.pilot = *from;
            run(kernels.smooth, *from, *to);
            std::swap(from, to);
        }
        if (hasDetail)
            forPixels([&](uint32_t, uint32_t, size_t at) {
                for (int c = 0; c < 3; ++c)
                    from->color[c][at] += pass_.detail[c][at];
            });
        return *from;
    }

    void multiply(const Planes& planes) const {
        if (!isDivided_)
            return;
        forPixels([&](uint32_t, uint32_t, size_t at) {
            Divisor divisor = divisorAt(at);
            float largest = 0.0f;
            for (int c = 0; c < 3; ++c) {
                planes.color[c][at] *= divisor.values[c];
                largest = std::max(largest, divisor.values[c]);
            }
            planes.variance[at] *= largest * largest;
        });
    }

    void blendHistory(const Layer& layer, const Planes& from, const Planes& to) const {
        History history{layer.previous,
                        frame_.flow,
                        factor_,
                        {scale_[0], scale_[1], scale_[2]},
                        settings_.historyWeight};
        uint32_t width = factor_ * pass_.width, height = factor_ * pass_.height;
        parallelFor(height, kRowsPerTask, [&](size_t begin, size_t end) {
            for (size_t y = begin; y < end; ++y)
                history.blendRow(uint32_t(y), width, height, outputStride_, from, to);
        });
    }

    void write(const Layer& layer, const Planes& from) const {
        const Image& output = layer.output;
        parallelFor(output.height, kRowsPerTask, [&](size_t begin, size_t end) {
            for (size_t y = begin; y < end; ++y)
                for (uint32_t x = 0; x < output.width; ++x)
                    writeOne(layer, from, x, uint32_t(y));
        });
    }
    void writeOne(const Layer& layer, const Planes& from, uint32_t x, uint32_t y) const {
        uint32_t largeX = x + factor_ * frame_.offsetX, largeY = y + factor_ * frame_.offsetY;
        size_t at = largeY * outputStride_ + largeX;
        float values[4] = {0, 0, 0, 1};
        for (int c = 0; c < 3; ++c) {
            float value = from.color[c][at];
            values[c] = frame_.isLimited ? std::min(encoded(value), 1.0f) : value / scale_[c];
        }
        if (channelsOf(layer.input.format) == 4)
            values[3] = factor_ == 1 ? alpha_[at] : alphaBetween(largeX, largeY);
        if (frame_.blend != 0.0f) {
            float given[4] = {0, 0, 0, 1};
            readPixel(layer.input, largeX / factor_, largeY / factor_, given);
            for (int c = 0; c < 4; ++c)
                if (isUsable(given[c]))
                    values[c] += (given[c] - values[c]) * frame_.blend;
        }
        writePixel(layer.output, x, y, values);
    }
    // Bilinear, at a pixel of an output twice as large.
    float alphaBetween(uint32_t x, uint32_t y) const {
        auto other = [](uint32_t large, uint32_t size) {
            uint32_t own = large / 2;
            return large % 2 ? std::min(own + 1, size - 1) : own - std::min(own, 1u);
        };
        size_t row = y / 2 * pass_.stride, otherRow = other(y, pass_.height) * pass_.stride;
        size_t column = x / 2, otherColumn = other(x, pass_.width);
        return 0.75f * (0.75f * alpha_[row + column] + 0.25f * alpha_[row + otherColumn]) +
               0.25f * (0.75f * alpha_[otherRow + column] + 0.25f * alpha_[otherRow + otherColumn]);
    }

    const Frame& frame_;
    const FilterSettings& settings_;
    uint32_t factor_;
    const Image& first_;
    Pass pass_;
    float* next_ = nullptr;
    Planes a_, b_;
    Planes pilot_{}; // without alpha
    // Factor 2: the upsampled image, and the same with the previous image blended in.
    Planes large_{}, blended_{};
    size_t outputStride_;
    float* guides_[kMaxGuides];
    float* valid_ = nullptr;
    float* alpha_ = nullptr;
    float scale_[3] = {1, 1, 1};
    bool isDivided_ = false;
};

} // namespace

uint32_t GuidedFilter::overlap() const {
    uint32_t reach =
        kRepairRadius + kResidualRadius + std::max(kSpreadRadius, kDetailRadius) + kHistoryRadius;
    for (uint32_t i = 0; i < settings_.passes; ++i)
        reach += 2u << i;
    if (factor_ != 1)
        reach += kUpsamplerRadius;
    return (reach + 7) / 8 * 8;
}

size_t GuidedFilter::scratchSize(uint32_t width, uint32_t height) const {
    size_t floats = kPlaneCount * planeSize(width, height);
    if (factor_ != 1)
        floats += kLargePlaneCount * planeSize(factor_ * width, factor_ * height);
    return floats * sizeof(float) + kAlignment;
}

void GuidedFilter::run(const Frame& frame, void* scratch) const {
    SUNSTONE_CHECK(settings_.passes >= 1 && settings_.passes <= kMaxPasses);
    SUNSTONE_CHECK(!frame.layers.empty());
    Run(frame, settings_, factor_, scratch).all();
}

} // namespace sunstone::denoise
