// SPDX-License-Identifier: Apache-2.0
// traceBatch (trace.h) for builds that walk no rays together: it leaves each ray to the caller.
#pragma once

#include "devlib/trace_body.h"

#include <algorithm>

namespace sunstone::devlib::SUNSTONE_TRACE_SPACE {

// Result of traceBatch for a ray that it has not walked.
template <class Records, bool kInstancing>
static uint32_t traceWhole(RayState* state) {
    trace<Records, kInstancing>(state);
    return kAccept;
}

template <class Records, bool kInstancing>
static void traceNone(RayState* const*, ProgramFn* next, uint32_t count) {
    std::fill_n(next, count, traceWhole<Records, kInstancing>);
}

} // namespace sunstone::devlib::SUNSTONE_TRACE_SPACE
