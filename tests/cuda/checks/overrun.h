// SPDX-License-Identifier: Apache-2.0
// Shared by overrun.cu and its host.
#pragma once

struct OverrunParams {
    unsigned* out;
    unsigned shift; // elements that every index writes too far
    unsigned weights[4];
};
