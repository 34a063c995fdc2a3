// SPDX-License-Identifier: Apache-2.0
// What the host and the device code of node_graph share.
#pragma once

// A node of the graph: what a function does with two inputs.
struct Node {
    int function;    // id of a callable program
    int left, right; // numbers of nodes; below 0: none
    float constant;
};
