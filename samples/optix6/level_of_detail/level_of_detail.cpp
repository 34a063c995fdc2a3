// SPDX-License-Identifier: Apache-2.0
// Levels of detail by selectors, with the C API: a field of balls whose mesh gets coarser with the
// distance. All balls share one selector, each below its own transform. Read next: photon_mapping.
#include "check6.h"
#include "picture6.h"

#include <optixu/optixu.h>

#include <cmath>
#include <cstring>
#include <string_view>

std::string_view level_of_detail_ptx(); // the PTX of level_of_detail.cu, built into this program

namespace {

using optix::float3;
using optix::make_float3;
using optix::make_uint3;
using optix::uint3;

enum RayType { kRadianceRay, kShadowRay, kRayTypes };

struct Mesh {
    std::vector<float3> vertices;
    std::vector<uint3> triangles;
};

// A ball of radius 0.5 with ripples.
Mesh makeBall(unsigned rings) {
    Mesh mesh;
    const unsigned sides = 2 * rings;
    for (unsigned i = 0; i <= rings; ++i)
        for (unsigned k = 0; k < sides; ++k) {
            const float a = M_PIf * float(i) / float(rings),
                        b = 2 * M_PIf * float(k) / float(sides);
            const float r = 0.5f + 0.02f * std::sin(9 * a) * std::cos(9 * b);
            mesh.vertices.push_back(make_float3(r * std::sin(a) * std::cos(b), r * std::cos(a),
                                                r * std::sin(a) * std::sin(b)));
        }
    for (unsigned i = 0; i < rings; ++i)
        for (unsigned k = 0; k < sides; ++k) {
            const unsigned next = (k + 1) % sides, row = i * sides, below = row + sides;
            mesh.triangles.push_back(make_uint3(row + k, row + next, below + k));
            mesh.triangles.push_back(make_uint3(row + next, below + next, below + k));
        }
    return mesh;
}

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
        check(rtGroupSetAcceleration(top_, acceleration()));
        check(rtVariableSetObject(variable("top_object"), top_));
        check(rtVariableSet1f(variable("scene_epsilon"), 1e-3f));
        check(rtMaterialCreate(context_, &material_));
        check(rtMaterialSetClosestHitProgram(material_, kRadianceRay, program("hit")));
        check(rtMaterialSetAnyHitProgram(material_, kShadowRay, program("block_light")));
    }
    ~Renderer() { rtContextDestroy(context_); }
    Renderer(const Renderer&) = delete;

    void set(const char* name, float3 value) { check(rtVariableSet3fv(variable(name), &value.x)); }
    void set(const char* name, float value) { check(rtVariableSet1f(variable(name), value)); }

    RTgeometrygroup group(const Mesh& mesh, float3 color) {
        RTbuffer vertices = filled(RT_FORMAT_FLOAT3, mesh.vertices);
        RTbuffer triangles = filled(RT_FORMAT_UNSIGNED_INT3, mesh.triangles);
        RTgeometrytriangles geometry = nullptr;
        check(rtGeometryTrianglesCreate(context_, &geometry));
        check(rtGeometryTrianglesSetPrimitiveCount(geometry, unsigned(mesh.triangles.size())));
        check(rtGeometryTrianglesSetVertices(geometry, unsigned(mesh.vertices.size()), vertices, 0,
                                             sizeof(float3), RT_FORMAT_FLOAT3));
        check(rtGeometryTrianglesSetTriangleIndices(geometry, triangles, 0, sizeof(uint3),
                                                    RT_FORMAT_UNSIGNED_INT3));
        check(rtGeometryTrianglesSetAttributeProgram(geometry, program("triangle_attributes")));
        bind(geometry, "vertices", vertices);
        bind(geometry, "triangles", triangles);

        RTgeometryinstance instance = nullptr;
        RTvariable own = nullptr;
        check(rtGeometryInstanceCreate(context_, &instance));
        check(rtGeometryInstanceSetGeometryTriangles(instance, geometry));
        check(rtGeometryInstanceSetMaterialCount(instance, 1));
        check(rtGeometryInstanceSetMaterial(instance, 0, material_));
        check(rtGeometryInstanceDeclareVariable(instance, "color", &own));
        check(rtVariableSet3fv(own, &color.x));
        RTgeometrygroup made = nullptr;
        check(rtGeometryGroupCreate(context_, &made));
        check(rtGeometryGroupSetAcceleration(made, acceleration()));
        check(rtuGeometryGroupAddChild(made, instance, nullptr));
        return made;
    }
    RTselector selector(const std::vector<RTgeometrygroup>& levels) {
        RTselector made = nullptr;
        RTvariable count = nullptr;
        check(rtSelectorCreate(context_, &made));
        check(rtSelectorSetVisitProgram(made, program("visit_level")));
        check(rtSelectorDeclareVariable(made, "levels", &count));
        check(rtVariableSet1i(count, int(levels.size())));
        for (RTgeometrygroup level : levels)
            check(rtuSelectorAddChild(made, level, nullptr));
        return made;
    }
    void add(RTobject child, float3 place, float size) {
        const float matrix[16] = {size, 0, 0,    place.x, 0, size, 0, place.y,
                                  0,    0, size, place.z, 0, 0,    0, 1};
        RTtransform transform = nullptr;
        check(rtTransformCreate(context_, &transform));
        check(rtTransformSetMatrix(transform, 0, matrix, nullptr));
        check(rtuTransformSetChild(transform, child));
        check(rtuGroupAddChild(top_, transform, nullptr));
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
        static const std::string ptx(level_of_detail_ptx());
        RTprogram made = nullptr;
        check(rtProgramCreateFromPTXString(context_, ptx.c_str(), name, &made));
        return made;
    }
    RTacceleration acceleration() {
        RTacceleration made = nullptr;
        check(rtAccelerationCreate(context_, &made));
        check(rtAccelerationSetBuilder(made, "Trbvh"));
        return made;
    }
    RTvariable variable(const char* name) {
        RTvariable found = nullptr;
        check(rtContextQueryVariable(context_, name, &found));
        if (!found)
            check(rtContextDeclareVariable(context_, name, &found));
        return found;
    }
    template <class T>
    RTbuffer filled(RTformat format, const std::vector<T>& items) {
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
    void bind(RTgeometrytriangles geometry, const char* name, RTbuffer value) {
        RTvariable made = nullptr;
        check(rtGeometryTrianglesDeclareVariable(geometry, name, &made));
        check(rtVariableSetObject(made, value));
    }

    RTcontext context_ = nullptr;
    RTgroup top_ = nullptr;
    RTmaterial material_ = nullptr;
};

