// SPDX-License-Identifier: Apache-2.0
// Shared by loop_test.cpp and its device programs.
#pragma once

#include "rays.h"

struct LoopResult {
    unsigned int hits;     // rays that hit something
    unsigned int checksum; // of their hits, in order
    unsigned int traces;
    unsigned int thrown; // the exception program's: 1 + code of the exception
};

struct LoopParams {
    const TestRay* rays;
    LoopResult* results; // one for each launch index, x fastest
    unsigned long long handle;
    unsigned int rayCount, flags;
    unsigned int most; // traces of an index: its number modulo this
    // Indices of this number modulo 5 throw after their first trace, or in the closest-hit program
    // of a ray that another one has traced; 5: none.
    unsigned int throwAt, throwBelow;
};
