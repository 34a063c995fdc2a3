// SPDX-License-Identifier: Apache-2.0
// Runs a filter's steps on the threads of the CPU, row by row.
#include "denoise/filter.h"
#include "denoise/steps.h"

#include "base/threads/threads.h"

namespace sunstone::denoise {
namespace {

constexpr size_t kRowsPerTask = 4;

class CpuSteps final : public StepRunner {
public:
    explicit CpuSteps(const Frame& frame) : frame_(frame) {}

    void begin(Control& control) override {
        std::copy_n(frame_.scale, 3, control.scale);
        control.isRefused = 0;
    }

    void run(Step step, const Job& job, uint32_t width, uint32_t height) override {
        const auto pixels = [&](auto body) {
            rows(height, [&](uint32_t y) {
                for (uint32_t x = 0; x < width; ++x)
                    body(x, y);
            });
        };
        const auto jobPixels = [&](auto body) {
            pixels([&](uint32_t x, uint32_t y) { body(job, x, y); });
        };
        const auto upsamplerPixels = [&](auto body) {
            pixels([&](uint32_t x, uint32_t y) { body(job.upsampler, x, y); });
        };
        const auto rowsBy = [&](auto row) { rows(height, [&](uint32_t y) { row(job.pass, y); }); };
#define SUNSTONE_CALL(function) [](const auto&... all) { function(all...); }
        switch (step) {
        case Step::kGuides:
            return jobPixels(SUNSTONE_CALL(loadGuides));
        case Step::kAlpha:
            return jobPixels(SUNSTONE_CALL(loadAlpha));
        case Step::kAlphaAsColor:
            return jobPixels(SUNSTONE_CALL(alphaAsColor));
        case Step::kColorAsAlpha:
            return jobPixels(SUNSTONE_CALL(colorAsAlpha));
        case Step::kColor:
            return jobPixels(SUNSTONE_CALL(loadColor));
        case Step::kRepair:
            return rowsBy(rowKernels().repair);
        case Step::kResidual:
            return rowsBy(rowKernels().residual);
        case Step::kSpread:
            return rowsBy(rowKernels().spread);
        case Step::kDetail:
            return rowsBy(rowKernels().detail);
        case Step::kSmooth:
            return rowsBy(rowKernels().smooth);
        case Step::kLoss:
            return rowsBy(rowKernels().loss);
        case Step::kCorrelate:
            return rowsBy(rowKernels().correlate);
        case Step::kGather:
            return rowsBy(rowKernels().gather);
        case Step::kSumRow:
            return rowsBy(rowKernels().sumRow);
        case Step::kMeanOfBox:
            return rowsBy(rowKernels().meanOfBox);
        case Step::kReturn:
            return rowsBy(rowKernels().giveBack);
        case Step::kRestore:
            return jobPixels(SUNSTONE_CALL(restoreColor));
        case Step::kCompress:
            return upsamplerPixels(SUNSTONE_CALL(compressPixel));
        case Step::kTensor:
            return upsamplerPixels(SUNSTONE_CALL(tensorPixel));
        case Step::kUpsample:
            return upsamplerPixels(SUNSTONE_CALL(upsamplePixel));
        case Step::kBlend:
            return jobPixels(SUNSTONE_CALL(blendHistory));
        case Step::kWrite:
            return jobPixels(SUNSTONE_CALL(writeColor));
        case Step::kToneMap:
            return jobPixels(SUNSTONE_CALL(toneMap));
        case Step::kStructure:
            return jobPixels(SUNSTONE_CALL(compareStructure));
        case Step::kCount:
            return;
        }
#undef SUNSTONE_CALL
    }

private:
    template <class Body>
    static void rows(uint32_t height, Body body) {
        parallelFor(height, kRowsPerTask, [&](size_t begin, size_t end) {
            for (size_t y = begin; y < end; ++y)
                body(uint32_t(y));
        });
    }

    const Frame& frame_;
};

} // namespace

void Filter::run(const Frame& frame, void* scratch) const {
    CpuSteps steps(frame);
    run(frame, scratch, steps);
}

} // namespace sunstone::denoise
