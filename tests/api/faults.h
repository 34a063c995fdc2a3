// SPDX-License-Identifier: Apache-2.0
// What faults.cu and its test share.
#pragma once

struct FaultParams {
    unsigned* results;        // one for each launch index
    unsigned long long wild;  // where index `at` goes, if it is not 0
    unsigned at;
    unsigned writes;
};
