// SPDX-License-Identifier: Apache-2.0
// Functions of the runtime API that exist only to say that they are not supported: programs link
// and start, and learn it where they call. Not the CUDA headers: they would declare some of the
// functions. Callers pass arguments, which the calling convention lets a function ignore.
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
