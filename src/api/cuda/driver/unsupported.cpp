// SPDX-License-Identifier: Apache-2.0
// See unsupported.h. Not cuda.h: it would rename the functions and declare some of them. Callers
// pass arguments, which the calling convention lets a function ignore.
#include "api/cuda/driver/unsupported.h"

#include "api/cuda/driver/unsupported_names.h"
#include "base/error.h"
#include "base/log.h"

#include <algorithm>
#include <iterator>

namespace sunstone::api::cuda {

namespace {

constexpr int kNotSupported = 801; // CUDA_ERROR_NOT_SUPPORTED

constexpr std::string_view kNames[] = {
#define SUNSTONE_NAME(name) #name,
    SUNSTONE_UNSUPPORTED_FUNCTIONS(SUNSTONE_NAME)
#undef SUNSTONE_NAME
};

int refuseCall(const char* function) {
    logOnce(LogLevel::kFatal, "cuda",
            message(function, ": CUDA_ERROR_NOT_SUPPORTED: the function is not implemented"));
    return kNotSupported;
}

} // namespace

bool isUnsupported(std::string_view name) {
    return std::find(std::begin(kNames), std::end(kNames), name) != std::end(kNames);
}

} // namespace sunstone::api::cuda

#define SUNSTONE_REFUSE(name)                                                                      \
    extern "C" __attribute__((visibility("default"))) int name() {                                 \
        return sunstone::api::cuda::refuseCall(#name);                                             \
    }
SUNSTONE_UNSUPPORTED_FUNCTIONS(SUNSTONE_REFUSE)
