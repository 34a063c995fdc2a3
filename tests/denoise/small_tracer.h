// SPDX-License-Identifier: Apache-2.0
// A path tracer for a few spheres and rectangles. Its pictures have the noise of a renderer, and
// guides from the same jittered samples. Each run of a test can afford to make them. hard_scenes.h
// has the scenes.
#pragma once

#include "denoise/test_scene.h"

#include <vector>

namespace hard {

using sunstone::denoise::test::Picture;
using sunstone::denoise::test::Rendering;
using sunstone::denoise::test::Vec;

// Reflectance at a place of a surface.
using Texture = Vec (*)(Vec place);

struct Material {
    Vec albedo{0, 0, 0};
    Vec emission{0, 0, 0};
    bool isMirror = false;
    float roughness = 0;       // of a mirror
    Texture texture = nullptr; // in place of the albedo
    Texture glow = nullptr;    // in place of the emission
};

struct Sphere {
    Vec center;
    float radius;
    Material material;
};

// Perpendicular to one axis (0 to 2) at `offset`. The extents along the other two are in the order
// of the axes.
struct Rectangle {
    int axis;
    float offset;
    float low[2], high[2];
    Material material;
};

struct Scene {
    const char* name = "";
    std::vector<Sphere> spheres;
    std::vector<Rectangle> rectangles;
    std::vector<Sphere> lamps; // seen, and sampled unless lightByChance
    bool lightByChance = false;
    Vec zenith{0, 0, 0}, horizon{0, 0, 0};
    Vec eye{0, 1.3f, 4}, target{0, 0.6f, 0};
    float fieldOfView = 0.8f; // height of the picture at distance 1
    float aperture = 0;       // radius of the lens, focused on the target
    int depth = 4;
};

Rendering render(const Scene& scene, uint32_t width, uint32_t height, uint32_t samples,
                 uint32_t seed);

} // namespace hard
