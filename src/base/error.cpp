// SPDX-License-Identifier: Apache-2.0
// See error.h.
#include "base/error.h"

#include "base/log.h"

#include <cstdlib>

namespace sunstone {

void checkFailed(const char* file, int line, const std::string& text) {
    std::string full = message("internal error: ", text, " (", file, ":", line, ")");
    log(LogLevel::kFatal, "base", full);
#ifndef NDEBUG
    std::abort();
#else
    throw Error(Code::kInternal, full);
#endif
}

} // namespace sunstone
