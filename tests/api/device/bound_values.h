// SPDX-License-Identifier: Apache-2.0
// Shared by bound_values.cu and its test.
#pragma once

struct BoundParams {
    unsigned* results; // four per launch index
    unsigned mode;     // bound
    float scale;       // bound
    unsigned table[4]; // bound; read at computed places
    unsigned other;
};
