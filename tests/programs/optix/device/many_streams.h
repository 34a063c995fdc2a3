// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Tile {
    OptixTraversableHandle scene;
    unsigned* out;
    unsigned request;
    float offset;
};
