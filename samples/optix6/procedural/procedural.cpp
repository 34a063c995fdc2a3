// SPDX-License-Identifier: Apache-2.0
// Surfaces that intersection programs compute, with the C API: one pair of programs for three
// kinds, below transforms. Read next: level_of_detail.
#include "check6.h"
#include "picture6.h"
#include "shape_kinds.h"

#include <optixu/optixu.h>
#include <optixu/optixu_matrix_namespace.h>

#include <string_view>

std::string_view procedural_ptx(); // the PTX of procedural.cu, built into this program

namespace {

using optix::float3;
using optix::make_float3;
using optix::Matrix4x4;

enum RayType { kRadianceRay, kShadowRay, kRayTypes };

class Renderer {
public:
    Renderer() {
        RT_CHECK(nullptr, rtContextCreate(&context_));
        check(rtContextSetEntryPointCount(context_, 1));
        check(rtContextSetRayTypeCount(context_, kRayTypes));
        check(rtContextSetRayGenerationProgram(context_, 0, program("camera")));
        check(rtContextSetExceptionProgram(context_, 0, program("show_exception")));
        check(rtContextSetMissProgram(context_, kRadianceRay, program("miss")));
        check(rtGroupCreate(context_, &top_));
        check(rtGroupSetAcceleration(top_, acceleration("Trbvh")));
        check(rtVariableSetObject(variable("top_object"), top_));
        check(rtVariableSet1f(variable("scene_epsilon"), 5e-4f));
        set("sun", optix::normalize(make_float3(-0.5f, 0.9f, 0.6f)));
    }
    ~Renderer() { rtContextDestroy(context_); }
    Renderer(const Renderer&) = delete;

    void set(const char* name, float3 value) { check(rtVariableSet3fv(variable(name), &value.x)); }

    void addShape(ShapeKind kind, float3 half, float3 color, const Matrix4x4& matrix) {
        RTgeometry geometry = nullptr;
        RTvariable own = nullptr;
        check(rtGeometryCreate(context_, &geometry));
        check(rtGeometrySetPrimitiveCount(geometry, 1));
        check(rtGeometrySetIntersectionProgram(geometry, program("intersect_shape")));
        check(rtGeometrySetBoundingBoxProgram(geometry, program("bound_shape")));
        check(rtGeometryDeclareVariable(geometry, "shape", &own));
        check(rtVariableSet1i(own, kind));
        setOf(geometry, "box_low", -half);
        setOf(geometry, "box_high", half);
        RTtransform transform = nullptr;
        const Matrix4x4 inverse = matrix.inverse();
        check(rtTransformCreate(context_, &transform));
        check(rtTransformSetMatrix(transform, 0, matrix.getData(), inverse.getData()));
        check(rtuTransformSetChild(transform, group(geometry, material("hit"), color)));
        check(rtuGroupAddChild(top_, transform, nullptr));
    }
    void addGround() {
        static const std::string ptx(shapes_ptx());
        RTgeometry geometry = nullptr;
        RTprogram intersection = nullptr, bounds = nullptr;
        check(rtGeometryCreate(context_, &geometry));
        check(rtGeometrySetPrimitiveCount(geometry, 1));
        check(rtProgramCreateFromPTXString(context_, ptx.c_str(), "intersect_parallelogram",
                                           &intersection));
        check(rtProgramCreateFromPTXString(context_, ptx.c_str(), "bound_parallelogram", &bounds));
        check(rtGeometrySetIntersectionProgram(geometry, intersection));
        check(rtGeometrySetBoundingBoxProgram(geometry, bounds));
        setOf(geometry, "anchor", make_float3(-30.0f, -1.2f, 30.0f));
        setOf(geometry, "edge1", make_float3(60.0f, 0.0f, 0.0f));
        setOf(geometry, "edge2", make_float3(0.0f, 0.0f, -60.0f));
        check(rtuGroupAddChild(top_, group(geometry, material("hit_ground"), make_float3(0.5f)),
                               nullptr));
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
        static const std::string ptx(procedural_ptx());
        RTprogram made = nullptr;
        check(rtProgramCreateFromPTXString(context_, ptx.c_str(), name, &made));
        return made;
    }
    RTacceleration acceleration(const char* builder) {
        RTacceleration made = nullptr;
        check(rtAccelerationCreate(context_, &made));
        check(rtAccelerationSetBuilder(made, builder));
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
        check(rtVariableSet3fv(made, &value.x));
    }
    RTmaterial material(const char* hit) {
        RTmaterial made = nullptr;
        check(rtMaterialCreate(context_, &made));
        check(rtMaterialSetClosestHitProgram(made, kRadianceRay, program(hit)));
        check(rtMaterialSetAnyHitProgram(made, kShadowRay, program("block_light")));
        return made;
    }
    RTgeometrygroup group(RTgeometry geometry, RTmaterial material, float3 color) {
        RTgeometryinstance instance = nullptr;
        RTgeometrygroup made = nullptr;
        RTvariable own = nullptr;
        check(rtGeometryInstanceCreate(context_, &instance));
        check(rtGeometryInstanceSetGeometry(instance, geometry));
        check(rtGeometryInstanceSetMaterialCount(instance, 1));
        check(rtGeometryInstanceSetMaterial(instance, 0, material));
        check(rtGeometryInstanceDeclareVariable(instance, "color", &own));
        check(rtVariableSet3fv(own, &color.x));
        check(rtGeometryGroupCreate(context_, &made));
        check(rtGeometryGroupSetAcceleration(made, acceleration("NoAccel")));
        check(rtuGeometryGroupAddChild(made, instance, nullptr));
        return made;
    }

    RTcontext context_ = nullptr;
    RTgroup top_ = nullptr;
};

void render(const ClassicPicture& picture) {
    Renderer renderer;
    const float3 up = make_float3(0.0f, 1.0f, 0.0f), side = make_float3(1.0f, 0.0f, 0.0f);
    renderer.addGround();
    renderer.addShape(kBoredCube, make_float3(0.85f), make_float3(0.75f, 0.25f, 0.15f),
                      Matrix4x4::translate(make_float3(-2.5f, -0.35f, 0.0f)) *
                          Matrix4x4::rotate(0.6f, up));
    renderer.addShape(kJulia, make_float3(1.3f), make_float3(0.35f, 0.6f, 0.3f),
                      Matrix4x4::translate(make_float3(0.0f, 0.1f, 0.0f)) *
                          Matrix4x4::rotate(-0.5f, up) * Matrix4x4::scale(make_float3(1.2f)));
    renderer.addShape(kTwistedRing, make_float3(1.2f, 0.4f, 1.2f), make_float3(0.25f, 0.4f, 0.75f),
                      Matrix4x4::translate(make_float3(2.6f, -0.1f, 0.0f)) *
                          Matrix4x4::rotate(1.1f, side));
    const ClassicCamera camera = makeCamera(
        make_float3(0.0f, 1.3f, 6.2f), make_float3(0.0f, -0.1f, 0.0f), 38.0f, picture.aspect());
    renderer.set("eye", camera.eye);
    renderer.set("camera_right", camera.right);
    renderer.set("camera_up", camera.up);
    renderer.set("camera_forward", camera.forward);
    renderer.render(picture);
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"procedural.png", 720, 400};
    Arguments arguments("Surfaces that intersection programs compute.");
    addOptions(arguments, picture);
    return runClassicSample("procedural", arguments, argc, argv, [&] { render(picture); });
}
