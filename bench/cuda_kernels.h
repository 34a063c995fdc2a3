// SPDX-License-Identifier: Apache-2.0
// Sizes shared by the kernels and their peers in C++.
#pragma once

constexpr int kTile = 256;          // bodies per tile, threads per block
constexpr int kRadius = 8;          // of the convolution
constexpr float kSoftening = 0.01f; // of the gravity

struct Body {
    float x, y, z, mass;
};
struct Force {
    float x, y, z;
};
