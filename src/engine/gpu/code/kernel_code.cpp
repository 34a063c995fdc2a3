// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/code/kernel_code.h"

#include "base/config.h"
#include "base/log.h"
#include "base/threads/threads.h"
#include "compiler/gpu/pipeline.h"
#include "device/cuda/ptx_compiler.h"
#include "engine/gpu/process.h"

#include <algorithm>
#include <chrono>
#include <numeric>

namespace sunstone::engine {

using device::cuda::KernelSource;

const KernelImages* usableKernelImages() {
    return config(Setting::kGpuBackEnd) == "cpu-device" ? nullptr : &builtKernelImages();
}

namespace {

// The largest texts first, as they take longest. Empty where the compiler refuses a text.
std::vector<std::string> compileAll(std::span<const KernelSource* const> kernels,
                                    unsigned computeCapability) {
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::string> texts(kernels.size()), codes(kernels.size());
    const auto forEach = [&](const auto& body) {
        parallelFor(kernels.size(), 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                body(i);
        });
    };
    forEach([&](size_t i) { texts[i] = kernels[i]->text(); });
    std::vector<size_t> order(kernels.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::sort(order.begin(), order.end(),
              [&](size_t a, size_t b) { return texts[a].size() > texts[b].size(); });
    forEach([&](size_t i) {
        if (auto made = device::cuda::compilePtx(texts[order[i]], computeCapability, 0))
            codes[order[i]] = std::move(made->cubin);
    });
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    log(LogLevel::kDebug, "engine",
        message("compiled ", kernels.size(), " kernels of the library in ", time.count(), " ms"));
    return codes;
}

} // namespace

bool findKernelCode(const std::string& key, compiler::ObjectStore& store, std::string& code) {
    compiler::GpuCode kept;
    if (!compiler::findGpuPipeline(key, store, kept))
        return false;
    code = std::move(kept.machineCode);
    return !code.empty();
}

void keepKernelCode(const std::string& key, compiler::ObjectStore& store, const std::string& code) {
    compiler::GpuCode kept;
    kept.machineCode = code;
    compiler::keepGpuPipeline(key, kept, store);
}

bool KnownKernelCode::find(const std::string& key, std::string& code) {
    std::lock_guard lock(mutex_);
    const auto found = codes_.find(key);
    if (found == codes_.end())
        return false;
    code = found->second;
    return true;
}

void KnownKernelCode::add(const std::string& key, const std::string& code) {
    std::lock_guard lock(mutex_);
    codes_[key] = code;
}

void KnownKernelCode::forget() {
    std::lock_guard lock(mutex_);
    codes_.clear();
}

std::string GpuKernelCode::keyOf(const KernelSource& kernel) const {
    return compiler::keyOf({computeCapability_, 0, driverVersion_}, kernel.id);
}

void GpuKernelCode::forgetForTests() {
    gpuProcess().kernels.forget();
}

// Finds images, or notes that the driver has refused them. Returns for each kernel whether its code
// was an image: the code on disk has not been tried for these.
std::vector<bool> GpuKernelCode::findImages(std::span<const KernelSource* const> kernels, bool anew,
                                            std::vector<std::string>& codes) {
    std::lock_guard lock(imageMutex_);
    std::vector<bool> isRefused(kernels.size());
    for (size_t i = 0; i < kernels.size(); ++i) {
        const std::string& id = kernels[i]->id;
        if (anew) {
            isRefused[i] = fromImages_.erase(id) != 0;
        } else if (images_) {
            codes[i] = images_->find(computeCapability_, driverVersion_, id);
            if (!codes[i].empty())
                fromImages_.insert(id);
        }
    }
    if (images_ && std::find(isRefused.begin(), isRefused.end(), true) != isRefused.end()) {
        images_ = nullptr;
        log(LogLevel::kInfo, "engine", "the driver refuses the machine code that was built in");
    }
    return isRefused;
}

std::vector<std::string> GpuKernelCode::machineCode(std::span<const KernelSource* const> kernels,
                                                    bool anew) {
    std::vector<std::string> codes(kernels.size()), keys;
    KnownKernelCode& known = gpuProcess().kernels;
    const std::vector<bool> isRefused = findImages(kernels, anew, codes);
    if (!device::cuda::hasPtxCompiler()) // the driver's own cache serves then
        return codes;
    compiler::ObjectStore* const store = cache_ && cache_->enabled() ? cache_.get() : nullptr;
    std::vector<size_t> missing, unkept; // places
    for (size_t i = 0; i < kernels.size(); ++i) {
        keys.push_back(keyOf(*kernels[i]));
        if (!codes[i].empty())
            continue;
        if (anew && !isRefused[i]) {
            missing.push_back(i);
        } else if (known.find(keys[i], codes[i])) {
            if (store && !store->has(keys[i]))
                unkept.push_back(i);
        } else if (store && findKernelCode(keys[i], *store, codes[i])) {
            known.add(keys[i], codes[i]);
        } else {
            missing.push_back(i);
        }
    }
    if (!missing.empty()) {
        std::vector<const KernelSource*> sources;
        for (const size_t i : missing)
            sources.push_back(kernels[i]);
        std::vector<std::string> made = compileAll(sources, computeCapability_);
        for (size_t j = 0; j < missing.size(); ++j)
            if (!made[j].empty()) {
                codes[missing[j]] = std::move(made[j]);
                known.add(keys[missing[j]], codes[missing[j]]);
                unkept.push_back(missing[j]);
            }
    }
    if (store)
        for (const size_t i : unkept)
            keepKernelCode(keys[i], *store, codes[i]);
    return codes;
}

} // namespace sunstone::engine
