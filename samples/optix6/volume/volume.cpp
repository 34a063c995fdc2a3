// SPDX-License-Identifier: Apache-2.0
// A cloud from a texture of three dimensions, with the C API. --print-x and --print-y choose a
// pixel whose steps rtPrintf reports. Read next: progressive.
#include "check6.h"
#include "picture6.h"

#include <optixu/optixu.h>

#include <algorithm>
#include <cmath>
#include <string_view>

std::string_view volume_ptx(); // the PTX of volume.cu, built into this program

namespace {

using optix::float3;
using optix::make_float3;

constexpr unsigned kSide = 48; // texels of an edge

float latticeValue(int x, int y, int z) {
    unsigned h = unsigned(x) * 73856093u ^ unsigned(y) * 19349663u ^ unsigned(z) * 83492791u;
    h = (h ^ (h >> 13)) * 1274126177u;
    return float((h ^ (h >> 16)) & 0xffffu) / 65535.0f;
}
// Smooth noise between lattice points (Perlin's interpolation).
float noise(float3 p) {
    const int x = int(std::floor(p.x)), y = int(std::floor(p.y)), z = int(std::floor(p.z));
    const auto smooth = [](float t) { return t * t * (3.0f - 2.0f * t); };
    const float u = smooth(p.x - float(x)), v = smooth(p.y - float(y)), w = smooth(p.z - float(z));
    float sum = 0.0f;
    for (int i = 0; i < 8; ++i) {
        const int a = i & 1, b = i >> 1 & 1, c = i >> 2;
        sum +=
            latticeValue(x + a, y + b, z + c) * (a ? u : 1 - u) * (b ? v : 1 - v) * (c ? w : 1 - w);
    }
    return sum;
}
// Three puffs with a rough surface, from 0 to 1.
float cloudAt(float3 p) {
    const float3 centres[3] = {make_float3(0.36f, 0.45f, 0.5f), make_float3(0.62f, 0.42f, 0.45f),
                               make_float3(0.5f, 0.6f, 0.55f)};
    const float radii[3] = {0.27f, 0.24f, 0.25f};
    float inside = -1.0f;
    for (int i = 0; i < 3; ++i)
        inside = std::max(inside, 1.0f - optix::length(p - centres[i]) / radii[i]);
    float rough = 0.0f, weight = 0.5f, scale = 5.0f;
    for (int i = 0; i < 4; ++i, weight *= 0.5f, scale *= 2.0f)
        rough += weight * (noise(p * scale) - 0.5f);
    return std::min(1.0f, std::max(0.0f, 2.5f * (inside + 1.1f * rough)));
}

class Renderer {
public:
    Renderer() {
        RT_CHECK(nullptr, rtContextCreate(&context_));
        check(rtContextSetEntryPointCount(context_, 1));
        check(rtContextSetRayTypeCount(context_, 1));
        check(rtContextSetRayGenerationProgram(context_, 0, program("camera")));
        check(rtContextSetExceptionProgram(context_, 0, program("show_exception")));
        check(rtContextSetMissProgram(context_, 0, program("miss")));
    }
    ~Renderer() { rtContextDestroy(context_); }
    Renderer(const Renderer&) = delete;

    void set(const char* name, float3 value) { check(rtVariableSet3fv(variable(name), &value.x)); }
    void set(const char* name, float value) { check(rtVariableSet1f(variable(name), value)); }

    // Prints only for one launch index, because the output of all would be long.
    void printAt(unsigned x, unsigned y) {
        check(rtContextSetPrintEnabled(context_, 1));
        check(rtContextSetPrintBufferSize(context_, 1 << 16));
        check(rtContextSetPrintLaunchIndex(context_, int(x), int(y), 0));
    }

    void setDensity() {
        RTbuffer texels = nullptr;
        RTtexturesampler sampler = nullptr;
        void* data = nullptr;
        check(rtBufferCreate(context_, RT_BUFFER_INPUT, &texels));
        check(rtBufferSetFormat(texels, RT_FORMAT_FLOAT));
        check(rtBufferSetSize3D(texels, kSide, kSide, kSide));
        check(rtBufferMap(texels, &data));
        float* to = static_cast<float*>(data);
        for (unsigned z = 0; z < kSide; ++z)
            for (unsigned y = 0; y < kSide; ++y)
                for (unsigned x = 0; x < kSide; ++x)
                    *to++ = cloudAt((make_float3(float(x), float(y), float(z)) + 0.5f) / kSide);
        check(rtBufferUnmap(texels));
        check(rtTextureSamplerCreate(context_, &sampler));
        for (unsigned i = 0; i < 3; ++i)
            check(rtTextureSamplerSetWrapMode(sampler, i, RT_WRAP_CLAMP_TO_BORDER));
        check(rtTextureSamplerSetFilteringModes(sampler, RT_FILTER_LINEAR, RT_FILTER_LINEAR,
                                                RT_FILTER_NONE));
        check(rtTextureSamplerSetIndexingMode(sampler, RT_TEXTURE_INDEX_NORMALIZED_COORDINATES));
        check(rtTextureSamplerSetReadMode(sampler, RT_TEXTURE_READ_ELEMENT_TYPE));
        check(rtTextureSamplerSetBuffer(sampler, 0, 0, texels));
        int id = 0;
        check(rtTextureSamplerGetId(sampler, &id));
        check(rtVariableSet1i(variable("density_texture"), id));
    }

