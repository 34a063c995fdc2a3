// SPDX-License-Identifier: Apache-2.0
// Shared by the host and the device side of helpers.cu.
#pragma once

struct HelperResult {
    unsigned hits, hitKind, typeOfNothing, staticChild;
    float point[3], vector[3], normal[3], back[3]; // object to world, and the normal back
    float byMatrix[9];                             // point, vector, normal by the matrix helpers
    float inverse[12], product[4], sum[4];
    unsigned ldg[4];
    unsigned undefined; // any value
};

struct HelperParams {
    HelperResult* results;
    unsigned long long handle;
    const float* aligned; // 4 floats
    int dump;             // print the transforms of the hit
};
