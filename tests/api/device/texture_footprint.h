// SPDX-License-Identifier: Apache-2.0
// Shared by texture_footprint.cu and its test.
#pragma once

struct FootprintResult {
    unsigned words[4];
    unsigned single;
    unsigned undefined; // optixUndefinedValue, masked away
};

struct FootprintParams {
    FootprintResult* results; // one for each launch index
    unsigned long long texture;
};