    void setBox(float3 low, float3 high) {
        set("box_low", low);
        set("box_high", high);
        RTgeometry geometry = nullptr;
        RTmaterial material = nullptr;
        RTgeometryinstance instance = nullptr;
        RTgeometrygroup group = nullptr;
        RTacceleration acceleration = nullptr;
        check(rtGeometryCreate(context_, &geometry));
        check(rtGeometrySetPrimitiveCount(geometry, 1));
        check(rtGeometrySetIntersectionProgram(geometry, program("intersect_box")));
        check(rtGeometrySetBoundingBoxProgram(geometry, program("bound_box")));
        check(rtMaterialCreate(context_, &material));
        check(rtMaterialSetClosestHitProgram(material, 0, program("hit_cloud")));
        check(rtGeometryInstanceCreate(context_, &instance));
        check(rtGeometryInstanceSetGeometry(instance, geometry));
        check(rtGeometryInstanceSetMaterialCount(instance, 1));
        check(rtGeometryInstanceSetMaterial(instance, 0, material));
        check(rtGeometryGroupCreate(context_, &group));
        check(rtAccelerationCreate(context_, &acceleration));
        check(rtAccelerationSetBuilder(acceleration, "NoAccel"));
        check(rtGeometryGroupSetAcceleration(group, acceleration));
        check(rtuGeometryGroupAddChild(group, instance, nullptr));
        check(rtVariableSetObject(variable("top_object"), group));
    }

    void render(const ClassicPicture& picture) {
        RTbuffer buffer = nullptr;
        check(rtBufferCreate(context_, RT_BUFFER_OUTPUT, &buffer));
        check(rtBufferSetFormat(buffer, RT_FORMAT_FLOAT4));
        check(rtBufferSetSize2D(buffer, picture.width, picture.height));
        check(rtVariableSetObject(variable("picture"), buffer));
        check(rtContextValidate(context_));
        check(rtContextLaunch2D(context_, 0, picture.width, picture.height));
        writePicture(picture, buffer);
    }

private:
    void check(RTresult result) { RT_CHECK(context_, result); }
    RTprogram program(const char* name) {
        static const std::string ptx(volume_ptx());
        RTprogram made = nullptr;
        check(rtProgramCreateFromPTXString(context_, ptx.c_str(), name, &made));
        return made;
    }
    RTvariable variable(const char* name) {
        RTvariable found = nullptr;
        check(rtContextQueryVariable(context_, name, &found));
        if (!found)
            check(rtContextDeclareVariable(context_, name, &found));
        return found;
    }

    RTcontext context_ = nullptr;
};

void render(const ClassicPicture& picture, unsigned printX, unsigned printY) {
    Renderer renderer;
    renderer.setDensity();
    renderer.setBox(make_float3(-1.0f), make_float3(1.0f));
    renderer.set("density_scale", 9.0f);
    renderer.set("step_length", 0.03f);
    renderer.set("sun", optix::normalize(make_float3(-0.6f, 0.8f, 0.4f)));
    renderer.set("sun_color", make_float3(0.85f, 0.75f, 0.6f));
    const ClassicCamera camera =
        makeCamera(make_float3(0.4f, 0.3f, 3.4f), make_float3(0.0f), 38.0f, picture.aspect());
    renderer.set("eye", camera.eye);
    renderer.set("camera_right", camera.right);
    renderer.set("camera_up", camera.up);
    renderer.set("camera_forward", camera.forward);
    if (printX < picture.width && printY < picture.height)
        renderer.printAt(printX, printY);
    renderer.render(picture);
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"volume.png", 480, 360};
    unsigned printX = 8192, printY = 8192;
    Arguments arguments("A cloud from a texture of three dimensions.");
    addOptions(arguments, picture);
    arguments.add("--print-x", printX, 0, 8192, "pixel that reports its steps");
    arguments.add("--print-y", printY, 0, 8192, "its row");
    return runClassicSample("volume", arguments, argc, argv,
                            [&] { render(picture, printX, printY); });
}
