// SPDX-License-Identifier: Apache-2.0
#include "picture6.h"

#include "check6.h"
#include "png_image.h"

#include <cmath>
#include <cstdio>

void addOptions(Arguments& arguments, ClassicPicture& picture) {
    arguments.add("-o,--output", picture.output, "picture to write");
    arguments.add("--width", picture.width, 1, 8192, "pixels across");
    arguments.add("--height", picture.height, 1, 8192, "pixels down");
}

void writePicture(const ClassicPicture& picture, RTbuffer buffer, bool filmic) {
    RTcontext context = nullptr;
    void* data = nullptr;
    RT_CHECK(nullptr, rtBufferGetContext(buffer, &context));
    RT_CHECK(context, rtBufferMapEx(buffer, RT_BUFFER_MAP_READ, 0, nullptr, &data));
    const float* first = static_cast<const float*>(data);
    const std::vector<float> linear(first, first + size_t(picture.width) * picture.height * 4);
    RT_CHECK(context, rtBufferUnmap(buffer));
    writePng(picture.output, picture.width, picture.height, toSrgb(linear, filmic));
    std::printf("wrote %s\n", picture.output.c_str());
}

ClassicCamera makeCamera(optix::float3 eye, optix::float3 lookAt, float verticalFov, float aspect) {
    using namespace optix;
    ClassicCamera camera;
    camera.eye = eye;
    camera.forward = normalize(lookAt - eye);
    const float halfHeight = std::tan(verticalFov * 0.5f * M_PIf / 180.0f);
    const float3 right = normalize(cross(camera.forward, make_float3(0.0f, 1.0f, 0.0f)));
    camera.up = cross(right, camera.forward) * halfHeight;
    camera.right = right * (halfHeight * aspect);
    return camera;
}

int runClassicSample(const char* name, const Arguments& arguments, int argc, char** argv,
                     const std::function<void()>& body) {
    return runSample(name, [&] {
        if (arguments.parse(argc, argv) == Arguments::Result::kRun)
            body();
        return 0;
    });
}
