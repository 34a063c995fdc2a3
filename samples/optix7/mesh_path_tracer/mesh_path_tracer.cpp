// SPDX-License-Identifier: Apache-2.0
// Path traces a mesh, an OBJ file or a generated knot, in a little photo studio. Read triangle
// first; then path_tracer.cu, shading.h, path_tracer.cpp.
#include "arguments.h"
#include "path_tracer.h"
#include "png_image.h"
#include "progress.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cstdio>

namespace {

struct Options {
    std::string model;
    std::string output = "mesh_path_tracer.png";
    unsigned width = 960, height = 540, samples = 32, triangles = 200000;
};

void render(OptixDeviceContext context, const Options& options) {
    HostScene scene = options.model.empty() ? makeKnot(options.triangles) : loadObj(options.model);
    std::fprintf(stderr, "%zu triangles\n", scene.triangles.size());
    Bounds bounds = boundsOf(scene);
    addGround(scene, bounds, bounds.low.y, {vec(0.36f, 0.35f, 0.34f), 0.5f, vec(0.0f), 0.0f});
    Camera camera =
        orbitCamera(bounds, 30.0f, 18.0f, 1.0f, float(options.width) / float(options.height));
    PathTracer tracer(context, scene, makeStudio(bounds), camera, options.width, options.height);

    Progress progress("rendering", options.samples);
    while (tracer.samples() < options.samples) {
        tracer.addSamples(std::min(4u, options.samples - tracer.samples()));
        progress.update(tracer.samples());
    }
    writePng(options.output, options.width, options.height, toSrgb(tracer.image(), true));
    std::printf("wrote %s\n", options.output.c_str());
}

int run(int argc, char** argv) {
    Options options;
    Arguments arguments("Path traces a mesh: sky and area lights, diffuse and glossy material.");
    arguments.addPositional("MODEL.obj", options.model, "model (default: a generated knot)");
    arguments.add("-o,--output", options.output, "picture to write");
    arguments.add("--width", options.width, 1, 8192, "pixels across");
    arguments.add("--height", options.height, 1, 8192, "pixels down");
    arguments.add("--spp", options.samples, 1, 65536, "samples for each pixel");
    arguments.add("--triangles", options.triangles, 1000, 50000000, "size of the generated knot");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;

    OptixDeviceContext context = createContext();
    render(context, options);
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("mesh_path_tracer", [&] { return run(argc, argv); });
}
