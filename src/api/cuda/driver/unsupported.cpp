// SPDX-License-Identifier: Apache-2.0
// Driver API functions that only return CUDA_ERROR_NOT_SUPPORTED, so that programs link and start
// and fail at the call. cuda.h is not included: it would rename the functions and declare some of
// them. Callers pass arguments, which the calling convention allows a function to ignore.
#include "api/cuda/driver/unsupported_names.h"
#include "base/error.h"
#include "base/forked.h"
#include "base/log.h"

namespace sunstone::api::cuda {

namespace {

constexpr int kNotInitialized = 3; // CUDA_ERROR_NOT_INITIALIZED
constexpr int kNotSupported = 801; // CUDA_ERROR_NOT_SUPPORTED

int refuseCall(const char* function) {
    if (refusesForkedChild())
        return kNotInitialized;
    logOnce(LogLevel::kFatal, "cuda",
            message(function, ": CUDA_ERROR_NOT_SUPPORTED: the function is not implemented"));
    return kNotSupported;
}

} // namespace

} // namespace sunstone::api::cuda

#define SUNSTONE_REFUSE(name)                                                                      \
    extern "C" __attribute__((visibility("default"))) int name() {                                 \
        return sunstone::api::cuda::refuseCall(#name);                                             \
    }
SUNSTONE_UNSUPPORTED_FUNCTIONS(SUNSTONE_REFUSE)
