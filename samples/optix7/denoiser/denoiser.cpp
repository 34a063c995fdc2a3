// SPDX-License-Identifier: Apache-2.0
// Path traces a scene with few samples, denoises it with albedo and normals as guides, and writes
// both pictures side by side. With a reference of many samples it prints the gain. Read
// mesh_path_tracer first.
#include "arguments.h"
#include "image_denoiser.h"
#include "path_tracer.h"
#include "png_image.h"
#include "quality.h"
#include "views.h"

#include <optix_function_table_definition.h>

#include <cstdio>

namespace {

struct Options {
    std::string output = "denoiser.png";
    unsigned width = 480, height = 540, samples = 4, reference = 256, scene = 3;
};

// The left picture, a line of two pixels, the right picture.
std::vector<float> sideBySide(const std::vector<float>& left, const std::vector<float>& right,
                              unsigned width, unsigned height) {
    std::vector<float> both;
    for (unsigned y = 0; y < height; ++y) {
        auto row = [&](const std::vector<float>& image) {
            both.insert(both.end(), image.begin() + y * width * 4,
                        image.begin() + (y + 1) * width * 4);
        };
        row(left);
        both.insert(both.end(), 8, 1.0f);
        row(right);
    }
    return both;
}

void render(OptixDeviceContext context, const Options& options) {
    View view = makeView(options.scene, float(options.width) / float(options.height));
    PathTracer tracer(context, view.scene, view.lights, view.camera, options.width, options.height);
    tracer.wantGuides(view.camera);
    tracer.addSamples(options.samples);
    NoisyImage noisy;
    noisy.layers = {tracer.image()};
    noisy.albedo = tracer.albedo();
    noisy.normal = tracer.normal();
    ImageDenoiser denoiser(context, OPTIX_DENOISER_MODEL_KIND_HDR, true, true, options.width,
                           options.height);
    std::vector<float> denoised = denoiser.denoise(noisy)[0];

    if (options.reference != 0) {
        tracer.restart();
        tracer.addSamples(options.reference);
        double before = psnr(noisy.layers[0], tracer.image()),
               after = psnr(denoised, tracer.image());
        std::printf("%s: %u samples %.1f dB, denoised %.1f dB, gain %.1f dB\n", view.name,
                    options.samples, before, after, after - before);
    }
    writePng(options.output, 2 * options.width + 2, options.height,
             toSrgb(sideBySide(noisy.layers[0], denoised, options.width, options.height), true));
    std::printf("wrote %s\n", options.output.c_str());
}

int run(int argc, char** argv) {
    Options options;
    Arguments arguments("Path traces a scene with few samples and denoises it.");
    arguments.add("-o,--output", options.output, "picture to write: before and after");
    arguments.add("--width", options.width, 1, 8192, "pixels across, each half");
    arguments.add("--height", options.height, 1, 8192, "pixels down");
    arguments.add("--spp", options.samples, 1, 65536, "samples for each pixel");
    arguments.add("--reference", options.reference, 0, 65536,
                  "samples for each pixel of what it is compared with; 0: nothing");
    arguments.add("--scene", options.scene, 0, kViewCount - 1,
                  "0 knot, 1 textures, 2 relief, 3 glossy, 4 lantern");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;

    OptixDeviceContext context = createContext();
    render(context, options);
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("denoiser", [&] { return run(argc, argv); });
}
