// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu_launch_slots.h"

#include "base/error.h"
#include "engine/exceptions.h"

namespace sunstone::engine {
namespace {

using namespace device::cuda;

std::string nameOfFatal(int32_t code) {
    switch (code) {
    case devlib::kFatalRaygenRecord:
        return "the ray generation record holds no such program group of the pipeline";
    case devlib::kFatalExceptionRecord:
        return "the exception record holds no such program group of the pipeline";
    case devlib::kFatalGraphTooDeep:
        return message("the traversable graph is deeper than ", devlib::kMaxGpuGraphDepth + 1,
                       ", which is the limit on GPUs");
    case devlib::kFatalMotionTransform:
        return "motion transforms are not available on GPUs yet";
    default: {
        devlib::ThreadState thread{};
        thread.exceptionCode = code;
        return describeException(thread);
    }
    }
}

// A word of LaunchReport as text, or empty.
std::string describe(uint64_t word, const devlib::LaunchState& launch) {
    if (word == devlib::kNoReport)
        return {};
    const uint64_t place = word >> 32, width = launch.dimensions[0], height = launch.dimensions[1];
    return message(nameOfFatal(int32_t(uint32_t(word))), ", at launch index (", place % width, ", ",
                   place / width % height, ", ", place / width / height, ")");
}

} // namespace

GpuLaunchSlots::~GpuLaunchSlots() {
    try {
        ContextScope scope(context_);
        for (auto& slot : slots_) {
            if (slot->busy && driver().eventSynchronize(slot->done) == CUDA_SUCCESS)
                settle(*slot);
            driver().memFree(slot->memory);
            driver().memFreeHost(slot->host);
            driver().eventDestroy(slot->done);
        }
    } catch (const Error&) { // the application has destroyed its context, and all memory with it
    }
}

GpuLaunchSlots::Slot& GpuLaunchSlots::take(size_t parameterBytes) {
    std::lock_guard lock(mutex_);
    for (auto& slot : slots_) {
        if (slot->busy && slot->number != 0 && driver().eventQuery(slot->done) == CUDA_SUCCESS)
            settle(*slot);
        if (!slot->busy && slot->capacity >= parameterBytes) {
            slot->busy = true;
            slot->number = 0;
            return *slot;
        }
    }
    auto slot = std::make_unique<Slot>();
    slot->capacity = (parameterBytes + 1023) / 1024 * 1024;
    SUNSTONE_CU(memAlloc, &slot->memory, kParameters + slot->capacity + 64);
    void* host = nullptr;
    SUNSTONE_CU(memAllocHost, &host, sizeof(devlib::LaunchBlock));
    slot->host = static_cast<devlib::LaunchBlock*>(host);
    SUNSTONE_CU(eventCreate, &slot->done, CU_EVENT_DISABLE_TIMING);
    slot->busy = true;
    slots_.push_back(std::move(slot));
    return *slots_.back();
}

void GpuLaunchSlots::started(Slot& slot, CUstream stream) {
    SUNSTONE_CU(eventRecord, slot.done, stream);
    std::lock_guard lock(mutex_);
    slot.number = ++launches_;
}

std::string GpuLaunchSlots::finish(Slot& slot) {
    SUNSTONE_CU(eventSynchronize, slot.done);
    std::lock_guard lock(mutex_);
    std::string failure = failureOf(slot, true);
    settle(slot);
    return failure;
}

std::string GpuLaunchSlots::failureOf(const Slot& slot, bool validation) {
    const devlib::LaunchReport& report = slot.host->report;
    std::string text = describe(report.fatal, slot.host->launch);
    if (text.empty() && validation)
        text = describe(report.raised, slot.host->launch);
    return text;
}

void GpuLaunchSlots::settle(Slot& slot) {
    slot.busy = false;
    const std::shared_ptr<Context> context = slot.context.lock();
    if (!context || !context->log)
        return;
    const std::string where = message("launch ", slot.number, ": ");
    const std::string failure = failureOf(slot, slot.validation);
    const std::string unseen = describe(slot.host->report.unseen, slot.host->launch);
    if (!failure.empty())
        context->log(LogLevel::kError, "LAUNCH", where + failure);
    else if (!unseen.empty())
        context->log(LogLevel::kWarning, "LAUNCH", where + "no exception program saw: " + unseen);
}

} // namespace sunstone::engine
