// SPDX-License-Identifier: Apache-2.0
// A CUDA GPU as a Device: the application's CUcontext, driven through its own driver. Host code
// cannot run in stream order on a GPU; kernels and copies of the engine's GPU back end do the work
// on device memory.
#pragma once

#include "device/cuda/driver.h"
#include "device/device.h"

#include <memory>
#include <string>

namespace sunstone::device::cuda {

class GpuDevice final : public Device {
public:
    // Throws kCudaError if the driver does not know the context.
    explicit GpuDevice(CUcontext context);

    CUcontext context() const { return context_; }
    unsigned computeCapability() const { return computeCapability_; } // 10 * major + minor
    int driverVersion() const { return driverVersion_; }              // 1000 * major + 10 * minor

    const char* name() const override { return name_.c_str(); }
    [[noreturn]] void enqueue(void* stream, std::function<void()> work) override;
    const void* streamContext(void* stream) override;
    bool isIdle(void* stream) override;
    void synchronize(void* stream) override;
    void synchronizeAll() override;
    void* currentContext() override;
    bool ownsContext(void* context) override { return context == context_; }
    bool isAccessible(const void* address, size_t size) override;

private:
    CUcontext context_;
    std::string name_;
    unsigned computeCapability_ = 0;
    int driverVersion_ = 0;
};

} // namespace sunstone::device::cuda