void render(const ClassicPicture& picture) {
    Renderer renderer;
    Mesh ground;
    ground.vertices = {make_float3(-90.0f, 0.0f, 10.0f), make_float3(90.0f, 0.0f, 10.0f),
                       make_float3(90.0f, 0.0f, -120.0f), make_float3(-90.0f, 0.0f, -120.0f)};
    ground.triangles = {make_uint3(0, 1, 2), make_uint3(0, 2, 3)};
    renderer.add(renderer.group(ground, make_float3(0.55f, 0.55f, 0.5f)), make_float3(0.0f), 1.0f);

    const RTselector ball =
        renderer.selector({renderer.group(makeBall(48), make_float3(0.85f, 0.3f, 0.2f)),
                           renderer.group(makeBall(20), make_float3(0.9f, 0.65f, 0.2f)),
                           renderer.group(makeBall(9), make_float3(0.35f, 0.65f, 0.3f)),
                           renderer.group(makeBall(4), make_float3(0.25f, 0.45f, 0.8f))});
    for (int row = 0; row < 22; ++row)
        for (int column = -row - 3; column <= row + 3; ++column)
            renderer.add(
                ball,
                make_float3(1.5f * float(column) + 0.4f * float(row % 2), 0.5f, -1.5f * float(row)),
                1.0f);
    renderer.set("finest_distance", 4.0f);
    renderer.set("sun", optix::normalize(make_float3(-0.5f, 0.8f, 0.4f)));
    const ClassicCamera camera = makeCamera(
        make_float3(0.0f, 2.4f, 4.0f), make_float3(0.0f, 0.4f, -3.0f), 45.0f, picture.aspect());
    renderer.set("eye", camera.eye);
    renderer.set("camera_right", camera.right);
    renderer.set("camera_up", camera.up);
    renderer.set("camera_forward", camera.forward);
    renderer.render(picture);
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"level_of_detail.png", 720, 400};
    Arguments arguments("Meshes that get coarser with the distance, by selectors.");
    addOptions(arguments, picture);
    return runClassicSample("level_of_detail", arguments, argc, argv, [&] { render(picture); });
}
