// SPDX-License-Identifier: Apache-2.0
// Renders an OBJ model, or a generated one, with the path tracer of path_tracer.cu: geometry with
// programs of its own, two materials, a transform, two types of rays, exceptions.
#include "arguments.h"
#include "camera.h"
#include "check6.h"
#include "host_scene.h"
#include "png_image.h"

#include <cstdio>
#include <cstring>
#include <string_view>

std::string_view path_tracer_ptx(); // the PTX of path_tracer.cu, built into this program

namespace {

enum RayType { kPathRay, kShadowRay, kRayTypes };

class Renderer {
public:
    Renderer() {
        RT_CHECK(nullptr, rtContextCreate(&context_));
        check(rtContextSetEntryPointCount(context_, 1));
        check(rtContextSetRayTypeCount(context_, kRayTypes));
        check(rtContextSetRayGenerationProgram(context_, 0, program("trace_paths")));
        check(rtContextSetExceptionProgram(context_, 0, program("show_exception")));
        check(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_ALL, 1));
        check(rtContextSetPrintEnabled(context_, 1));
        check(rtContextSetMissProgram(context_, kPathRay, program("miss_path")));
    }
    ~Renderer() { rtContextDestroy(context_); }
    Renderer(const Renderer&) = delete;

    void setScene(const HostScene& scene) {
        RTgeometrygroup group = nullptr;
        RTacceleration acceleration = nullptr;
        RTtransform transform = nullptr;
        RTgroup top = nullptr;
        check(rtGeometryGroupCreate(context_, &group));
        check(rtGeometryGroupSetChildCount(group, 1));
        check(rtGeometryGroupSetChild(group, 0, instance(scene, vec(0.75f, 0.62f, 0.5f))));
        check(rtAccelerationCreate(context_, &acceleration));
        check(rtAccelerationSetBuilder(acceleration, "Trbvh"));
        check(rtGeometryGroupSetAcceleration(group, acceleration));

        // The ground has a group of its own, below a transform that moves it.
        RTgeometrygroup ground = nullptr;
        RTacceleration groundAcceleration = nullptr, topAcceleration = nullptr;
        HostScene square;
        const Bounds bounds = boundsOf(scene);
        addGround(square, bounds, 0.0f, ::Material{});
        check(rtGeometryGroupCreate(context_, &ground));
        check(rtGeometryGroupSetChildCount(ground, 1));
        check(rtGeometryGroupSetChild(ground, 0, instance(square, vec(0.35f, 0.4f, 0.45f))));
        check(rtAccelerationCreate(context_, &groundAcceleration));
        check(rtAccelerationSetBuilder(groundAcceleration, "Bvh"));
        check(rtGeometryGroupSetAcceleration(ground, groundAcceleration));
        const float matrix[16] = {1, 0, 0, 0, 0, 1, 0, bounds.low.y, 0, 0, 1, 0, 0, 0, 0, 1};
        check(rtTransformCreate(context_, &transform));
        check(rtTransformSetMatrix(transform, 0, matrix, nullptr));
        check(rtTransformSetChild(transform, ground));

        check(rtGroupCreate(context_, &top));
        check(rtGroupSetChildCount(top, 2));
        check(rtGroupSetChild(top, 0, group));
        check(rtGroupSetChild(top, 1, transform));
        check(rtAccelerationCreate(context_, &topAcceleration));
        check(rtAccelerationSetBuilder(topAcceleration, "NoAccel"));
        check(rtGroupSetAcceleration(top, topAcceleration));
        check(rtVariableSetObject(variable("top_object"), top));
        check(rtVariableSet1f(variable("scene_epsilon"), bounds.radius() * 1e-4f));
    }

    void setCamera(const Camera& camera) {
        set("eye", camera.eye);
        set("camera_forward", camera.forward);
        set("camera_right", camera.right);
        set("camera_up", camera.up);
    }

