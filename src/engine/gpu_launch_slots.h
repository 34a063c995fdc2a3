// SPDX-License-Identifier: Apache-2.0
// Memory of launches in flight on a GPU: for each a block in device memory with room for launch
// parameters, and its image in page-locked host memory. A slot is used again once its launch is
// over; what that launch reported is told then.
#pragma once

#include "device/cuda/driver.h"
#include "devlib/gpu/launch_block.h"
#include "engine/context.h"

#include <mutex>
#include <vector>

namespace sunstone::engine {

class GpuLaunchSlots {
public:
    struct Slot {
        CUdeviceptr memory = 0; // LaunchBlock, then the parameters
        devlib::LaunchBlock* host = nullptr;
        size_t capacity = 0; // bytes of parameters
        CUevent done = nullptr;
        bool busy = false;
        bool validation = false;
        std::weak_ptr<Context> context;
        uint64_t number = 0; // of the launch, in order
    };
    static constexpr size_t kParameters = (sizeof(devlib::LaunchBlock) + 255) / 256 * 256;

    explicit GpuLaunchSlots(CUcontext context) : context_(context) {}
    ~GpuLaunchSlots();

    // A free slot. The context is current.
    Slot& take(size_t parameterBytes);
    // After everything of the launch is queued.
    void started(Slot& slot, CUstream stream);
    // Waits for this launch and returns why it failed; empty if it did not.
    std::string finish(Slot& slot);

private:
    void settle(Slot& slot); // tells what the launch reported
    static std::string failureOf(const Slot& slot, bool validation);

    CUcontext context_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Slot>> slots_;
    uint64_t launches_ = 0;
};

} // namespace sunstone::engine
