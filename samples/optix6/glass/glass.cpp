// SPDX-License-Identifier: Apache-2.0
// A path tracer with glass, with the C API: a box with coloured walls and a light, glass spheres
// that absorb light. Read next: callables.
#include "check6.h"
#include "picture6.h"

#include <optixu/optixu.h>

#include <string_view>

std::string_view glass_ptx(); // the PTX of glass.cu, built into this program

namespace {

using optix::float3;
using optix::make_float3;

enum RayType { kPathRay, kShadowRay, kRayTypes };

class Renderer {
public:
    Renderer() {
        RT_CHECK(nullptr, rtContextCreate(&context_));
        check(rtContextSetEntryPointCount(context_, 1));
        check(rtContextSetRayTypeCount(context_, kRayTypes));
        check(rtContextSetRayGenerationProgram(context_, 0, program("trace_paths")));
        check(rtContextSetExceptionProgram(context_, 0, program("show_exception")));
        check(rtContextSetMissProgram(context_, kPathRay, program("miss")));
        set("scene_epsilon", 1e-3f);
        check(rtGeometryGroupCreate(context_, &group_));
        RTacceleration acceleration = nullptr;
        check(rtAccelerationCreate(context_, &acceleration));
        check(rtAccelerationSetBuilder(acceleration, "Trbvh"));
        check(rtGeometryGroupSetAcceleration(group_, acceleration));
        check(rtVariableSetObject(variable("top_object"), group_));
    }
    ~Renderer() { rtContextDestroy(context_); }
    Renderer(const Renderer&) = delete;

    RTmaterial material(const char* hit, const char* shadow) {
        RTmaterial made = nullptr;
        check(rtMaterialCreate(context_, &made));
        check(rtMaterialSetClosestHitProgram(made, kPathRay, program(hit)));
        if (shadow)
            check(rtMaterialSetAnyHitProgram(made, kShadowRay, program(shadow)));
        return made;
    }
    void set(const char* name, float value) { check(rtVariableSet1f(variable(name), value)); }
    void set(const char* name, float3 value) { check(rtVariableSet3fv(variable(name), &value.x)); }
    void set(const char* name, unsigned value) { check(rtVariableSet1ui(variable(name), value)); }

    void addParallelogram(float3 anchor, float3 edge1, float3 edge2, RTmaterial material,
                          float3 color) {
        RTgeometry geometry = shape("intersect_parallelogram", "bound_parallelogram");
        setOf(geometry, "anchor", anchor);
        setOf(geometry, "edge1", edge1);
        setOf(geometry, "edge2", edge2);
        addInstance(geometry, material, "albedo", color);
    }
    void addSphere(float3 centre, float radius, RTmaterial material, float3 extinction) {
        RTgeometry geometry = shape("intersect_sphere", "bound_sphere");
        RTvariable place = nullptr;
        check(rtGeometryDeclareVariable(geometry, "sphere", &place));
        check(rtVariableSet4f(place, centre.x, centre.y, centre.z, radius));
        addInstance(geometry, material, "extinction", extinction);
    }

