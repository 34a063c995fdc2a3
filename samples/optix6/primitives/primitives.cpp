// SPDX-License-Identifier: Apache-2.0
// Spheres, parallelograms and triangles with shadows and reflections, with the C++ wrapper: the
// values of a material are variables of geometry instances and materials. Read next: glass.
#include "light.h"
#include "shapes6.h"

#include <optix_world.h>

#include <string_view>

std::string_view primitives_ptx(); // the PTX of primitives.cu, built into this program

namespace {

using namespace optix;

enum RayType { kRadianceRay, kShadowRay, kRayTypes };

class Scene {
public:
    explicit Scene(Context context) : context_(context), group_(context->createGeometryGroup()) {
        group_->setAcceleration(context_->createAcceleration("Trbvh"));
        block_ = program("block_light");
    }

    Program program(const char* name) {
        return context_->createProgramFromPTXString(std::string(primitives_ptx()), name);
    }
    Material material(const char* hit, const char* anyHit = nullptr) {
        Material made = context_->createMaterial();
        made->setClosestHitProgram(kRadianceRay, program(hit));
        made->setAnyHitProgram(kShadowRay, anyHit ? program(anyHit) : block_);
        return made;
    }
    Material paint(const char* hit, float3 color, float3 specular, float3 reflectivity) {
        Material made = material(hit);
        made["ambient"]->setFloat(0.25f, 0.25f, 0.3f);
        made["diffuse"]->setFloat(color);
        made["specular"]->setFloat(specular);
        made["reflectivity"]->setFloat(reflectivity);
        return made;
    }

    void addSphere(float3 centre, float radius, Material material) {
        add(makeSphere(context_, centre, radius), material);
    }
    void addParallelogram(float3 anchor, float3 edge1, float3 edge2, Material material) {
        add(makeParallelogram(context_, anchor, edge1, edge2), material);
    }
    void addPyramid(float3 centre, float size, Material material) {
        const std::vector<float3> corners = {
            centre + make_float3(-size, 0.0f, -size), centre + make_float3(size, 0.0f, -size),
            centre + make_float3(size, 0.0f, size), centre + make_float3(-size, 0.0f, size),
            centre + make_float3(0.0f, 1.6f * size, 0.0f)};
        const std::vector<uint3> sides = {make_uint3(1, 0, 4), make_uint3(2, 1, 4),
                                          make_uint3(3, 2, 4), make_uint3(0, 3, 4)};
        Buffer vertices = makeBuffer(context_, RT_FORMAT_FLOAT3, corners);
        Buffer triangles = makeBuffer(context_, RT_FORMAT_UNSIGNED_INT3, sides);
        GeometryTriangles made = context_->createGeometryTriangles();
        made->setPrimitiveCount(4);
        made->setVertices(5, vertices, RT_FORMAT_FLOAT3);
        made->setTriangleIndices(triangles, RT_FORMAT_UNSIGNED_INT3);
        made->setAttributeProgram(program("triangle_attributes"));
        made["vertices"]->set(vertices);
        made["triangles"]->set(triangles);
        group_->addChild(context_->createGeometryInstance(made, material));
    }
    void setLights(const std::vector<Light>& lights) {
        context_["lights"]->set(makeBuffer(context_, RT_FORMAT_USER, lights));
    }
    GeometryGroup group() { return group_; }

private:
    void add(Geometry geometry, Material material) {
        group_->addChild(context_->createGeometryInstance(geometry, &material, &material + 1));
    }

    Context context_;
    GeometryGroup group_;
    Program block_;
};

void addObjects(Scene& scene) {
    Material floor =
        scene.paint("hit_tiles", make_float3(0.75f), make_float3(0.1f), make_float3(0.08f));
    floor["diffuse2"]->setFloat(0.2f, 0.25f, 0.35f);
    floor["tiles"]->setFloat(12.0f, 12.0f);
    scene.addParallelogram(make_float3(-6.0f, 0.0f, 6.0f), make_float3(12.0f, 0.0f, 0.0f),
                           make_float3(0.0f, 0.0f, -12.0f), floor);
    scene.addSphere(make_float3(-1.3f, 1.0f, -0.5f), 1.0f,
                    scene.paint("hit_plain", make_float3(0.05f), make_float3(0.8f),
                                make_float3(0.55f, 0.6f, 0.65f)));
    scene.addSphere(make_float3(0.7f, 0.5f, 1.2f), 0.5f,
                    scene.paint("hit_plain", make_float3(0.75f, 0.15f, 0.1f), make_float3(0.5f),
                                make_float3(0.1f)));
    scene.addPyramid(make_float3(1.5f, 0.0f, -0.8f), 0.8f,
                     scene.paint("hit_plain", make_float3(0.9f, 0.65f, 0.2f), make_float3(0.2f),
                                 make_float3(0.05f)));
    Material pane = scene.material("hit_pane", "tint_light");
    pane["tint"]->setFloat(0.25f, 0.8f, 0.45f);
    scene.addParallelogram(make_float3(-2.2f, 0.0f, 1.4f), make_float3(1.2f, 0.0f, 0.7f),
                           make_float3(0.0f, 1.1f, 0.0f), pane);
    scene.setLights({{make_float3(-4.0f, 6.0f, 5.0f), make_float3(0.75f, 0.7f, 0.65f)},
                     {make_float3(5.0f, 5.0f, 2.0f), make_float3(0.25f, 0.28f, 0.35f)}});
}

void render(const ClassicPicture& picture) {
    Context context = Context::create();
    context->setRayTypeCount(kRayTypes);
    context->setEntryPointCount(1);
    context->setMaxTraceDepth(6);
    Scene scene(context);
    context->setRayGenerationProgram(0, scene.program("pinhole_camera"));
    context->setExceptionProgram(0, scene.program("show_exception"));
    context->setMissProgram(kRadianceRay, scene.program("miss"));
    context["horizon_color"]->setFloat(0.75f, 0.8f, 0.85f);
    context["zenith_color"]->setFloat(0.2f, 0.4f, 0.75f);
    context["scene_epsilon"]->setFloat(1e-3f);
    context["max_depth"]->setInt(4);
    Buffer buffer =
        context->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, picture.width, picture.height);
    context["picture"]->set(buffer);
    addObjects(scene);
    context["top_object"]->set(scene.group());

    const ClassicCamera camera = makeCamera(make_float3(0.3f, 2.2f, 5.6f),
                                            make_float3(0.0f, 0.7f, 0.0f), 40.0f, picture.aspect());
    setCamera(context, camera);
    context->validate();
    context->launch(0, picture.width, picture.height);
    writePicture(picture, buffer->get());
    context->destroy();
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"primitives.png", 640, 480};
    Arguments arguments("Spheres, parallelograms and triangles with shadows and reflections.");
    addOptions(arguments, picture);
    return runClassicSample("primitives", arguments, argc, argv, [&] { render(picture); });
}
