// SPDX-License-Identifier: Apache-2.0
// Launch parameters of random_access.cu.
#pragma once

struct AccessResult {
    float vertices[9];
    unsigned long long instance, child;
    unsigned id;
    unsigned missed;
};

struct AccessParams {
    unsigned long long gas, ias, traced;
    unsigned primitiveOffset, sbtIndex;
    AccessResult* results;
};
