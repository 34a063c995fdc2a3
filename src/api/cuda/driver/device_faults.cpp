// SPDX-License-Identifier: Apache-2.0
// See device_faults.h.
#include "api/cuda/driver/device_faults.h"

#include "check/memory_check.h"
#include "device/device.h"

#include <csignal>

namespace sunstone::api::cuda {

namespace {

bool isAccess(const FaultFrame& fault) {
    return fault.signal == SIGSEGV || fault.signal == SIGBUS;
}

} // namespace

CUresult faultResult(const FaultFrame& fault) {
    if (!isAccess(fault))
        return CUDA_ERROR_LAUNCH_FAILED;
    return fault.kind == FaultFrame::kMisaligned ? CUDA_ERROR_MISALIGNED_ADDRESS
                                                 : CUDA_ERROR_ILLEGAL_ADDRESS;
}

std::string freedRemark(const FaultFrame& fault) {
    const std::string freed = isAccess(fault) ? check::describeFreed(fault.address) : std::string();
    return freed.empty() ? freed : " (" + freed + ")";
}

void refuseFault(const char* what, const FaultFrame& fault) {
    refuse(CUDA_ERROR_ILLEGAL_ADDRESS, what, ": ", describeFault(fault), freedRemark(fault));
}

void runInContext(const std::weak_ptr<cpu::Context>& context, const std::function<void()>& work) {
    const cpu::ContextPtr home = context.lock();
    if (home && home->fault)
        return;
    try {
        work();
    } catch (const Failure& failure) {
        if (!home)
            throw;
        home->keepFault(failure.result(), failure.what());
        throw device::ContextFault(failure.result(), failure.what());
    }
}

} // namespace sunstone::api::cuda
