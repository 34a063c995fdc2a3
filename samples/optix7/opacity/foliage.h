// SPDX-License-Identifier: Apache-2.0
// The scene of the sample: plants on a ground, with leaves cut out of squares.
#pragma once

#include "params.h"

#include <vector>

struct Foliage {
    std::vector<float3> vertices;
    std::vector<unsigned> indices;   // three for each triangle
    std::vector<unsigned> materials; // for each triangle
    std::vector<float3> normals;     // for each pair of triangles
};

// `leaves` leaves on seven plants. Pairs of triangles as leafCoordinates() has them.
Foliage makeFoliage(unsigned leaves);

// The mask of a leaf: size * size texels.
std::vector<unsigned char> makeLeafMask(unsigned size);

// The states of the micro-triangles of one of a leaf's two triangles, in the order of the API:
// opaque or transparent if the mask is uniform there, unknown if the any-hit program must decide.
std::vector<unsigned char> leafStates(const Mask& mask, unsigned triangle, unsigned level);

// States as the bytes of a 4-state micromap.
std::vector<unsigned char> packStates(const std::vector<unsigned char>& states);
