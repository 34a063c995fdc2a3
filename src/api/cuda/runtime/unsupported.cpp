// SPDX-License-Identifier: Apache-2.0
// Runtime API functions that only return cudaErrorNotSupported, so that programs link and start and
// fail at the call. The CUDA headers are not included: they would declare some of the functions.
// Callers pass arguments, which the calling convention allows a function to ignore.
#include "api/cuda/runtime/unsupported_names.h"

#include <atomic>
#include <cstdio>

namespace sunstone::cudart {

int rememberNotSupported();

} // namespace sunstone::cudart

#define SUNSTONE_REFUSE(name)                                                                      \
    extern "C" __attribute__((visibility("default"))) int name() {                                 \
        static std::atomic<bool> told{false};                                                      \
        if (!told.exchange(true))                                                                  \
            std::fprintf(stderr, "[sunstone cudart] %s is not supported\n", #name);                \
        return sunstone::cudart::rememberNotSupported();                                           \
    }
SUNSTONE_UNSUPPORTED_FUNCTIONS(SUNSTONE_REFUSE)
