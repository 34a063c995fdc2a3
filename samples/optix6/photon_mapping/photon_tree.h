// SPDX-License-Identifier: Apache-2.0
// A k-d tree over photons in an array without pointers.
#pragma once

#include "photons.h"

#include <cstddef>
#include <vector>

// The stored photons as a left-balanced tree: the children of node i are 2 i + 1 and 2 i + 2.
std::vector<Photon> buildTree(const Photon* photons, size_t count);
