// SPDX-License-Identifier: Apache-2.0
// Shared by the debugged program and its host.
#pragma once

struct Params {
    unsigned* out;
    unsigned bias;
};

struct Pair {
    int first;
    float second;
};
