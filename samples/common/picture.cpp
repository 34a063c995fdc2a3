// SPDX-License-Identifier: Apache-2.0
#include "picture.h"

#include "png_image.h"

#include <cstdio>

void addPictureOptions(Arguments& arguments, Picture& picture) {
    arguments.add("-o,--output", picture.output, "picture to write");
    arguments.add("--width", picture.width, 1, 8192, "pixels across");
    arguments.add("--height", picture.height, 1, 8192, "pixels down");
}

void launch(OptixPipeline pipeline, const OptixShaderBindingTable& table, const void* params,
            size_t paramsSize, const Picture& picture) {
    DeviceBuffer deviceParams;
    deviceParams.upload(params, paramsSize);
    OPTIX_CHECK(optixLaunch(pipeline, nullptr, deviceParams.address(), paramsSize, &table,
                            picture.width, picture.height, 1));
    CUDA_CHECK(cudaDeviceSynchronize());
}

void writePicture(const Picture& picture, const DeviceBuffer& image, bool filmic) {
    writePng(picture.output, picture.width, picture.height,
             toSrgb(image.download<float>(), filmic));
    std::printf("wrote %s\n", picture.output.c_str());
}

int runSample(const char* name, const Arguments& arguments, int argc, char** argv,
              const std::function<void(OptixDeviceContext)>& body) {
    return runSample(name, [&] {
        if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
            return 0;
        OptixDeviceContext context = createContext();
        body(context);
        OPTIX_CHECK(optixDeviceContextDestroy(context));
        return 0;
    });
}
