// SPDX-License-Identifier: Apache-2.0
// See kernel_set.h.
#include "device/cuda/kernel_set.h"

#include <algorithm>
#include <numeric>

namespace sunstone::device::cuda {

KernelSet::KernelSet(const Driver& driver, MachineCodeSource* source,
                     std::vector<KernelSource> kernels)
    : driver_(driver), source_(source), kernels_(std::move(kernels)),
      functions_(new std::atomic<CUfunction>[kernels_.size()]()), states_(kernels_.size()) {}

KernelSet::~KernelSet() {
    for (const CUmodule module : modules_)
        driver_.moduleUnload(module);
}

bool KernelSet::areReady(std::span<const uint32_t> kernels) const {
    return std::all_of(kernels.begin(), kernels.end(), [&](uint32_t kernel) {
        return functions_[kernel].load(std::memory_order_acquire) != nullptr;
    });
}

// Threads that need the same kernels share the work: each takes the kernels that no thread has
// started, and waits for the rest. A kernel that failed can be prepared again.
void KernelSet::prepare(std::span<const uint32_t> kernels) {
    if (areReady(kernels))
        return;
    std::unique_lock lock(mutex_);
    for (;;) {
        std::vector<uint32_t> mine;
        for (const uint32_t kernel : kernels)
            if (states_[kernel] == State::kNone) {
                states_[kernel] = State::kUnderWay;
                mine.push_back(kernel);
            }
        if (mine.empty()) {
            if (areReady(kernels))
                return;
            changed_.wait(lock);
            continue;
        }
        const auto settle = [&] {
            lock.lock();
            for (const uint32_t kernel : mine)
                states_[kernel] = functions_[kernel] ? State::kReady : State::kNone;
            changed_.notify_all();
        };
        lock.unlock();
        try {
            load(mine);
        } catch (...) {
            settle();
            throw;
        }
        settle();
    }
}

void KernelSet::prepareAll() {
    std::vector<uint32_t> all(kernels_.size());
    std::iota(all.begin(), all.end(), 0u);
    prepare(all);
}

CUfunction KernelSet::function(uint32_t kernel) {
    if (const CUfunction there = functions_[kernel].load(std::memory_order_acquire))
        return there;
    prepare({&kernel, 1});
    return functions_[kernel];
}

void KernelSet::load(const std::vector<uint32_t>& kernels) {
    std::vector<const KernelSource*> sources;
    for (const uint32_t kernel : kernels)
        sources.push_back(&kernels_[kernel]);
    std::vector<std::string> codes(kernels.size());
    if (source_)
        codes = source_->machineCode(sources, false);
    for (size_t i = 0; i < kernels.size(); ++i)
        functions_[kernels[i]].store(loadOne(kernels[i], std::move(codes[i])),
                                     std::memory_order_release);
}

CUfunction KernelSet::loadOne(uint32_t kernel, std::string code) {
    const KernelSource& source = kernels_[kernel];
    CUmodule module = nullptr;
    const auto loads = [&](const std::string& image) {
        if (image.empty())
            return CUDA_ERROR_INVALID_IMAGE;
        const CUresult result =
            driver_.moduleLoadDataEx(&module, image.data(), 0, nullptr, nullptr);
        if (result == CUDA_ERROR_OUT_OF_MEMORY || result == CUDA_ERROR_ILLEGAL_ADDRESS)
            check(driver_, result, DriverNames::moduleLoadDataEx); // not the code's fault
        return result;
    };
    CUresult result = loads(code);
    if (result != CUDA_SUCCESS && !code.empty()) { // e.g. made for another driver of the same
                                                   // version
        const KernelSource* const again = &source;
        result = loads(source_->machineCode({&again, 1}, true)[0]);
    }
    if (result != CUDA_SUCCESS)
        result = loads(source.text());
    check(driver_, result, DriverNames::moduleLoadDataEx);
    {
        std::lock_guard lock(mutex_);
        modules_.push_back(module);
    }
    CUfunction function = nullptr;
    check(driver_, driver_.moduleGetFunction(&function, module, source.name.c_str()),
          source.name.c_str());
    int registers = 0; // the query ends deferred loading by the driver
    check(driver_, driver_.funcGetAttribute(&registers, CU_FUNC_ATTRIBUTE_NUM_REGS, function),
          DriverNames::funcGetAttribute);
    return function;
}

// ---- modules of one kernel --------------------------------------------------------------------

KernelTexts::KernelTexts(std::string_view ptx) : pieces_(ptxPieces(ptx)) {}

std::string KernelTexts::moduleOf(std::string_view kernel) const {
    std::vector<bool> isWanted(pieces_.size());
    std::vector<std::string_view> unread;
    for (size_t i = 0; i < pieces_.size(); ++i) {
        isWanted[i] = pieces_[i].name.empty() || pieces_[i].name == kernel;
        if (pieces_[i].name == kernel)
            unread.push_back(pieces_[i].text);
    }
    if (unread.empty())
        fail(Code::kInternal, "there is no kernel ", kernel);
    while (!unread.empty()) {
        const std::string_view text = unread.back();
        unread.pop_back();
        for (size_t i = 0; i < pieces_.size(); ++i)
            if (!isWanted[i] && !pieces_[i].isKernel && text.find(pieces_[i].name) != text.npos) {
                isWanted[i] = true;
                unread.push_back(pieces_[i].text);
            }
    }
    std::string result;
    for (size_t i = 0; i < pieces_.size(); ++i)
        if (isWanted[i])
            result += pieces_[i].text;
    return result;
}

} // namespace sunstone::device::cuda
