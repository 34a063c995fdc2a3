// SPDX-License-Identifier: Apache-2.0
// Shared by payload_types.cu and its test.
#pragma once

#include "optix.h"

struct TypedResult {
    unsigned words[4];
    int code; // of an exception, or 1000
};

struct TypedParams {
    TypedResult* results;
    OptixTraversableHandle handle;
    unsigned hitOffset[2]; // SBT offset of the trace with type 0 and 1
};
