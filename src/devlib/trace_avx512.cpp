// SPDX-License-Identifier: Apache-2.0
// The trace functions for the avx512 instruction set; CMakeLists.txt sets the flags.
#include "devlib/trace_batch_body.h"

#include "devlib/trace_sets.h"

namespace sunstone::devlib {

const TraceSet kTraceAvx512 = {
    avx512::trace<SbtRecords, true>,
    avx512::trace<SbtRecords, false>,
    avx512::report<SbtRecords>,
    avx512::trace<ClassicRecords, true>,
    avx512::report<ClassicRecords>,
    avx512::visitChild<ClassicRecords>,
    avx512::traceBatch<true>,
    avx512::traceBatch<false>,
    avx512::traceNone<ClassicRecords, true>,
};

} // namespace sunstone::devlib
