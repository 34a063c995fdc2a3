// SPDX-License-Identifier: Apache-2.0
// The common part of classic samples that render one picture: options for its file and size, a
// camera as three vectors, the PNG. The sample `hello` contains these steps in full.
#pragma once

#include "arguments.h"

#include <optix.h>
#include <optix_math.h>

#include <functional>
#include <string>
#include <vector>

struct ClassicPicture {
    std::string output;
    unsigned width, height;

    float aspect() const { return float(width) / float(height); }
};

// The options -o, --width and --height; the picture's values are the defaults.
void addOptions(Arguments& arguments, ClassicPicture& picture);

// Writes a buffer of RT_FORMAT_FLOAT4 as PNG and prints its name; `filmic` as in toSrgb().
void writePicture(const ClassicPicture& picture, RTbuffer buffer, bool filmic = false);

// The vectors U, V and W of a pinhole camera: to the right edge, the upper edge and the middle.
struct ClassicCamera {
    optix::float3 eye, right, up, forward;
};
ClassicCamera makeCamera(optix::float3 eye, optix::float3 lookAt, float verticalFov, float aspect);

// The rest of main(): reads the command line and runs the body.
int runClassicSample(const char* name, const Arguments& arguments, int argc, char** argv,
                     const std::function<void()>& body);

std::string_view shapes_ptx(); // the PTX of shapes.cu: spheres and parallelograms
