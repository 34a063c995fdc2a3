// SPDX-License-Identifier: Apache-2.0
#pragma once
struct Node { // of an expression: an operation and its children
    int operation, left, right;
    float constant;
};
struct Params {
    OptixTraversableHandle scene;
    float* out;
};
struct MaterialData {
    const Node* nodes;
    int root, first; // the first operation's callable
};
