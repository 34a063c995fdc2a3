// SPDX-License-Identifier: Apache-2.0
// What the host and the device side of micromap_reference share.
#pragma once

// One ray of a launch, along -z from (x, y, 1).
struct Query {
    unsigned long long handle;
    float x, y;
    unsigned int rayFlags;
    unsigned int pad;
};

// What became of it: kHit or kMiss (neither with the closest-hit program disabled), plus kAnyHit
// for each call of the any-hit program.
enum Outcome { kHit = 1, kMiss = 2, kAnyHit = 16 };

struct Params {
    const Query* queries;
    unsigned int* outcomes;
};
