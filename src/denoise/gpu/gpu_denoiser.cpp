// SPDX-License-Identifier: Apache-2.0
#include "denoise/gpu/gpu_denoiser.h"

#include "base/error.h"
#include "denoise/gpu/kernels_ptx.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <new>

namespace sunstone::denoise::gpu {
namespace {

constexpr uint64_t kMostPixels = uint64_t(1) << 30;
// Kernels of step_kernels.cu; the first ones in the order of Step, without the rows.
enum StepKernel : uint32_t {
    kToneMap = 17,
    kStructure,
    kBegin,
    kLuminance,
    kLuminanceBlocks,
    kColors,
    kColorsBlocks,
    kStepKernelCount
};
constexpr const char* kStepKernels[] = {"sunstone_guides",
                                        "sunstone_alpha",
                                        "sunstone_alpha_as_color",
                                        "sunstone_color_as_alpha",
                                        "sunstone_color",
                                        "sunstone_loss",
                                        "sunstone_correlate",
                                        "sunstone_gather",
                                        "sunstone_sum_row",
                                        "sunstone_mean_of_box",
                                        "sunstone_return",
                                        "sunstone_restore",
                                        "sunstone_compress",
                                        "sunstone_tensor",
                                        "sunstone_upsample",
                                        "sunstone_blend",
                                        "sunstone_write",
                                        "sunstone_tone_map",
                                        "sunstone_structure",
                                        "sunstone_begin",
                                        "sunstone_luminance",
                                        "sunstone_luminance_blocks",
                                        "sunstone_colors",
                                        "sunstone_colors_blocks"};
static_assert(std::size(kStepKernels) == kStepKernelCount);

// Kernels of filter_kernels.cu, once for each number of guides; the first ones in the order of
// Step.
enum RowKernel : uint32_t { kDetail = 3, kSmoothAlpha = 5, kRowKernelCount };
constexpr const char* kRowKernels[] = {"sunstone_repair", "sunstone_residual",
                                       "sunstone_spread", "sunstone_detail",
                                       "sunstone_smooth", "sunstone_smooth_alpha"};
static_assert(std::size(kRowKernels) == kRowKernelCount);
constexpr int kGuides[] = {0, 2, 3, 5, 6}; // planes of them

bool isRow(Step step) {
    return step >= Step::kRepair && step <= Step::kSmooth;
}

// Places in the set of all kernels: the steps', then rows for each number of guides.
uint32_t firstRowOf(int guides) {
    const auto found = std::find(std::begin(kGuides), std::end(kGuides), guides);
    if (found == std::end(kGuides))
        fail(Code::kInternal, "there are no kernels for ", guides, " planes of guides");
    return kStepKernelCount + uint32_t(found - kGuides) * kRowKernelCount;
}
uint32_t kernelOf(Step step, const Job& job) {
    const uint32_t number = uint32_t(step), rowBegin = uint32_t(Step::kRepair),
                   rowEnd = uint32_t(Step::kSmooth) + 1;
    if (step == Step::kSmooth && job.pass.hasAlpha)
        return firstRowOf(job.pass.guideCount) + kSmoothAlpha;
    if (isRow(step))
        return firstRowOf(job.pass.guideCount) + number - rowBegin;
    return number < rowBegin ? number : number - (rowEnd - rowBegin);
}

std::vector<device::cuda::KernelSource> kernelSources() {
    std::vector<device::cuda::KernelSource> sources;
    const auto add = [&](const char* name, const std::string& id, const char* text) {
        sources.push_back(
            {name, id, [=] { return device::cuda::KernelTexts(text).moduleOf(name); }});
    };
    for (const char* name : kStepKernels)
        add(name, message("denoiser ", name), stepKernels());
    for (const int guides : kGuides)
        for (const char* name : kRowKernels)
            add(name, message("denoiser ", name, " ", guides), filterKernels(guides));
    return sources;
}

} // namespace

// Queues a kernel for each step.
class GpuSteps final : public StepRunner {
public:
    GpuSteps(GpuDenoiser& denoiser, CUstream stream, const CallInputs& inputs)
        : denoiser_(denoiser), stream_(stream), inputs_(inputs) {}

