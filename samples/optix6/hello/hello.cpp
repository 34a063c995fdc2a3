// SPDX-License-Identifier: Apache-2.0
// The smallest program of the classic API, with every step in full: a ray generation program fills
// a buffer with a colour. Read next: mesh_path_tracer.
#include "arguments.h"
#include "check6.h"
#include "png_image.h"

#include <optix.h>

#include <cstdio>
#include <string_view>

std::string_view hello_ptx(); // the PTX of hello.cu, built into this program

namespace {

int run(int argc, char** argv) {
    std::string output = "hello.png";
    unsigned width = 512, height = 384;
    Arguments arguments("Fills a picture with a colour by a ray generation program.");
    arguments.add("-o,--output", output, "picture to write");
    arguments.add("--width", width, 1, 8192, "pixels across");
    arguments.add("--height", height, 1, 8192, "pixels down");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;

    // 1. A context, with one entry point and one type of rays.
    RTcontext context = nullptr;
    RT_CHECK(nullptr, rtContextCreate(&context));
    RT_CHECK(context, rtContextSetEntryPointCount(context, 1));
    RT_CHECK(context, rtContextSetRayTypeCount(context, 1));

    // 2. A buffer for the picture, and the variable by which the program finds it.
    RTbuffer buffer = nullptr;
    RTvariable result = nullptr;
    RT_CHECK(context, rtBufferCreate(context, RT_BUFFER_OUTPUT, &buffer));
    RT_CHECK(context, rtBufferSetFormat(buffer, RT_FORMAT_FLOAT4));
    RT_CHECK(context, rtBufferSetSize2D(buffer, width, height));
    RT_CHECK(context, rtContextDeclareVariable(context, "result", &result));
    RT_CHECK(context, rtVariableSetObject(result, buffer));

    // 3. The program, which has the colour as a variable of its own.
    RTprogram program = nullptr;
    RTvariable color = nullptr;
    const std::string ptx(hello_ptx());
    RT_CHECK(context, rtProgramCreateFromPTXString(context, ptx.c_str(), "fill", &program));
    RT_CHECK(context, rtProgramDeclareVariable(program, "color", &color));
    RT_CHECK(context, rtVariableSet3f(color, 0.462f, 0.725f, 0.0f));
    RT_CHECK(context, rtContextSetRayGenerationProgram(context, 0, program));

    // 4. One call of the program for each pixel.
    RT_CHECK(context, rtContextValidate(context));
    RT_CHECK(context, rtContextLaunch2D(context, 0, width, height));

    // 5. The picture.
    void* data = nullptr;
    RT_CHECK(context, rtBufferMap(buffer, &data));
    const float* pixels = static_cast<const float*>(data);
    const std::vector<float> linear(pixels, pixels + size_t(width) * height * 4);
    RT_CHECK(context, rtBufferUnmap(buffer));
    writePng(output, width, height, toSrgb(linear, false));
    std::printf("wrote %s\n", output.c_str());

    // The context owns all other objects.
    RT_CHECK(context, rtContextDestroy(context));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("hello", [&] { return run(argc, argv); });
}
