// SPDX-License-Identifier: Apache-2.0
// The trace functions for the baseline instruction set; CMakeLists.txt sets the flags.
#include "devlib/trace_batch_body.h"

#include "devlib/trace_sets.h"

namespace sunstone::devlib {

const TraceSet kTraceBaseline = {
    baseline::trace<SbtRecords, true>,
    baseline::trace<SbtRecords, false>,
    baseline::report<SbtRecords>,
    baseline::trace<ClassicRecords, true>,
    baseline::report<ClassicRecords>,
    baseline::visitChild<ClassicRecords>,
    baseline::traceBatch<true>,
    baseline::traceBatch<false>,
    baseline::traceNone<ClassicRecords, true>,
};

} // namespace sunstone::devlib
