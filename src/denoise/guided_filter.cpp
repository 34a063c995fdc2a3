// SPDX-License-Identifier: Apache-2.0
#include "denoise/guided_filter.h"

#include "denoise/history.h"

#include "base/error.h"

#include <algorithm>
#include <utility>

namespace sunstone::denoise {
namespace {

constexpr size_t kPlaneCount = 25;
constexpr size_t kLargePlaneCount = 7; // of the output's size, where that is larger
// More lets the upsampler sharpen noise, less removes relief (tests/denoise, tests/api76).
constexpr float kMostReturnedBeforeUpsampling = 0.78f;

size_t rowStride(uint32_t width) {
    return (size_t(width) + 15) / 16 * 16;
}
size_t planeSize(uint32_t width, uint32_t height) {
    return rowStride(width) * height;
}

// The order of the steps, and the planes that each of them reads and writes.
class Run {
public:
    Run(const Frame& frame, const FilterSettings& settings, uint32_t factor, void* scratch,
        StepRunner& runner)
        : frame_(frame), settings_(settings), factor_(factor), runner_(runner) {
        const Image& first = frame.layers.at(0).input;
        pass_.width = first.width;
        pass_.height = first.height;
        pass_.stride = rowStride(first.width);
        pass_.colorTolerance = settings.colorTolerance * settings.colorTolerance;
        control_ = controlIn(scratch);
        next_ = reinterpret_cast<float*>(reinterpret_cast<uint8_t*>(control_) + kScratchAlignment);
        takePlanes();
        setUp(first);
    }

    void all() {
        runner_.begin(*control_);
        if (pass_.guideCount != 0)
            run(Step::kGuides);
        for (size_t i = 0; i < frame_.layers.size(); ++i)
            denoise(frame_.layers[i], i == 0);
    }

private:
    float* takePlane(uint32_t factor = 1) {
        float* plane = next_;
        next_ += planeSize(factor * pass_.width, factor * pass_.height);
        return plane;
    }
    void takePlanes() {
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
        for (int g = 0; g < kMaxGuides; ++g)
            pass_.guides[g] = job_.guides[g] = takePlane();
        pass_.valid = job_.valid = takePlane();
        alpha_ = takePlane();
        if (factor_ == 1)
            return;
        for (float** plane :
             {&large_.color[0], &large_.color[1], &large_.color[2], &large_.variance,
              &blended_.color[0], &blended_.color[1], &blended_.color[2]})
            *plane = takePlane(factor_);
    }

    // The part of a job that is the same for all steps.
    void setUp(const Image& first) {
        job_.control = control_;
        job_.albedo = frame_.albedo;
        job_.normal = frame_.normal;
        job_.flow = frame_.flow;
        job_.factor = factor_;
        job_.outputStride = uint32_t(rowStride(factor_ * first.width));
        job_.offsetX = frame_.offsetX;
        job_.offsetY = frame_.offsetY;
        job_.albedoTolerance = settings_.albedoTolerance;
        job_.normalTolerance = settings_.normalTolerance;
        job_.historyWeight = settings_.historyWeight;
        job_.blend = frame_.blend;
        job_.normalChannels = frame_.isTemporal ? 3 : 2;
        job_.keepsAlpha = frame_.alpha == AlphaMode::kCopy;
        job_.isLimited = frame_.isLimited;
        pass_.guideCount = (frame_.albedo ? 3 : 0) + (frame_.normal ? job_.normalChannels : 0);
        job_.hasDetail = pass_.guideCount != 0;
    }

    void run(Step step, uint32_t width, uint32_t height) {
        job_.pass = pass_;
        job_.alpha = alpha_;
        runner_.run(step, job_, width, height);
    }
    void run(Step step) { run(step, pass_.width, pass_.height); }
    void run(Step step, const Planes& from, const Planes& to) {
        pass_.from = from;
        pass_.to = to;
        run(step);
    }

    void denoise(const Layer& layer, bool isFirst) {
        job_.input = layer.input;
        job_.previous = layer.previous;
        job_.output = layer.output;
        job_.isScaled = isFirst;
        const bool hasAlpha = channelsOf(layer.input.format) == 4;
        if (hasAlpha)
            run(Step::kAlpha);
        pass_.hasAlpha = false;
        job_.isDivided = false;
        if (hasAlpha && frame_.alpha == AlphaMode::kSeparate)
            filterAlpha();
        pass_.hasAlpha = hasAlpha && frame_.alpha == AlphaMode::kTogether;
        job_.isDivided = isFirst && frame_.albedo && !frame_.isLimited;
        run(Step::kColor, {}, a_);
        Planes& result = smooth();
        Planes& other = &result == &a_ ? b_ : a_;
        restore(result);
        if (factor_ != 1)
            upsample(result, other);
        const Planes& present = factor_ == 1 ? result : large_;
        const Planes& blended = factor_ == 1 ? other : blended_;
        const bool isBlended = frame_.isTemporal && frame_.hasPrevious;
        pass_.from = present;
        pass_.to = blended;
        if (isBlended)
            run(Step::kBlend, factor_ * pass_.width, factor_ * pass_.height);
        pass_.from = isBlended ? blended : present;
        run(Step::kWrite, layer.output.width, layer.output.height);
    }

