// SPDX-License-Identifier: Apache-2.0
// See device_faults.h.
#include "api/cuda/driver/device_faults.h"

#include "check/memory_check.h"
#include "device/device.h"

#include <csignal>

namespace sunstone::api::cuda {

std::string freedRemark(const FaultFrame& fault) {
    const bool isAccess = fault.signal == SIGSEGV || fault.signal == SIGBUS;
    const std::string freed = isAccess ? check::describeFreed(fault.address) : std::string();
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
