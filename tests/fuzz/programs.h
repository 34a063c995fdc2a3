// SPDX-License-Identifier: Apache-2.0
// Shared by the host and the device side of programs.cu.
#pragma once

struct FuzzParams {
    unsigned* answers; // may be null
    unsigned count;    // words in answers
    unsigned rayFlags;
    unsigned long long handle; // any value
    float origin[3], direction[3], tmin, tmax, time;
    unsigned sbtOffset, sbtStride, missIndex, callable, mask;
};