    std::vector<float> render(unsigned width, unsigned height, unsigned samples, unsigned depth) {
        RTbuffer picture = nullptr;
        check(rtBufferCreate(context_, RT_BUFFER_OUTPUT, &picture));
        check(rtBufferSetFormat(picture, RT_FORMAT_FLOAT4));
        check(rtBufferSetSize2D(picture, width, height));
        check(rtVariableSetObject(variable("picture"), picture));
        check(rtVariableSet1ui(variable("samples"), samples));
        check(rtVariableSet1ui(variable("max_depth"), depth));
        set("sky_color", vec(0.35f, 0.55f, 0.9f));
        set("sun_direction", normalize(vec(0.5f, 0.8f, 0.4f)));
        set("sun_color", vec(1.6f, 1.45f, 1.2f));
        check(rtContextValidate(context_));
        check(rtContextLaunch2D(context_, 0, width, height));
        void* data = nullptr;
        check(rtBufferMap(picture, &data));
        const float* first = static_cast<const float*>(data);
        std::vector<float> pixels(first, first + size_t(width) * height * 4);
        check(rtBufferUnmap(picture));
        return pixels;
    }

private:
    void check(RTresult result) {
        if (result != RT_SUCCESS)
            classicFail(context_, result, "a call of the renderer", __FILE__, __LINE__);
    }
    RTprogram program(const char* name) {
        static const std::string ptx(path_tracer_ptx());
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
    void set(const char* name, float3 value) {
        check(rtVariableSet3f(variable(name), value.x, value.y, value.z));
    }

    template <class T>
    RTbuffer buffer(RTformat format, const std::vector<T>& items) {
        RTbuffer made = nullptr;
        void* data = nullptr;
        check(rtBufferCreate(context_, RT_BUFFER_INPUT, &made));
        check(rtBufferSetFormat(made, format));
        check(rtBufferSetSize1D(made, items.size()));
        check(rtBufferMap(made, &data));
        std::memcpy(data, items.data(), items.size() * sizeof(T));
        check(rtBufferUnmap(made));
        return made;
    }
    void bind(RTgeometry geometry, const char* name, RTbuffer value) {
        RTvariable made = nullptr;
        check(rtGeometryDeclareVariable(geometry, name, &made));
        check(rtVariableSetObject(made, value));
    }

    // A mesh with a material of its own; the material's programs are shared.
    RTgeometryinstance instance(const HostScene& scene, float3 albedo) {
        RTgeometry geometry = nullptr;
        check(rtGeometryCreate(context_, &geometry));
        check(rtGeometrySetPrimitiveCount(geometry, unsigned(scene.triangles.size())));
        check(rtGeometrySetBoundingBoxProgram(geometry, program("bound_mesh")));
        check(rtGeometrySetIntersectionProgram(geometry, program("intersect_mesh")));
        bind(geometry, "vertices", buffer(RT_FORMAT_FLOAT3, scene.positions));
        bind(geometry, "normals", buffer(RT_FORMAT_FLOAT3, scene.normals));
        bind(geometry, "triangles", buffer(RT_FORMAT_UNSIGNED_INT3, scene.triangles));

        RTmaterial material = nullptr;
        check(rtMaterialCreate(context_, &material));
        check(rtMaterialSetClosestHitProgram(material, kPathRay, program("hit_path")));
        check(rtMaterialSetAnyHitProgram(material, kShadowRay, program("block_light")));

        RTgeometryinstance made = nullptr;
        RTvariable color = nullptr;
        check(rtGeometryInstanceCreate(context_, &made));
        check(rtGeometryInstanceSetGeometry(made, geometry));
        check(rtGeometryInstanceSetMaterialCount(made, 1));
        check(rtGeometryInstanceSetMaterial(made, 0, material));
        check(rtGeometryInstanceDeclareVariable(made, "albedo", &color));
        check(rtVariableSet3f(color, albedo.x, albedo.y, albedo.z));
        return made;
    }

    RTcontext context_ = nullptr;
};

int run(int argc, char** argv) {
    std::string output = "mesh_path_tracer.png", model;
    unsigned width = 640, height = 480, samples = 16, depth = 5;
    Arguments arguments("Renders a model with a path tracer of the classic API.");
    arguments.addPositional("model.obj", model, "model to render; none: a generated one");
    arguments.add("-o,--output", output, "picture to write");
    arguments.add("--width", width, 1, 8192, "pixels across");
    arguments.add("--height", height, 1, 8192, "pixels down");
    arguments.add("--samples", samples, 1, 65536, "paths for each pixel");
    arguments.add("--depth", depth, 1, 64, "segments of a path");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    HostScene scene = model.empty() ? makeKnot(20000) : loadObj(model);
    Renderer renderer;
    renderer.setScene(scene);
    renderer.setCamera(
        orbitCamera(boundsOf(scene), 30.0f, 25.0f, 1.0f, float(width) / float(height)));
    const std::vector<float> pixels = renderer.render(width, height, samples, depth);
    writePng(output, width, height, toSrgb(pixels, true));
    std::printf("wrote %s\n", output.c_str());
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("mesh_path_tracer", [&] { return run(argc, argv); });
}
