// SPDX-License-Identifier: Apache-2.0
#include "denoise/gpu/gpu_denoiser.h"

#include "base/error.h"
#include "denoise/gpu/kernels_ptx.h"

#include <atomic>
#include <new>

namespace sunstone::denoise::gpu {
namespace {

constexpr uint64_t kMostPixels = uint64_t(1) << 30;
constexpr int kSteps = -1; // the module of step_kernels.cu

// Of filter_kernels.cu.
constexpr const char* kDetail = "sunstone_detail"; // where there are guides
constexpr const char* kSmoothAlpha = "sunstone_smooth_alpha";
constexpr const char* kRowKernels[] = {"sunstone_repair", "sunstone_residual", "sunstone_spread",
                                       kDetail,           "sunstone_smooth",   kSmoothAlpha};
// Of step_kernels.cu.
constexpr const char* kBegin = "sunstone_begin";
struct LogKernels {
    const char *pixels, *blocks;
};
constexpr LogKernels kLuminance = {"sunstone_luminance", "sunstone_luminance_blocks"};
constexpr LogKernels kColors = {"sunstone_colors", "sunstone_colors_blocks"};
constexpr const char* kStepKernels[] = {"sunstone_guides",
                                        "sunstone_alpha",
                                        "sunstone_alpha_as_color",
                                        "sunstone_color_as_alpha",
                                        "sunstone_color",
                                        "sunstone_restore",
                                        "sunstone_compress",
                                        "sunstone_tensor",
                                        "sunstone_upsample",
                                        "sunstone_blend",
                                        "sunstone_write",
                                        kBegin,
                                        kLuminance.pixels,
                                        kLuminance.blocks,
                                        kColors.pixels,
                                        kColors.blocks};

bool isRow(Step step) {
    return step >= Step::kRepair && step <= Step::kSmooth;
}

const char* kernelOf(Step step, const Job& job) {
    const size_t number = size_t(step), rowBegin = size_t(Step::kRepair),
                 rowEnd = size_t(Step::kSmooth) + 1;
    if (step == Step::kSmooth && job.pass.hasAlpha)
        return kSmoothAlpha;
    if (isRow(step))
        return kRowKernels[number - rowBegin];
    return kStepKernels[number < rowBegin ? number : number - (rowEnd - rowBegin)];
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
        const CUfunction kernel = denoiser_.kernel(kSteps, kBegin);
        denoiser_.check(denoiser_.driver_.launchKernel(kernel, 1, 1, 1, 1, 1, 1, 0, stream_,
                                                       arguments, nullptr),
                        kBegin);
    }
    void run(Step step, const Job& job, uint32_t width, uint32_t height) override {
        const char* name = kernelOf(step, job);
        void* arguments[] = {const_cast<Job*>(&job), &width, &height};
        denoiser_.launch(stream_,
                         denoiser_.kernel(isRow(step) ? job.pass.guideCount : kSteps, name), name,
                         tilesAcross(width) * tilesDown(height), arguments);
    }

private:
    GpuDenoiser& denoiser_;
    CUstream stream_;
    CallInputs inputs_;
};

GpuDenoiser::GpuDenoiser(const device::cuda::Driver& driver) : driver_(driver) {
    // With unified addresses, which every GPU of today has, kernels use the host's pointer.
    void* report = nullptr;
    check(driver_.memAllocHost(&report, sizeof(Report)), "cuMemAllocHost");
    report_ = new (report) Report{};
}

GpuDenoiser::~GpuDenoiser() {
    for (auto& [guides, module] : modules_)
        if (module.module)
            driver_.moduleUnload(module.module);
    if (report_)
        driver_.memFreeHost(report_);
}

void GpuDenoiser::check(CUresult result, const char* what) const {
    if (result == CUDA_SUCCESS)
        return;
    const char* name = nullptr;
    driver_.getErrorName(result, &name);
    fail(result == CUDA_ERROR_OUT_OF_MEMORY ? Code::kOutOfMemory : Code::kCudaError, what, ": ",
         name ? name : "unknown error", " (", int(result), ")");
}

CUfunction GpuDenoiser::kernel(int guides, const char* name) {
    std::lock_guard lock(mutex_);
    Module& module = modules_[guides];
    if (!module.module)
        check(driver_.moduleLoadDataEx(&module.module,
                                       guides == kSteps ? stepKernels() : filterKernels(guides), 0,
                                       nullptr, nullptr),
              "cuModuleLoadDataEx");
    CUfunction& found = module.kernels[name];
    if (!found)
        check(driver_.moduleGetFunction(&found, module.module, name), name);
    return found;
}

void GpuDenoiser::launch(CUstream stream, CUfunction kernel, const char* name, uint32_t blocks,
                         void** arguments) const {
    check(driver_.launchKernel(kernel, blocks, 1, 1, kTileWidth, kTileHeight, 1, 0, stream,
                               arguments, nullptr),
          name);
}

void GpuDenoiser::prepare(int guides) {
    const auto load = [&](int module, const char* name) {
        int registers = 0; // asking for them makes a driver load what it had left for later
        check(
            driver_.funcGetAttribute(&registers, CU_FUNC_ATTRIBUTE_NUM_REGS, kernel(module, name)),
            "cuFuncGetAttribute");
    };
    for (const char* name : kStepKernels)
        load(kSteps, name);
    for (const char* name : kRowKernels)
        if (guides != 0 || name != kDetail)
            load(guides, name);
}

void GpuDenoiser::setUp(CUstream stream, CUdeviceptr state, uint32_t width, uint32_t height) {
    const State value{kStateMagic, width, height};
    // Pageable memory: the driver has copied it when the call returns.
    check(driver_.memcpyHtoDAsync(state, &value, sizeof(value), stream), "cuMemcpyHtoDAsync");
}

void GpuDenoiser::filter(CUstream stream, const Filter& filter, const Frame& frame, void* scratch,
                         const CallInputs& inputs) {
    // Threads count bytes of a plane in 32 bits (rows_body.h).
    const uint64_t width = uint64_t(inputs.width) + 15, factor = filter.factor();
    if (factor * width * factor * inputs.height > kMostPixels)
        fail(Code::kNotSupported, "inputs of ", inputs.width, " x ", inputs.height,
             " pixels: a GPU denoises outputs of up to ", kMostPixels,
             " pixels at once; larger ones can be denoised in tiles");
    GpuSteps steps(*this, stream, inputs);
    filter.run(frame, scratch, steps);
}

void GpuDenoiser::addLogs(CUstream stream, const char* pixels, const char* blocks,
                          const Image& image, void* scratch, float* result) {
    const uint64_t count = uint64_t(image.width) * image.height;
    uint32_t blockCount = std::min(tilesDown(image.height), kMostLogBlocks);
    if (count < kPixelsForBlocks)
        blockCount = 1;
    const uintptr_t address = reinterpret_cast<uintptr_t>(scratch);
    auto* sums = reinterpret_cast<LogSum*>((address + alignof(LogSum) - 1) / alignof(LogSum) *
                                           alignof(LogSum));
    void* arguments[] = {const_cast<Image*>(&image), &sums, &result};
    launch(stream, kernel(kSteps, pixels), pixels, blockCount, arguments);
    if (blockCount == 1)
        return;
    void* rest[] = {&sums, &blockCount, &result};
    launch(stream, kernel(kSteps, blocks), blocks, 1, rest);
}

void GpuDenoiser::intensity(CUstream stream, const Image& image, void* scratch, float* result) {
    addLogs(stream, kLuminance.pixels, kLuminance.blocks, image, scratch, result);
}

void GpuDenoiser::averageColor(CUstream stream, const Image& image, void* scratch, float* result) {
    addLogs(stream, kColors.pixels, kColors.blocks, image, scratch, result);
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
