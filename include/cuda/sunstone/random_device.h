// SPDX-License-Identifier: Apache-2.0
// Definitions shared by the generators of curand_kernel.h.
#ifndef SUNSTONE_RANDOM_DEVICE_H
#define SUNSTONE_RANDOM_DEVICE_H

#include "../cuda_runtime.h"

#ifndef QUALIFIERS
#define QUALIFIERS static __forceinline__ __device__
#endif
#define SUNSTONE_RANDOM QUALIFIERS

// Drops the second number of a pair of normal ones.
template <class State>
SUNSTONE_RANDOM void sunstoneForgetNormal(State* state) {
    state->boxmuller_flag = 0;
    state->boxmuller_flag_double = 0;
    state->boxmuller_extra = 0.0f;
    state->boxmuller_extra_double = 0.0;
}

#endif
