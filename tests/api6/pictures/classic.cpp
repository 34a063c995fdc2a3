// SPDX-License-Identifier: Apache-2.0
// Renders a scene with the classic API: an instance is a transform above its own geometry group;
// the groups share their acceleration.
#include "scene.h"

#include <optixu/optixpp_namespace.h>

#include <cstring>

namespace sunstone::pictures {

namespace {

using namespace optix;

class Drawing {
public:
    Drawing(const Scene& scene, std::string ptxFile)
        : scene_(scene), ptxFile_(std::move(ptxFile)), context_(Context::create()) {}
    ~Drawing() { context_->destroy(); }

    Picture draw() {
        context_->setRayTypeCount(2);
        context_->setEntryPointCount(1);
        context_->setRayGenerationProgram(0, program("draw"));
        context_->setMissProgram(0, program("miss"));
        context_["vertices"]->set(filled(RT_FORMAT_FLOAT3, scene_.vertices));
        context_["triangles"]->set(filled(RT_FORMAT_UNSIGNED_INT3, scene_.triangles));
        context_["spheres"]->set(filled(RT_FORMAT_FLOAT4, scene_.spheres));
        Buffer picture =
            context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, kWidth, kHeight);
        context_["picture"]->set(picture);
        context_["top_object"]->set(instances());
        context_->validate();
        context_->launch(0, kWidth, kHeight);
        Picture result(size_t(kWidth) * kHeight);
        std::memcpy(result.data(), picture->map(0, RT_BUFFER_MAP_READ),
                    result.size() * sizeof result[0]);
        picture->unmap();
        return result;
    }

private:
    Program program(const char* name) { return context_->createProgramFromPTXFile(ptxFile_, name); }
    template <class T>
    Buffer filled(RTformat format, const std::vector<T>& items) {
        Buffer made = context_->createBuffer(RT_BUFFER_INPUT, format, items.size());
        if (!items.empty()) {
            std::memcpy(made->map(), items.data(), items.size() * sizeof(T));
            made->unmap();
        }
        return made;
    }
    Geometry spheres() {
        Geometry made = context_->createGeometry();
        made->setPrimitiveCount(unsigned(scene_.spheres.size()));
        made->setIntersectionProgram(program("intersect_spheres"));
        made->setBoundingBoxProgram(program("bound_spheres"));
        return made;
    }
    GeometryTriangles mesh() {
        GeometryTriangles made = context_->createGeometryTriangles();
        made->setPrimitiveCount(unsigned(scene_.triangles.size()));
        made->setVertices(unsigned(scene_.vertices.size()), context_["vertices"]->getBuffer(),
                          RT_FORMAT_FLOAT3);
        made->setTriangleIndices(context_["triangles"]->getBuffer(), RT_FORMAT_UNSIGNED_INT3);
        made->setFlagsPerMaterial(0, RT_GEOMETRY_FLAG_NO_SPLITTING);
        return made;
    }
    Material material() {
        Material made = context_->createMaterial();
        made->setClosestHitProgram(0,
                                   program(scene_.spheres.empty() ? "hit_triangle" : "hit_sphere"));
        if (scene_.isTransparent)
            made->setAnyHitProgram(0, program("cut"));
        made->setAnyHitProgram(1, program(scene_.isTransparent ? "dim" : "block"));
        return made;
    }
    Group instances() {
        Group top = context_->createGroup();
        top->setAcceleration(context_->createAcceleration("Trbvh"));
        Acceleration shared = context_->createAcceleration("Trbvh");
        Material shading = material();
        Geometry custom;
        GeometryTriangles triangles;
        if (scene_.spheres.empty())
            triangles = mesh();
        else
            custom = spheres();
        for (const Instance& each : scene_.instances) {
            GeometryInstance instance = context_->createGeometryInstance();
            if (custom)
                instance->setGeometry(custom);
            else
                instance->setGeometryTriangles(triangles);
            instance->setMaterialCount(1);
            instance->setMaterial(0, shading);
            instance["albedo"]->set3fv(each.albedo.data());
            GeometryGroup group = context_->createGeometryGroup();
            group->setAcceleration(shared);
            group->addChild(instance);
            float matrix[16] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
            std::memcpy(matrix, each.matrix.data(), sizeof each.matrix);
            Transform transform = context_->createTransform();
            transform->setMatrix(false, matrix, nullptr);
            transform->setChild(group);
            top->addChild(transform);
        }
        return top;
    }

    const Scene& scene_;
    std::string ptxFile_;
    Context context_;
};

} // namespace

Picture drawClassic(const Scene& scene, const std::string& ptxFile) {
    return Drawing(scene, ptxFile).draw();
}

} // namespace sunstone::pictures