    void begin(Control& control) override {
        Control* to = &control;
        auto stream = reinterpret_cast<uint64_t>(stream_);
        void* arguments[] = {&inputs_, &to, &denoiser_.report_, &stream};
        denoiser_.check(denoiser_.driver_.launchKernel(denoiser_.kernels_.function(kBegin), 1, 1, 1,
                                                       1, 1, 1, 0, stream_, arguments, nullptr),
                        kStepKernels[kBegin]);
    }
    void run(Step step, const Job& job, uint32_t width, uint32_t height) override {
        void* arguments[] = {const_cast<Job*>(&job), &width, &height};
        denoiser_.launch(stream_, kernelOf(step, job), tilesAcross(width) * tilesDown(height),
                         arguments);
    }

private:
    GpuDenoiser& denoiser_;
    CUstream stream_;
    CallInputs inputs_;
};

GpuDenoiser::GpuDenoiser(const device::cuda::Driver& driver, device::cuda::MachineCodeSource* code)
    : driver_(driver), kernels_(driver, code, kernelSources()) {
    // With unified addresses, which all current GPUs have, kernels use the host's pointer.
    void* report = nullptr;
    check(driver_.memAllocHost(&report, sizeof(Report)), "cuMemAllocHost");
    report_ = new (report) Report{};
}

GpuDenoiser::~GpuDenoiser() {
    if (report_)
        driver_.memFreeHost(report_);
}

void GpuDenoiser::abandon() {
    kernels_.abandon();
    report_ = nullptr;
}

void GpuDenoiser::check(CUresult result, const char* what) const {
    device::cuda::check(driver_, result, what);
}

void GpuDenoiser::launch(CUstream stream, uint32_t kernel, uint32_t blocks, void** arguments) {
    check(driver_.launchKernel(kernels_.function(kernel), blocks, 1, 1, kTileWidth, kTileHeight, 1,
                               0, stream, arguments, nullptr),
          kernels_.source(kernel).name.c_str());
}

void GpuDenoiser::prepare(int guides) {
    std::vector<uint32_t> needed;
    for (uint32_t kernel = 0; kernel < kStepKernelCount; ++kernel)
        if (kernel != kToneMap && kernel != kStructure) // of other filters
            needed.push_back(kernel);
    const uint32_t rows = firstRowOf(guides);
    for (uint32_t kernel = 0; kernel < kRowKernelCount; ++kernel)
        if (guides != 0 || kernel != kDetail) // exists only with guides
            needed.push_back(rows + kernel);
    kernels_.prepare(needed);
}

void GpuDenoiser::prepareAll() {
    for (const int guides : kGuides)
        prepare(guides);
}

void GpuDenoiser::setUp(CUstream stream, CUdeviceptr state, uint32_t width, uint32_t height) {
    const State value{kStateMagic, width, height};
    // Pageable memory: the driver has copied it when the call returns.
    check(driver_.memcpyHtoDAsync(state, &value, sizeof(value), stream), "cuMemcpyHtoDAsync");
}

void GpuDenoiser::filter(CUstream stream, const Filter& filter, const Frame& frame, void* scratch,
                         const CallInputs& inputs) {
    // Threads count bytes of a plane in 32 bits (rows/rows_body.h).
    const uint64_t width = uint64_t(inputs.width) + 15, factor = filter.factor();
    if (factor * width * factor * inputs.height > kMostPixels)
        fail(Code::kNotSupported, "inputs of ", inputs.width, " x ", inputs.height,
             " pixels: a GPU denoises outputs of up to ", kMostPixels,
             " pixels at once; larger ones can be denoised in tiles");
    GpuSteps steps(*this, stream, inputs);
    filter.run(frame, scratch, steps);
}

void GpuDenoiser::addLogs(CUstream stream, uint32_t pixels, uint32_t blocks, const Image& image,
                          void* scratch, float* result) {
    const uint64_t count = uint64_t(image.width) * image.height;
    uint32_t blockCount = std::min(tilesDown(image.height), kMostLogBlocks);
    if (count < kPixelsForBlocks)
        blockCount = 1;
    const uintptr_t address = reinterpret_cast<uintptr_t>(scratch);
    auto* sums = reinterpret_cast<LogSum*>((address + alignof(LogSum) - 1) / alignof(LogSum) *
                                           alignof(LogSum));
    void* arguments[] = {const_cast<Image*>(&image), &sums, &result};
    launch(stream, pixels, blockCount, arguments);
    if (blockCount == 1)
        return;
    void* rest[] = {&sums, &blockCount, &result};
    launch(stream, blocks, 1, rest);
}

void GpuDenoiser::intensity(CUstream stream, const Image& image, void* scratch, float* result) {
    addLogs(stream, kLuminance, kLuminanceBlocks, image, scratch, result);
}

void GpuDenoiser::averageColor(CUstream stream, const Image& image, void* scratch, float* result) {
    addLogs(stream, kColors, kColorsBlocks, image, scratch, result);
}

std::vector<GpuDenoiser::Refusal> GpuDenoiser::takeRefusals() {
    std::vector<Refusal> refusals;
    std::lock_guard lock(mutex_);
    for (;;) {
        const Report::Entry& entry = report_->entries[refusalsTold_ % Report::kEntries];
        const uint32_t number = const_cast<const volatile uint32_t&>(entry.number);
        if (number <= refusalsTold_)
            return refusals;
        std::atomic_thread_fence(std::memory_order_acquire);
        refusals.push_back(
            {reinterpret_cast<CUstream>(entry.stream), describe(entry.inputs, entry.finding)});
        refusalsTold_ = number;
    }
}

} // namespace sunstone::denoise::gpu
