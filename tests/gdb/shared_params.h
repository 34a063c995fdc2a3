// SPDX-License-Identifier: Apache-2.0
// What the debugged program and its host share.
#pragma once

struct Params {
    unsigned* out;
    unsigned bias;
};

struct Pair {
    int first;
    float second;
};
