// SPDX-License-Identifier: Apache-2.0
// Instances of one cube: a wall by transforms, a row that moves by matrix keys, wheels that rotate
// by SRT keys, and a cube whose vertices move. Read next: procedural.
#include "shapes6.h"

#include <optix_world.h>

#include <cmath>
#include <string_view>

std::string_view motion_ptx(); // the PTX of motion.cu, built into this program

namespace {

using namespace optix;

enum RayType { kRadianceRay, kShadowRay, kRayTypes };

class Scene {
public:
    explicit Scene(Context context) : context_(context), top_(context->createGroup()) {
        top_->setAcceleration(context_->createAcceleration("Trbvh"));
        material_ = context_->createMaterial();
        material_->setClosestHitProgram(kRadianceRay, program("hit"));
        material_->setAnyHitProgram(kShadowRay, program("block_light"));
        cube_ = cube(false);
    }
    Program program(const char* name) {
        return context_->createProgramFromPTXString(std::string(motion_ptx()), name);
    }
    Group top() { return top_; }

    // Cubes of one colour share an instance of the geometry, below any number of transforms.
    GeometryGroup cubes(float3 color) { return groupOf(cube_, color); }

    Transform place(const Matrix4x4& matrix, GeometryGroup child) {
        Transform made = context_->createTransform();
        made->setMatrix(false, matrix.getData(), nullptr);
        made->setChild(child);
        return made;
    }
    void add(Transform transform) { top_->addChild(transform); }
    void addGround() {
        Geometry square =
            makeParallelogram(context_, make_float3(-20.0f, 0.0f, 20.0f),
                              make_float3(40.0f, 0.0f, 0.0f), make_float3(0.0f, 0.0f, -40.0f));
        GeometryInstance instance =
            context_->createGeometryInstance(square, &material_, &material_ + 1);
        instance["color"]->setFloat(0.6f, 0.6f, 0.58f);
        GeometryGroup group = context_->createGeometryGroup(&instance, &instance + 1);
        group->setAcceleration(context_->createAcceleration("NoAccel"));
        top_->addChild(group);
    }
    // A cube that becomes slanted during the exposure.
    void addBending(const Matrix4x4& matrix, float3 color) {
        add(place(matrix, groupOf(cube(true), color)));
    }

private:
    GeometryGroup groupOf(GeometryTriangles geometry, float3 color) {
        GeometryInstance instance = context_->createGeometryInstance(geometry, material_);
        instance["color"]->setFloat(color);
        GeometryGroup group = context_->createGeometryGroup(&instance, &instance + 1);
        group->setAcceleration(context_->createAcceleration("Trbvh"));
        return group;
    }
    GeometryTriangles cube(bool moves) {
        std::vector<float3> begin, end;
        for (int i = 0; i < 8; ++i) {
            begin.push_back(make_float3(float(i & 1), float(i >> 1 & 1), float(i >> 2)) - 0.5f);
            end.push_back(begin.back() + (moves ? make_float3(0.7f * float(i >> 1 & 1), 0.0f, 0.0f)
                                                : make_float3(0.0f)));
        }
        const std::vector<uint3> sides = {
            make_uint3(0, 2, 1), make_uint3(1, 2, 3), make_uint3(4, 5, 6), make_uint3(5, 7, 6),
            make_uint3(0, 1, 4), make_uint3(1, 5, 4), make_uint3(2, 6, 3), make_uint3(3, 6, 7),
            make_uint3(0, 4, 2), make_uint3(2, 4, 6), make_uint3(1, 3, 5), make_uint3(3, 7, 5)};
        Buffer buffers[2] = {makeBuffer(context_, RT_FORMAT_FLOAT3, begin),
                             makeBuffer(context_, RT_FORMAT_FLOAT3, end)};
        Buffer triangles = makeBuffer(context_, RT_FORMAT_UNSIGNED_INT3, sides);
        GeometryTriangles made = context_->createGeometryTriangles();
        made->setPrimitiveCount(unsigned(sides.size()));
        made->setTriangleIndices(triangles, RT_FORMAT_UNSIGNED_INT3);
        if (moves) {
            made->setMotionSteps(2);
            made->setMotionRange(0.0f, 1.0f);
            made->setMotionVerticesMultiBuffer(8, buffers, buffers + 2, 0, sizeof(float3),
                                               RT_FORMAT_FLOAT3);
        } else {
            made->setVertices(8, buffers[0], RT_FORMAT_FLOAT3);
        }
        made->setAttributeProgram(program("triangle_attributes"));
        made["vertices"]->set(buffers[0]);
        made["end_vertices"]->set(buffers[1]);
        made["triangles"]->set(triangles);
        return made;
    }

