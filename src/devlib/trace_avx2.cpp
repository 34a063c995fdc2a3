// SPDX-License-Identifier: Apache-2.0
// The trace functions for the avx2 instruction set; CMakeLists.txt sets the flags.
#include "devlib/trace_batch_body.h"

#include "devlib/trace_sets.h"

namespace sunstone::devlib {

const TraceSet kTraceAvx2 = {
    avx2::trace<SbtRecords, true>,
    avx2::trace<SbtRecords, false>,
    avx2::report<SbtRecords>,
    avx2::trace<ClassicRecords, true>,
    avx2::report<ClassicRecords>,
    avx2::visitChild<ClassicRecords>,
    avx2::traceBatch<true>,
    avx2::traceBatch<false>,
    avx2::traceNone<ClassicRecords, true>,
};

} // namespace sunstone::devlib
