// SPDX-License-Identifier: Apache-2.0
// The classic API's side of twins.h.
#include "twins.h"

#include <optix.h>

#include <chrono>
#include <cstring>
#include <stdexcept>

namespace twin {
namespace {

const std::string& ptx() {
    static const std::string text = readDeviceCode(BENCH_CLASSIC_PTX);
    return text;
}

class Classic : public Renderer {
public:
    Classic(const Scene& scene, unsigned width, unsigned height, unsigned samples)
        : width_(width), height_(height) {
        check(rtContextCreate(&context_));
        check(rtContextSetEntryPointCount(context_, 1));
        check(rtContextSetRayTypeCount(context_, kRayTypes));
        check(rtContextSetMaxTraceDepth(context_, 2));
        check(rtContextSetRayGenerationProgram(context_, 0, program("trace_paths")));
        check(rtContextSetMissProgram(context_, kPathRay, program("miss_path")));
        check(rtBufferCreate(context_, RT_BUFFER_OUTPUT, &picture_));
        check(rtBufferSetFormat(picture_, RT_FORMAT_FLOAT4));
        check(rtBufferSetSize2D(picture_, width, height));
        check(rtVariableSetObject(variable("picture"), picture_));
        check(rtVariableSet1ui(variable("samples"), samples));
        check(rtVariableSetUserData(variable("camera"), sizeof scene.camera, &scene.camera));
        makeScene(scene);
    }
    ~Classic() override { rtContextDestroy(context_); }

    void launch() override { check(rtContextLaunch2D(context_, 0, width_, height_)); }
    std::vector<float> picture() override {
        void* data = nullptr;
        check(rtBufferMap(picture_, &data));
        const float* first = static_cast<const float*>(data);
        std::vector<float> pixels(first, first + size_t(4) * width_ * height_);
        check(rtBufferUnmap(picture_));
        return pixels;
    }

