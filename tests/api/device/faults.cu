// SPDX-License-Identifier: Apache-2.0
// One launch index accesses an address that the test chooses, or ends in another way.
#include <optix.h>

#include "faults.h"

extern "C" {
__constant__ FaultParams params;
}

__noinline__ __device__ unsigned descend(unsigned level, volatile unsigned* above) {
    volatile unsigned here[64];
    here[level & 63] = *above + level;
    const unsigned below = level == 0xFFFFFFFFu ? 0 : descend(level + 1, here);
    return below + here[(level + 1) & 63];
}

extern "C" __global__ void __raygen__faults() {
    const unsigned i = optixGetLaunchIndex().x;
    unsigned value = i + 1;
    if (params.wild && i == params.at && params.deed == kFaultNone) {
        volatile unsigned* wild = reinterpret_cast<unsigned*>(params.wild);
        if (params.writes)
            *wild = 7;
        else
            value = *wild;
    }
    if (i == params.at && params.deed == kFaultTrap)
        asm volatile("trap;");
    if (i == params.at && params.deed == kFaultRecursion)
        value = descend(0, &value);
    params.results[i] = value;
}