    void render(const ClassicPicture& picture) {
        RTbuffer buffer = nullptr;
        check(rtBufferCreate(context_, RT_BUFFER_OUTPUT, &buffer));
        check(rtBufferSetFormat(buffer, RT_FORMAT_FLOAT4));
        check(rtBufferSetSize2D(buffer, picture.width, picture.height));
        check(rtVariableSetObject(variable("picture"), buffer));
        check(rtContextValidate(context_));
        check(rtContextLaunch2D(context_, 0, picture.width, picture.height));
        writePicture(picture, buffer, true);
    }

private:
    void check(RTresult result) { RT_CHECK(context_, result); }
    RTprogram program(const char* name) {
        static const std::string ptx(glass_ptx());
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
    void setOf(RTgeometry geometry, const char* name, float3 value) {
        RTvariable made = nullptr;
        check(rtGeometryDeclareVariable(geometry, name, &made));
        check(rtVariableSet3f(made, value.x, value.y, value.z));
    }
    RTgeometry shape(const char* intersection, const char* bounds) {
        static const std::string ptx(shapes_ptx());
        RTgeometry made = nullptr;
        RTprogram programs[2] = {};
        check(rtGeometryCreate(context_, &made));
        check(rtGeometrySetPrimitiveCount(made, 1));
        check(rtProgramCreateFromPTXString(context_, ptx.c_str(), intersection, &programs[0]));
        check(rtProgramCreateFromPTXString(context_, ptx.c_str(), bounds, &programs[1]));
        check(rtGeometrySetIntersectionProgram(made, programs[0]));
        check(rtGeometrySetBoundingBoxProgram(made, programs[1]));
        return made;
    }
    void addInstance(RTgeometry geometry, RTmaterial material, const char* name, float3 value) {
        RTgeometryinstance made = nullptr;
        RTvariable own = nullptr;
        check(rtGeometryInstanceCreate(context_, &made));
        check(rtGeometryInstanceSetGeometry(made, geometry));
        check(rtGeometryInstanceSetMaterialCount(made, 1));
        check(rtGeometryInstanceSetMaterial(made, 0, material));
        check(rtGeometryInstanceDeclareVariable(made, name, &own));
        check(rtVariableSet3f(own, value.x, value.y, value.z));
        unsigned index = 0;
        check(rtuGeometryGroupAddChild(group_, made, &index));
    }

    RTcontext context_ = nullptr;
    RTgeometrygroup group_ = nullptr;
};

// A box from -1 to 1, open to the eye, with a light below its ceiling.
void addBox(Renderer& renderer) {
    const float3 white = make_float3(0.73f), red = make_float3(0.65f, 0.12f, 0.08f),
                 blue = make_float3(0.1f, 0.25f, 0.6f);
    const float3 x = make_float3(2.0f, 0.0f, 0.0f), y = make_float3(0.0f, 2.0f, 0.0f),
                 z = make_float3(0.0f, 0.0f, 2.0f), low = make_float3(-1.0f),
                 high = make_float3(1.0f);
    RTmaterial wall = renderer.material("hit_diffuse", "block_light");
    renderer.addParallelogram(low, z, x, wall, white);
    renderer.addParallelogram(high, -x, -z, wall, white);
    renderer.addParallelogram(low, x, y, wall, white);
    renderer.addParallelogram(low, y, z, wall, red);
    renderer.addParallelogram(high, -y, -z, wall, blue);

    const float3 anchor = make_float3(-0.35f, 0.99f, -0.35f), edge1 = make_float3(0.7f, 0.0f, 0.0f),
                 edge2 = make_float3(0.0f, 0.0f, 0.7f);
    renderer.set("light_anchor", anchor);
    renderer.set("light_edge1", edge1);
    renderer.set("light_edge2", edge2);
    renderer.set("emission", make_float3(11.0f, 9.5f, 8.0f));
    renderer.addParallelogram(anchor, edge1, edge2, renderer.material("hit_light", nullptr),
                              make_float3(0.0f));
}

void addGlass(Renderer& renderer) {
    RTmaterial glass = renderer.material("hit_glass", "block_light");
    renderer.set("index_of_refraction", 1.5f);
    renderer.addSphere(make_float3(-0.45f, -0.55f, 0.1f), 0.45f, glass,
                       make_float3(-0.05f, -0.02f, -0.05f));
    renderer.addSphere(make_float3(0.45f, -0.62f, 0.5f), 0.38f, glass,
                       make_float3(-0.2f, -1.4f, -2.6f));
    renderer.addSphere(make_float3(0.35f, 0.25f, -0.45f), 0.32f, glass,
                       make_float3(-2.0f, -0.4f, -0.7f));
}

void render(const ClassicPicture& picture, unsigned samples, unsigned depth) {
    Renderer renderer;
    addBox(renderer);
    addGlass(renderer);
    renderer.set("samples", samples);
    renderer.set("max_depth", depth);
    const ClassicCamera camera =
        makeCamera(make_float3(0.0f, 0.0f, 3.9f), make_float3(0.0f), 40.0f, picture.aspect());
    renderer.set("eye", camera.eye);
    renderer.set("camera_right", camera.right);
    renderer.set("camera_up", camera.up);
    renderer.set("camera_forward", camera.forward);
    renderer.render(picture);
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"glass.png", 512, 512};
    unsigned samples = 64, depth = 12;
    Arguments arguments("A path tracer of the classic API with glass.");
    addOptions(arguments, picture);
    arguments.add("--samples", samples, 1, 65536, "paths for each pixel");
    arguments.add("--depth", depth, 1, 64, "segments of a path");
    return runClassicSample("glass", arguments, argc, argv,
                            [&] { render(picture, samples, depth); });
}
