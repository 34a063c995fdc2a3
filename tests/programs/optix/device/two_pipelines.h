// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Params {
    OptixTraversableHandle scene;
    float* depth;
    unsigned* picked;
    int width, height;
    int cursorX, cursorY;
};