    Context context_;
    Group top_;
    Material material_;
    GeometryTriangles cube_;
};

void addWall(Scene& scene) {
    GeometryGroup colors[3] = {scene.cubes(make_float3(0.75f, 0.35f, 0.2f)),
                               scene.cubes(make_float3(0.8f, 0.5f, 0.25f)),
                               scene.cubes(make_float3(0.65f, 0.28f, 0.2f))};
    for (int row = 0; row < 5; ++row)
        for (int column = -5; column <= 5; ++column) {
            const float x = float(column) * 1.05f + (row % 2 ? 0.5f : 0.0f);
            const Matrix4x4 matrix =
                Matrix4x4::translate(make_float3(x, 0.3f + 0.52f * float(row), -3.0f)) *
                Matrix4x4::rotate(0.04f * float((row * 7 + column * 5) % 3),
                                  make_float3(0.0f, 1.0f, 0.0f)) *
                Matrix4x4::scale(make_float3(1.0f, 0.5f, 0.5f));
            scene.add(scene.place(matrix, colors[(row * 2 + column + 12) % 3]));
        }
}

// Cubes that move to the right, each farther than the one before, by matrices at two times.
void addRunners(Scene& scene) {
    GeometryGroup cube = scene.cubes(make_float3(0.2f, 0.5f, 0.8f));
    for (int i = 0; i < 4; ++i) {
        const float z = -1.4f + 0.9f * float(i), way = 0.5f * float(i);
        float keys[24] = {};
        for (int key = 0; key < 2; ++key)
            for (int k = 0; k < 3; ++k)
                keys[12 * key + 5 * k] = 0.5f;
        keys[3] = -3.0f, keys[15] = -3.0f + way;
        keys[7] = keys[19] = 0.25f;
        keys[11] = keys[23] = z;
        Transform transform = scene.place(Matrix4x4::identity(), cube);
        transform->setMotionRange(0.0f, 1.0f);
        transform->setMotionBorderMode(RT_MOTIONBORDERMODE_CLAMP, RT_MOTIONBORDERMODE_CLAMP);
        transform->setMotionKeys(2, RT_MOTIONKEYTYPE_MATRIX_FLOAT12, keys);
        scene.add(transform);
    }
}

// Bars that rotate around their centre, by scale, rotation and translation. A quaternion rotates by
// twice the angle of its components.
void addWheels(Scene& scene) {
    GeometryGroup bar = scene.cubes(make_float3(0.3f, 0.65f, 0.35f));
    for (int i = 0; i < 3; ++i) {
        const float angle = 0.1f + 0.25f * float(i);
        float keys[32] = {};
        for (int key = 0; key < 2; ++key) {
            float* srt = keys + 16 * key;
            srt[0] = 1.6f, srt[4] = 0.18f, srt[7] = 0.18f; // the diagonal of the scale
            const float turned = 0.3f + (key ? angle : 0.0f);
            srt[11] = std::sin(turned), srt[12] = std::cos(turned); // around z
            srt[13] = 0.4f + 1.1f * float(i), srt[14] = 1.0f, srt[15] = 0.6f - 0.8f * float(i);
        }
        Transform transform = scene.place(Matrix4x4::identity(), bar);
        transform->setMotionRange(0.0f, 1.0f);
        transform->setMotionKeys(2, RT_MOTIONKEYTYPE_SRT_FLOAT16, keys);
        scene.add(transform);
    }
}

void render(const ClassicPicture& picture, unsigned samples) {
    Context context = Context::create();
    context->setRayTypeCount(kRayTypes);
    context->setEntryPointCount(1);
    Scene scene(context);
    context->setRayGenerationProgram(0, scene.program("camera"));
    context->setExceptionProgram(0, scene.program("show_exception"));
    context->setMissProgram(kRadianceRay, scene.program("miss"));
    context["scene_epsilon"]->setFloat(1e-3f);
    context["samples"]->setUint(samples);
    context["sun"]->setFloat(normalize(make_float3(0.6f, 1.0f, 0.8f)));
    Buffer buffer =
        context->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, picture.width, picture.height);
    context["picture"]->set(buffer);
    scene.addGround();
    addWall(scene);
    addRunners(scene);
    addWheels(scene);
    scene.addBending(Matrix4x4::translate(make_float3(-0.4f, 0.4f, 1.8f)) *
                         Matrix4x4::scale(make_float3(0.8f)),
                     make_float3(0.8f, 0.7f, 0.2f));
    context["top_object"]->set(scene.top());
    setCamera(context, makeCamera(make_float3(0.6f, 2.6f, 6.5f), make_float3(0.0f, 0.9f, 0.0f),
                                  42.0f, picture.aspect()));
    context->validate();
    context->launch(0, picture.width, picture.height);
    writePicture(picture, buffer->get());
    context->destroy();
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"motion.png", 640, 400};
    unsigned samples = 32;
    Arguments arguments("Instances by transforms, still and in motion.");
    addOptions(arguments, picture);
    arguments.add("--samples", samples, 1, 65536, "paths for each pixel");
    return runClassicSample("motion", arguments, argc, argv, [&] { render(picture, samples); });
}
