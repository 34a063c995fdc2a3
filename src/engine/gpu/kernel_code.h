// SPDX-License-Identifier: Apache-2.0
// Machine code of the library's own kernels, made by the driver's compiler on all threads. It is
// kept in the disk cache of the API's context, as that of pipelines is, and in this process, whose
// contexts share it with or without a cache.
#pragma once

#include "device/cuda/kernel_set.h"
#include "engine/compile_cache.h"

#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace sunstone::engine {

// Code that this process has made or read, by key: at most that of the library's kernels, a few
// megabytes. Any thread may call.
class KnownKernelCode {
public:
    bool find(const std::string& key, std::string& code);
    void add(const std::string& key, const std::string& code);
    void forget();

private:
    std::mutex mutex_;
    std::unordered_map<std::string, std::string> codes_;
};

class GpuKernelCode final : public device::cuda::MachineCodeSource {
public:
    GpuKernelCode(unsigned computeCapability, int driverVersion)
        : computeCapability_(computeCapability), driverVersion_(unsigned(driverVersion)) {}

    // Before the first call; null: none.
    void useCache(std::shared_ptr<CompileCache> cache) { cache_ = std::move(cache); }

    // A damaged entry on disk, or one that is not machine code, counts as missing.
    std::vector<std::string> machineCode(std::span<const device::cuda::KernelSource* const> kernels,
                                         bool anew) override;

    // The code that this process keeps.
    static void forgetForTests();

private:
    std::string keyOf(const device::cuda::KernelSource& kernel) const;

    const unsigned computeCapability_, driverVersion_;
    std::shared_ptr<CompileCache> cache_;
};

} // namespace sunstone::engine
