// SPDX-License-Identifier: Apache-2.0
// The common part of samples that render one picture: options for its file and size, a context, the
// launch, the PNG. The sample `hello` contains these steps in full; other samples use these
// functions.
#pragma once

#include "arguments.h"
#include "optix_setup.h"

#include <functional>
#include <string>

struct Picture {
    std::string output;
    unsigned width, height;

    size_t pixels() const { return size_t(width) * height; }
    float aspect() const { return float(width) / float(height); }
};

// The options -o, --width and --height; the picture's values are the defaults.
void addPictureOptions(Arguments& arguments, Picture& picture);

// Runs the ray generation program once for each pixel, with `params` as its launch parameters, and
// waits for the end.
void launch(OptixPipeline pipeline, const OptixShaderBindingTable& table, const void* params,
            size_t paramsSize, const Picture& picture);
template <class Params>
void launch(OptixPipeline pipeline, const OptixShaderBindingTable& table, const Params& params,
            const Picture& picture) {
    launch(pipeline, table, &params, sizeof(params), picture);
}

// Writes the PNG and prints its name. `image` has a float4 for each pixel; `filmic` as in toSrgb().
void writePicture(const Picture& picture, const DeviceBuffer& image, bool filmic = false);

// The rest of main(): reads the command line and calls `body` with a context, which it destroys
// afterwards.
int runSample(const char* name, const Arguments& arguments, int argc, char** argv,
              const std::function<void(OptixDeviceContext)>& body);
