// SPDX-License-Identifier: Apache-2.0
// The model of the sample, without the vector types of either API's samples.
#pragma once

#include <array>
#include <string>
#include <vector>

struct PlainMesh {
    std::vector<std::array<float, 3>> positions, normals;
    std::vector<std::array<unsigned, 3>> triangles;
};

struct Model {
    PlainMesh object, ground;
    float radius; // of the object, whose centre is at the origin
};

// Loads an OBJ file; without a file, generates a knot.
Model loadModel(const std::string& file);
