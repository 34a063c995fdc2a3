// SPDX-License-Identifier: Apache-2.0
// Launch parameters of key_queries.cu, and the place of a key.
#pragma once

#include "vec.h"

#include <optix.h>

constexpr unsigned kColumnBits = 10, kRowBits = 10;

struct KeyRange {
    unsigned first, last; // both included
};

struct KeyParams {
    OptixTraversableHandle index;
    const unsigned* rows; // the row of the table for each triangle
    const KeyRange* queries;
    float4* answers;
    unsigned numQueries;
};

SAMPLE_INLINE float3 placeOfKey(unsigned key) {
    return vec(float(key & ((1u << kColumnBits) - 1)),
               float(key >> kColumnBits & ((1u << kRowBits) - 1)),
               float(key >> (kColumnBits + kRowBits)));
}
