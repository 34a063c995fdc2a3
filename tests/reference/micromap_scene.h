// SPDX-License-Identifier: Apache-2.0
// Shared by the host and the device side of micromap_reference.
#pragma once

// One ray of a launch, along -z from (x, y, 1).
struct Query {
    unsigned long long handle;
    float x, y;
    unsigned int rayFlags;
    unsigned int pad;
};

// The outcome: kHit or kMiss (neither with the closest-hit program disabled), plus kAnyHit for each
// call of the any-hit program.
enum Outcome { kHit = 1, kMiss = 2, kAnyHit = 16 };

struct Params {
    const Query* queries;
    unsigned int* outcomes;
};
