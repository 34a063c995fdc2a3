// SPDX-License-Identifier: Apache-2.0
// One launch index reads from or writes to an address that the test chooses.
#include <optix.h>

#include "faults.h"

extern "C" {
__constant__ FaultParams params;
}

extern "C" __global__ void __raygen__faults() {
    const unsigned i = optixGetLaunchIndex().x;
    unsigned value = i + 1;
    if (params.wild && i == params.at) {
        volatile unsigned* wild = reinterpret_cast<unsigned*>(params.wild);
        if (params.writes)
            *wild = 7;
        else
            value = *wild;
    }
    params.results[i] = value;
}
