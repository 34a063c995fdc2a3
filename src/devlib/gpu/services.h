// SPDX-License-Identifier: Apache-2.0
// Functions that translated programs call by name: those that CUDA's driver provides to device
// code, with the hidden parameter of every function of an OptiX module. A failed assertion ends the
// launch; the driver's own function would end the context.
#pragma once

#include "devlib/gpu/checks.h"

extern "C" {
int vprintf(const char*, void*);
void* malloc(size_t);
void free(void*);

uint32_t sunstone_vprintf(sunstone::devlib::RayState*, uint64_t format, uint64_t values) {
    return uint32_t(
        vprintf(reinterpret_cast<const char*>(format), reinterpret_cast<void*>(values)));
}
uint64_t sunstone_malloc(sunstone::devlib::RayState*, uint64_t size) {
    return reinterpret_cast<uint64_t>(malloc(size));
}
void sunstone_free(sunstone::devlib::RayState*, uint64_t address) {
    free(reinterpret_cast<void*>(address));
}
void sunstone_assertfail(sunstone::devlib::RayState* state, uint64_t condition, uint64_t file,
                         uint32_t line, uint64_t function, uint64_t) {
    using namespace sunstone::devlib;
    gpu::say(state, kFatalAssertion, line, reinterpret_cast<const char*>(condition),
             reinterpret_cast<const char*>(file), reinterpret_cast<const char*>(function));
    gpu::endLaunch(state, kFatalAssertion);
}
}

namespace sunstone::devlib::gpu {

// Takes the place of missing callables.
extern "C" uint32_t sunstone_no_callable() {
    return 0;
}

extern "C" const void* sunstone_gpu_callable(RayState* state, uint32_t sbtIndex, uint32_t call) {
    const uint64_t record = Records::callable(*state->launch, sbtIndex);
    state->callableData = dataOf(record);
    const uint32_t group = record ? groupOf(*state->launch, record, kGroupCallables) : kNoGroup;
    const void* const code =
        call & 1 ? sunstone_gpu_continuation(group) : sunstone_gpu_direct(group);
    checkStack(state);
    if (const int32_t fault = code ? 0 : Records::callableFault(*state->launch))
        raise(state, fault);
    if (debugging())
        checkCallable(state, sbtIndex, call, group, code);
    if constexpr (!Records::kOwnRecords)
        if (!code)
            noteRecord(state,
                       call & 1 ? NeededProgram::kContinuationCallable
                                : NeededProgram::kDirectCallable,
                       sbtIndex);
    return code;
}

} // namespace sunstone::devlib::gpu