    void createPrograms(unsigned count) {
        static const char* const kNames[] = {"trace_paths", "miss_path", "hit_path", "block_light",
                                             "mesh_attributes"};
        for (unsigned i = 0; i < count; ++i)
            program(kNames[i % 5]);
    }
    void move(float to) {
        float matrix[16] = {1, 0, 0, to, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        check(rtTransformSetMatrix(transforms_.front(), 0, matrix, nullptr));
        check(rtAccelerationMarkDirty(top_));
    }
    void paint(float red) { check(rtVariableSet3f(albedo_, red, 0.5f, 0.5f)); }
    // Adds materials, each with a closest-hit program from a PTX text of its own, which no cache
    // has.
    void addMaterials(unsigned count) {
        const auto now = std::chrono::system_clock::now().time_since_epoch().count();
        check(rtGeometryGroupSetChildCount(group_, 1 + count));
        for (unsigned i = 0; i < count; ++i) {
            const std::string text =
                ptx() + "// " + std::to_string(now) + " " + std::to_string(i) + "\n";
            RTprogram hit = nullptr;
            check(rtProgramCreateFromPTXString(context_, text.c_str(), "hit_path", &hit));
            check(rtGeometryGroupSetChild(group_, 1 + i, instanceOf(materialOf(hit))));
        }
        check(rtAccelerationMarkDirty(bottom_));
    }
    void launchSmall() { check(rtContextLaunch2D(context_, 0, 8, 8)); }

private:
    void check(RTresult code) {
        if (code == RT_SUCCESS)
            return;
        const char* text = nullptr;
        rtContextGetErrorString(context_, code, &text);
        throw std::runtime_error(text ? text : "an error of the classic API");
    }
    RTprogram program(const char* name) {
        RTprogram made = nullptr;
        check(rtProgramCreateFromPTXString(context_, ptx().c_str(), name, &made));
        return made;
    }
    RTvariable variable(const char* name) {
        RTvariable made = nullptr;
        check(rtContextDeclareVariable(context_, name, &made));
        return made;
    }
    template <class T>
    RTbuffer buffer(const char* name, RTformat format, size_t count, const T& items) {
        RTbuffer made = nullptr;
        void* data = nullptr;
        check(rtBufferCreate(context_, RT_BUFFER_INPUT, &made));
        check(rtBufferSetFormat(made, format));
        check(rtBufferSetSize1D(made, count));
        if (count) {
            check(rtBufferMap(made, &data));
            std::memcpy(data, items.data(), items.size() * sizeof(items[0]));
            check(rtBufferUnmap(made));
        }
        check(rtVariableSetObject(variable(name), made));
        return made;
    }

    void makeScene(const Scene& scene) {
        RTbuffer vertices =
            buffer("vertices", RT_FORMAT_FLOAT3, scene.vertices.size() / 3, scene.vertices);
        RTbuffer indices =
            buffer("indices", RT_FORMAT_UNSIGNED_INT3, scene.indices.size() / 3, scene.indices);
        buffer("spheres", RT_FORMAT_FLOAT4, scene.spheres.size() / 4, scene.spheres);
        if (scene.spheres.empty())
            triangles_ = mesh(scene, vertices, indices);
        else
            spheres_ = balls(scene);
        check(rtGeometryGroupCreate(context_, &group_));
        check(rtGeometryGroupSetChildCount(group_, 1));
        check(rtGeometryGroupSetChild(group_, 0, instanceOf(materialOf(program("hit_path")))));
        check(rtAccelerationCreate(context_, &bottom_));
        check(rtAccelerationSetBuilder(bottom_, "Trbvh"));
        check(rtGeometryGroupSetAcceleration(group_, bottom_));
        RTgroup root = nullptr;
        check(rtGroupCreate(context_, &root));
        check(rtGroupSetChildCount(root, unsigned(scene.instances.size())));
        for (unsigned i = 0; i < scene.instances.size(); ++i) {
            RTtransform transform = nullptr;
            float matrix[16] = {};
            std::memcpy(matrix, scene.instances[i].data(), 48);
            matrix[15] = 1;
            check(rtTransformCreate(context_, &transform));
            check(rtTransformSetMatrix(transform, 0, matrix, nullptr));
            check(rtTransformSetChild(transform, group_));
            check(rtGroupSetChild(root, i, transform));
            transforms_.push_back(transform);
        }
        check(rtAccelerationCreate(context_, &top_));
        check(rtAccelerationSetBuilder(top_, "Trbvh"));
        check(rtGroupSetAcceleration(root, top_));
        check(rtVariableSetObject(variable("top_object"), root));
    }
    RTmaterial materialOf(RTprogram hit) {
        RTmaterial made = nullptr;
        check(rtMaterialCreate(context_, &made));
        check(rtMaterialSetClosestHitProgram(made, kPathRay, hit));
        check(rtMaterialSetAnyHitProgram(made, kShadowRay, program("block_light")));
        check(rtMaterialDeclareVariable(made, "albedo", &albedo_));
        check(rtVariableSet3f(albedo_, 0.75f, 0.62f, 0.5f));
        return made;
    }
    RTgeometryinstance instanceOf(RTmaterial material) {
        RTgeometryinstance made = nullptr;
        check(rtGeometryInstanceCreate(context_, &made));
        if (triangles_)
            check(rtGeometryInstanceSetGeometryTriangles(made, triangles_));
        else
            check(rtGeometryInstanceSetGeometry(made, spheres_));
        check(rtGeometryInstanceSetMaterialCount(made, 1));
        check(rtGeometryInstanceSetMaterial(made, 0, material));
        return made;
    }
    RTgeometrytriangles mesh(const Scene& scene, RTbuffer vertices, RTbuffer indices) {
        RTgeometrytriangles made = nullptr;
        check(rtGeometryTrianglesCreate(context_, &made));
        check(rtGeometryTrianglesSetPrimitiveCount(made, unsigned(scene.indices.size() / 3)));
        check(rtGeometryTrianglesSetTriangleIndices(made, indices, 0, 12, RT_FORMAT_UNSIGNED_INT3));
        check(rtGeometryTrianglesSetVertices(made, unsigned(scene.vertices.size() / 3), vertices, 0,
                                             12, RT_FORMAT_FLOAT3));
        check(rtGeometryTrianglesSetAttributeProgram(made, program("mesh_attributes")));
        return made;
    }
    RTgeometry balls(const Scene& scene) {
        RTgeometry made = nullptr;
        check(rtGeometryCreate(context_, &made));
        check(rtGeometrySetPrimitiveCount(made, unsigned(scene.spheres.size() / 4)));
        check(rtGeometrySetBoundingBoxProgram(made, program("bound_sphere")));
        check(rtGeometrySetIntersectionProgram(made, program("intersect_sphere")));
        return made;
    }

    const unsigned width_, height_;
    RTcontext context_ = nullptr;
    RTbuffer picture_ = nullptr;
    RTgeometrytriangles triangles_ = nullptr;
    RTgeometry spheres_ = nullptr;
    RTgeometrygroup group_ = nullptr;
    RTacceleration bottom_ = nullptr, top_ = nullptr;
    RTvariable albedo_ = nullptr; // of the last material
    std::vector<RTtransform> transforms_;
};

template <class Body>
double milliseconds(const Body& body) {
    const auto begin = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
        .count();
}

} // namespace

std::unique_ptr<Renderer> makeClassic(const Scene& scene, unsigned width, unsigned height,
                                      unsigned samples) {
    return std::make_unique<Classic>(scene, width, height, samples);
}

ClassicTimes timeClassic(const Scene& scene) {
    Classic renderer(scene, 64, 64, 1);
    renderer.launch();
    ClassicTimes best{1e9, 1e9, 1e9, 1e9, 0, 0};
    for (int i = 0; i < 7; ++i) {
        const auto keep = [](double& to, double value) { to = std::min(to, value); };
        keep(best.createPrograms, milliseconds([&] { renderer.createPrograms(1460); }));
        renderer.launchSmall();
        keep(best.smallLaunch, milliseconds([&] { renderer.launchSmall(); }));
        keep(best.setVariable, milliseconds([&] {
                 renderer.paint(0.1f * float(i));
                 renderer.launchSmall();
             }));
        keep(best.moveInstance, milliseconds([&] {
                 renderer.move(0.01f * float(i));
                 renderer.launchSmall();
             }));
    }
    Scene triangle{"a triangle", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}, {}, {}, scene.camera};
    triangle.instances = {scene.instances.front()};
    Classic many(triangle, 64, 64, 1);
    best.createMany = milliseconds([&] { many.addMaterials(100); });
    best.firstLaunch = milliseconds([&] { many.launchSmall(); });
    return best;
}

} // namespace twin
