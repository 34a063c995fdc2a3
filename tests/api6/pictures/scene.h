// SPDX-License-Identifier: Apache-2.0
// A scene that both APIs render. Each instance has its own colour.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace sunstone::pictures {

struct Instance {
    std::array<float, 12> matrix; // rows
    std::array<float, 3> albedo;
};

struct Scene {
    std::vector<std::array<float, 3>> vertices;
    std::vector<std::array<unsigned, 3>> triangles;
    std::vector<std::array<float, 4>> spheres; // in place of triangles: centre and radius
    std::vector<Instance> instances;
    bool isTransparent = false; // any-hit programs cut holes and dim shadows
};

constexpr unsigned kWidth = 96, kHeight = 72;

// Colour and distance of each pixel.
using Picture = std::vector<std::array<float, 4>>;

// Both read their programs from the PTX file.
Picture drawClassic(const Scene& scene, const std::string& ptxFile);
Picture drawModern(const Scene& scene, const std::string& ptxFile);

} // namespace sunstone::pictures
