// SPDX-License-Identifier: Apache-2.0
// The run-time behind optixTrace, optixReportIntersection and callables on the CPU: functions that
// compiled programs reach through LaunchState (abi.h).
//
// Bad input: a null or foreign handle, a ray with NaN or infinity, and a trace deeper than
// maxTraceDepth act as a miss (the last without running the miss program); an SBT index out of
// range, a record without a packed group, and a group without the program act as a program that
// does nothing. With the trace-depth exception, too deep a trace or graph raises it; with debug
// exceptions all of these raise. Too deep a stack always raises.
//
// Read next: trace_body.h.
#pragma once

#include "devlib/abi.h"

namespace sunstone::devlib {

// Features that the programs and graphs of a pipeline may need. A disabled feature makes traces
// faster and must not occur.
struct TraceFeatures {
    bool anyHit = true;     // some hit group has an any-hit program
    bool custom = true;     // custom primitives
    bool instancing = true; // handles other than that of a geometry acceleration structure
    bool checked = false;   // debug exceptions
    bool classic = false;   // programs of the classic API, with its records
};

// Whether the handle's own memory is mapped. Queried once per thread for a handle that programs
// pass to optixTrace, and for children of static transforms; see ThreadState::knownHandles. (Builds
// check the children of instances.)
bool isTraversable(uint64_t handle);

// Walks the rays of several launch indices together, with the same hits as `trace`, bit for bit. It
// runs no program and raises no exception. next[i] is the remaining work for states[i], on the
// stack of its launch index:
//   null                  nothing
//   a closest-hit or      the hit or the miss is in the state; the caller calls the program
//   miss program
//   another function      the ray was not walked, because its walk may run programs or raise; the
//                         function is `trace` as a whole, and the caller calls it in the same way
// The [trace] fields of the states are set; the states stay where they are and keep their values
// until the call returns. The rays may be of different launches, with any flags and handles.
using TraceBatchFn = void (*)(RayState* const* states, ProgramFn* next, uint32_t count);

struct TraceVariant {
    void (*trace)(RayState*);
    TraceBatchFn traceBatch;
    uint32_t (*report)(RayState*, float t, uint32_t kind);
    const void* (*callable)(RayState*, uint32_t sbtIndex, uint32_t call);
    uint32_t (*visitChild)(RayState*, uint32_t index); // null for OptiX 7
};

// The fastest functions with these features on this machine (see bvh::chosenIsa).
TraceVariant selectTrace(const TraceFeatures& features);

// Sets the launch's functions of this file: trace, report, callable, getters, checks.
void bindTrace(LaunchState& launch, const TraceFeatures& features);

} // namespace sunstone::devlib
