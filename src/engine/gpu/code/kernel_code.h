// SPDX-License-Identifier: Apache-2.0
// Machine code of the library's own kernels: that of the build (kernel_images.h), else compiled by
// the driver's compiler on all threads. Compiled code is kept in the disk cache of the API's
// context, like that of pipelines, and in this process, where all contexts share it with or without
// a cache.
#pragma once

#include "device/cuda/kernel_set.h"
#include "engine/compile_cache.h"
#include "engine/gpu/code/kernel_images.h"

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <unordered_map>

namespace sunstone::engine {

// Code that this process has compiled or read, by key: at most that of the library's kernels, a few
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

// A kernel's code in a disk cache.
bool findKernelCode(const std::string& key, compiler::ObjectStore& store, std::string& code);
void keepKernelCode(const std::string& key, compiler::ObjectStore& store, const std::string& code);

class GpuKernelCode final : public device::cuda::MachineCodeSource {
public:
    // `images`: code for this GPU, or null: none.
    GpuKernelCode(unsigned computeCapability, int driverVersion, const KernelImages* images)
        : computeCapability_(computeCapability), driverVersion_(unsigned(driverVersion)),
          images_(images) {}

    // Before the first call; null: none.
    void useCache(std::shared_ptr<CompileCache> cache) { cache_ = std::move(cache); }

    // A damaged entry on disk, or one that is not machine code, counts as missing.
    std::vector<std::string> machineCode(std::span<const device::cuda::KernelSource* const> kernels,
                                         bool anew) override;

    // Drops the code that this process keeps.
    static void forgetForTests();

private:
    std::string keyOf(const device::cuda::KernelSource& kernel) const;
    std::vector<bool> findImages(std::span<const device::cuda::KernelSource* const> kernels,
                                 bool anew, std::vector<std::string>& codes);

    const unsigned computeCapability_, driverVersion_;
    std::shared_ptr<CompileCache> cache_;
    std::mutex imageMutex_;
    const KernelImages* images_;       // null after the driver has refused one
    std::set<std::string> fromImages_; // ids of kernels whose code was an image
};

// The images of this library, or null where the CPU device acts as a GPU.
const KernelImages* usableKernelImages();

} // namespace sunstone::engine
