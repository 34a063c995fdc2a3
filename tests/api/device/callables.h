// SPDX-License-Identifier: Apache-2.0
// Shared by the host and the device side of callables.cu.
#pragma once

struct Pair {
    float first, second;
};

struct Large {
    unsigned words[12];
    double sum;
};

// Order of the callable records.
enum CallableIndex : unsigned {
    kCallAdd, kCallMixed, kCallSwap, kCallLarge, kCallStore, kCallLaunch, kCallWide, kCallNested,
    kCallOuter, kCallSubtract,
};

struct CallableResult {
    unsigned sum;
    float mixed;
    Pair pair;
    Large large;
    unsigned stored, launch, nested, outer, varying, raygenRecord;
    double wide;
    unsigned from[4]; // closest-hit, miss, any-hit, intersection
    unsigned recordFrom[4];
};

struct CallableParams {
    CallableResult* results;
    unsigned long long handle;
};
