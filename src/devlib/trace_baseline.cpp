// SPDX-License-Identifier: Apache-2.0
// The trace functions for the baseline instruction set; CMakeLists.txt sets the flags.
#include "devlib/trace_body.h"

#include "devlib/trace_sets.h"

namespace sunstone::devlib {

const TraceSet kTraceBaseline = {
    baseline::trace<SbtRecords, true>, baseline::trace<SbtRecords, false>,
    baseline::report<SbtRecords>,      baseline::trace<ClassicRecords, true>,
    baseline::report<ClassicRecords>,  baseline::visitChild<ClassicRecords>};

} // namespace sunstone::devlib
