// SPDX-License-Identifier: Apache-2.0
// One path tracer through two APIs, each in a file of its own: their headers share names.
#pragma once

#include "tracer_params.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace twin {

// A mesh, or spheres where it is empty, seen through instances.
struct Scene {
    std::string name;
    std::vector<float> vertices;                  // 3 each
    std::vector<unsigned> indices;                // 3 each
    std::vector<float> spheres;                   // 4 each
    std::vector<std::array<float, 12>> instances; // object to world, rows
    Camera camera;
};

class Renderer {
public:
    virtual ~Renderer() = default;
    virtual void launch() = 0;                // returns at the end of the picture
    virtual std::vector<float> picture() = 0; // of the last launch; four floats a pixel
};

// Text of a file of the build, or of one with that name beside the program.
std::string readDeviceCode(const char* path);

// Throw std::runtime_error.
std::unique_ptr<Renderer> makeClassic(const Scene& scene, unsigned width, unsigned height,
                                      unsigned samples);
std::unique_ptr<Renderer> makeOptix7(const Scene& scene, unsigned width, unsigned height,
                                     unsigned samples);

// Milliseconds of things that classic applications do.
struct ClassicTimes {
    double createPrograms; // 1,460 programs of five texts
    double moveInstance;   // from a new transform to the end of a small launch, 10,000 instances
    double setVariable;    // the same for a variable of a material
    double smallLaunch;    // the same launch without a change
    // Once: 100 programs of as many texts, and the first launch of a context that uses them.
    double createMany, firstLaunch;
};
ClassicTimes timeClassic(const Scene& scene);

} // namespace twin
