// SPDX-License-Identifier: Apache-2.0
// Shared by faults.cu and its test.
#pragma once

struct FaultParams {
    unsigned* results;        // one for each launch index
    unsigned long long wild;  // address that index `at` accesses, if it is not 0
    unsigned at;
    unsigned writes;
    unsigned deed; // of index `at`
};

enum FaultDeed : unsigned { kFaultNone, kFaultTrap, kFaultRecursion };
