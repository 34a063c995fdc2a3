// SPDX-License-Identifier: Apache-2.0
// What overrun.cu and its host share.
#pragma once

struct OverrunParams {
    unsigned* out;
    unsigned shift; // elements that every index writes too far
    unsigned weights[4];
};
