// SPDX-License-Identifier: Apache-2.0
// The trace functions of each instruction set; trace.cpp chooses.
#pragma once

#include "devlib/abi.h"

namespace sunstone::devlib {

struct TraceSet {
    void (*traceGraph)(RayState*); // any traversable
    void (*traceGas)(RayState*);   // geometry acceleration structures only
    uint32_t (*report)(RayState*, float t, uint32_t kind);
};

extern const TraceSet kTraceBaseline, kTraceAvx2, kTraceAvx512, kTraceChecked;

} // namespace sunstone::devlib
