// SPDX-License-Identifier: Apache-2.0
// One path tracer through two APIs. Each is in a file of its own, because the APIs' headers share
// names.
#pragma once

#include "tracer_params.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace twin {

// Instances of a mesh, or of spheres if the mesh is empty.
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

// The text of a file of the build, or of the file with that name beside the program.
std::string readDeviceCode(const char* path);

// Throw std::runtime_error.
std::unique_ptr<Renderer> makeClassic(const Scene& scene, unsigned width, unsigned height,
                                      unsigned samples);
std::unique_ptr<Renderer> makeOptix7(const Scene& scene, unsigned width, unsigned height,
                                     unsigned samples);

// Milliseconds of common operations of classic applications.
struct ClassicTimes {
    double createPrograms; // 1,460 programs of five texts
    double moveInstance;   // from a new transform to the end of a small launch, 10,000 instances
    double setVariable;    // the same for a variable of a material
    double smallLaunch;    // the same launch without a change
    // Measured once: 100 programs from 100 texts, and the first launch of a context with them.
    double createMany, firstLaunch;
};
ClassicTimes timeClassic(const Scene& scene);

} // namespace twin
