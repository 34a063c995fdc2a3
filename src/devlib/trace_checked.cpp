// SPDX-License-Identifier: Apache-2.0
// The trace functions for pipelines with debug exceptions; see kChecked in trace_body.h. One set
// serves all processors, because debugging does not need maximum speed.
#define SUNSTONE_TRACE_CHECKED
#include "devlib/trace_none.h"

#include "devlib/trace_sets.h"

namespace sunstone::devlib {

const TraceSet kTraceChecked = {
    baseline::checked::trace<SbtRecords, true>,
    baseline::checked::trace<SbtRecords, true>,
    baseline::checked::report<SbtRecords>,
    nullptr,
    nullptr,
    nullptr,
    baseline::checked::traceNone<SbtRecords, true>,
    nullptr,
    nullptr,
};

} // namespace sunstone::devlib