    void filterAlpha() {
        run(Step::kAlphaAsColor, {}, a_);
        const Planes& result = smooth();
        restore(result);
        run(Step::kColorAsAlpha, result, {});
    }

    // Smooths a_ and returns the result, a_ or b_, still without detail.
    Planes& smooth() {
        pass_.pilot = pilot_;
        run(Step::kRepair, a_, b_);
        run(Step::kResidual, b_, a_);
        // The residual is in the variance of a_; colours are still in b_.
        run(Step::kSpread, a_, b_);
        Planes* from = &b_;
        Planes* to = &a_;
        if (job_.hasDetail) {
            run(Step::kDetail, *from, *to);
            std::swap(from, to);
        }
        if (pass_.hasAlpha)
            std::swap(alpha_, from->alpha);
        Planes* const given = from;
        for (uint32_t i = 0; i < settings_.passes; ++i) {
            pass_.step = 1 << i;
            if (i > 0) // smoothed colours are their own pilot
                pass_.pilot = *from;
            run(Step::kSmooth, *from, *to);
            if (i == 0) { // the colours given stay; their alpha is not needed any more
                pilot_.alpha = std::exchange(given->alpha, nullptr);
                from = &pilot_;
            }
            std::swap(from, to);
        }
        if (pass_.hasAlpha)
            std::swap(alpha_, from->alpha);
        returnStructure(*from, *given, *to);
        given->alpha = std::exchange(pilot_.alpha, nullptr);
        return *from;
    }

    // Returns structure: the part of `given` that the passes removed beside noise, into `smooth`.
    void returnStructure(const Planes& smooth, const Planes& given, const Planes& scratch) {
        pass_.mostReturned = factor_ == 1 ? 1.0f : kMostReturnedBeforeUpsampling;
        pass_.pilot = given;
        pass_.sums[0] = given.variance;
        pass_.sums[1] = job_.valid;
        for (Step step : {Step::kLoss, Step::kCorrelate, Step::kGather, Step::kSumRow,
                          Step::kMeanOfBox, Step::kReturn})
            run(step, smooth, scratch);
    }

    void restore(const Planes& planes) {
        if (job_.hasDetail || job_.isDivided)
            run(Step::kRestore, planes, planes);
    }

    // Upsamples `from` to large_.
    void upsample(const Planes& from, const Planes& scratch) {
        Upsampler& upsampler = job_.upsampler;
        upsampler.width = pass_.width;
        upsampler.height = pass_.height;
        upsampler.stride = pass_.stride;
        upsampler.guideCount = pass_.guideCount;
        std::copy_n(pass_.guides, kMaxGuides, upsampler.guides);
        for (int c = 0; c < 3; ++c) {
            upsampler.color[c] = from.color[c];
            upsampler.compressed[c] = scratch.color[c];
            upsampler.tensor[c] = pass_.detail[c];
        }
        upsampler.variance = from.variance;
        upsampler.outputStride = job_.outputStride;
        upsampler.to = large_;
        run(Step::kCompress);
        run(Step::kTensor);
        run(Step::kUpsample);
    }

    const Frame& frame_;
    const FilterSettings& settings_;
    uint32_t factor_;
    StepRunner& runner_;
    Job job_{};
    Pass pass_{};
    Control* control_ = nullptr;
    float* next_ = nullptr;
    Planes a_{}, b_{};
    Planes pilot_{}; // without alpha
    // Factor 2: the upsampled image, and the same with the previous image blended in.
    Planes large_{}, blended_{};
    float* alpha_ = nullptr;
};

} // namespace

uint32_t GuidedFilter::overlap() const {
    int reach = kRepairRadius + kResidualRadius + std::max(kSpreadRadius, kDetailRadius) +
                kHistoryRadius + kCorrelateRadius + kGatherRadius;
    for (uint32_t i = 0; i < settings_.passes; ++i)
        reach += 2 << i;
    if (factor_ != 1)
        reach += kUpsamplerRadius;
    return uint32_t(reach + 7) / 8 * 8;
}

size_t GuidedFilter::scratchSize(uint32_t width, uint32_t height) const {
    size_t floats = kPlaneCount * planeSize(width, height);
    if (factor_ != 1)
        floats += kLargePlaneCount * planeSize(factor_ * width, factor_ * height);
    return floats * sizeof(float) + 2 * kScratchAlignment;
}

void GuidedFilter::run(const Frame& frame, void* scratch, StepRunner& runner) const {
    SUNSTONE_CHECK(settings_.passes >= 1 && settings_.passes <= kMaxPasses);
    SUNSTONE_CHECK(!frame.layers.empty());
    Run(frame, settings_, factor_, scratch, runner).all();
}

} // namespace sunstone::denoise
