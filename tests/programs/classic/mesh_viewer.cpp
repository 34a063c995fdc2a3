// SPDX-License-Identifier: Apache-2.0
// A viewer in the manner of OptiXpp applications: a mesh of index and vertex buffers, once as
// geometry with programs of its own and once as geometry triangles; settings of the acceleration as
// strings; frames that accumulate until the camera moves. Each frame's heights and the accumulated
// pictures are compared with the height field that the mesh is made of.
#include "common.h"

#include <optixu/optixu_math_namespace.h>
#include <optixu/optixu_matrix_namespace.h>

#include <cmath>
#include <cstring>
#include <map>
#include <vector>

using namespace optix;

namespace {

constexpr unsigned kWidth = 96, kHeight = 64;
constexpr int kGrid = 24;

float heightAt(float x, float z) {
    return 0.3f * std::sin(3.0f * x) * std::cos(2.0f * z);
}

struct Mesh {
    std::vector<float3> positions, normals;
    std::vector<int3> triangles;
    std::vector<int> materials;
};

Mesh makeMesh() {
    Mesh mesh;
    for (int j = 0; j <= kGrid; ++j)
        for (int i = 0; i <= kGrid; ++i) {
            const float x = 2.0f * i / kGrid - 1, z = 2.0f * j / kGrid - 1;
            mesh.positions.push_back(make_float3(x, heightAt(x, z), z));
            const float dx = 0.9f * std::cos(3 * x) * std::cos(2 * z);
            const float dz = -0.6f * std::sin(3 * x) * std::sin(2 * z);
            mesh.normals.push_back(normalize(make_float3(-dx, 1, -dz)));
        }
    for (int j = 0; j < kGrid; ++j)
        for (int i = 0; i < kGrid; ++i) {
            const int a = j * (kGrid + 1) + i, b = a + 1, c = a + kGrid + 1, d = c + 1;
            mesh.triangles.push_back(make_int3(a, c, b));
            mesh.triangles.push_back(make_int3(b, c, d));
            for (int n = 0; n < 2; ++n)
                mesh.materials.push_back(i < kGrid / 2 ? 0 : 1);
        }
    return mesh;
}

// The height of the mesh above a point.
float meshHeight(const Mesh& mesh, float x, float z) {
    const float fx = (x + 1) / 2 * kGrid, fz = (z + 1) / 2 * kGrid;
    const int i = std::min(kGrid - 1, std::max(0, int(fx))),
              j = std::min(kGrid - 1, std::max(0, int(fz)));
    const auto h = [&](int a, int b) { return mesh.positions[size_t(b * (kGrid + 1) + a)].y; };
    const float u = fx - float(i), v = fz - float(j);
    if (u + v <= 1)
        return h(i, j) + u * (h(i + 1, j) - h(i, j)) + v * (h(i, j + 1) - h(i, j));
    return h(i + 1, j + 1) + (1 - u) * (h(i, j + 1) - h(i + 1, j + 1)) +
           (1 - v) * (h(i + 1, j) - h(i + 1, j + 1));
}

class Viewer {
public:
    explicit Viewer(bool asTriangles) : mesh_(makeMesh()) {
        context_ = Context::create();
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(2);
        context_->setStackSize(4640);
        setUpPrograms();
        setUpBuffers();
        setUpMesh(asTriangles);
        camera_ = make_float3(0.1f, 2.0f, 0.05f);
    }
    ~Viewer() { rtContextDestroy(context_->get()); }
    Viewer(const Viewer&) = delete;

    void moveCamera(float3 to) {
        camera_ = to;
        moved_ = true;
    }
    void frame() {
        if (moved_)
            frame_ = 1;
        moved_ = false;
        context_["eye"]->setFloat(camera_);
        context_["frame"]->setUint(frame_++);
        context_->launch(0, kWidth, kHeight);
    }
    // The accumulated heights are means over places within the pixel.
    void checkPicture(const std::string& what) {
        Buffer accumulated = context_["accum_buffer"]->getBuffer();
        const auto* data = static_cast<const float4*>(accumulated->map());
        const std::vector<float4> pixels(data, data + kWidth * kHeight);
        accumulated->unmap();
        double worst = 0;
        int hits = 0;
        for (unsigned y = 0; y < kHeight; ++y)
            for (unsigned x = 0; x < kWidth; ++x) {
                const float4 pixel = pixels[y * kWidth + x];
                if (pixel.w < 1) // the border
                    continue;
                ++hits;
                double sum = 0;
                for (unsigned f = 1; f < frame_; ++f)
                    sum += expectedHeight(x, y, f);
                worst = std::max(worst, std::fabs(sum / (frame_ - 1) - double(pixel.x)));
            }
        require(worst < 2e-4, what + ": heights differ by " + std::to_string(worst));
        require(hits > int(kWidth * kHeight) / 3, what + ": few pixels show the mesh");
    }
    void checkMaterials() {
        context_->launch(1, kWidth, kHeight);
        const auto* data =
            static_cast<const uchar4*>(context_["output_buffer"]->getBuffer()->map());
        int wrong = 0;
        for (unsigned y = 0; y < kHeight; ++y)
            for (unsigned x = 0; x < kWidth; ++x) {
                const float px = place(x, y, 0).x;
                if (std::fabs(px) > 0.99f || std::fabs(px) < 0.01f ||
                    std::fabs(place(x, y, 0).z) > 0.99f)
                    continue;
                const uchar4 pixel = data[y * kWidth + x];
                wrong += px < 0 ? pixel.x != 200 || pixel.y != 50 : pixel.x != 50 || pixel.y != 200;
            }
        context_["output_buffer"]->getBuffer()->unmap();
        require(wrong == 0, std::to_string(wrong) + " pixels have the other material");
    }
    // The mesh is moved by its vertices; the acceleration is refitted or built.
    void raise(float by) {
        auto* data = static_cast<float3*>(vertices_->map());
        for (size_t i = 0; i < mesh_.positions.size(); ++i) {
            mesh_.positions[i].y += by;
            data[i] = mesh_.positions[i];
        }
        vertices_->unmap();
        acceleration_->markDirty();
        require(acceleration_->isDirty(), "the acceleration is not dirty");
        moved_ = true;
    }
    Acceleration acceleration() const { return acceleration_; }

private:
    void setUpPrograms() {
        const std::string ptx = device_ptx;
        Program camera = context_->createProgramFromPTXString(ptx, "orthographic_camera");
        camera["extent"]->setFloat(1.2f, 1.2f);
        context_->setRayGenerationProgram(0, camera);
        context_->setRayGenerationProgram(
            1, context_->createProgramFromPTXString(ptx, "show_material"));
        context_["extent"]->setFloat(1.0f, 1.0f); // the camera's own hides it
        context_->setMissProgram(0, context_->createProgramFromPTXString(ptx, "miss"));
        context_->setExceptionProgram(0, context_->createProgramFromPTXString(ptx, "exception"));
        context_["miss_height"]->setFloat(-100.0f);
        context_["scene_epsilon"]->setFloat(1e-4f);
    }
    void setUpBuffers() {
        context_["output_buffer"]->set(
            context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_UNSIGNED_BYTE4, kWidth, kHeight));
        context_["accum_buffer"]->set(
            context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT4, kWidth, kHeight));
    }
    template <class T>
    Buffer upload(RTformat format, const std::vector<T>& values) {
        Buffer buffer = context_->createBuffer(RT_BUFFER_INPUT, format, values.size());
        std::memcpy(buffer->map(0, RT_BUFFER_MAP_WRITE_DISCARD), values.data(),
                    values.size() * sizeof(T));
        buffer->unmap();
        return buffer;
    }
    void setUpMesh(bool asTriangles) {
        vertices_ = upload(RT_FORMAT_FLOAT3, mesh_.positions);
        const Buffer normals = upload(RT_FORMAT_FLOAT3, mesh_.normals);
        const Buffer indices = upload(RT_FORMAT_UNSIGNED_INT3, mesh_.triangles);
        const Buffer materials = upload(RT_FORMAT_INT, mesh_.materials);
        const Buffer bytes =
            upload(RT_FORMAT_UNSIGNED_BYTE,
                   std::vector<unsigned char>(mesh_.materials.begin(), mesh_.materials.end()));
        const auto count = unsigned(mesh_.triangles.size());
        GeometryInstance instance = context_->createGeometryInstance();
        if (asTriangles) {
            GeometryTriangles geometry = context_->createGeometryTriangles();
            geometry->setPrimitiveCount(count);
            geometry->setTriangleIndices(indices, RT_FORMAT_UNSIGNED_INT3);
            geometry->setVertices(unsigned(mesh_.positions.size()), vertices_, RT_FORMAT_FLOAT3);
            geometry->setBuildFlags(RTgeometrybuildflags(0));
            geometry->setMaterialCount(2);
            geometry->setMaterialIndices(bytes, 0, 1, RT_FORMAT_UNSIGNED_BYTE);
            geometry->setFlagsPerMaterial(0, RT_GEOMETRY_FLAG_DISABLE_ANYHIT);
            geometry->setFlagsPerMaterial(1, RT_GEOMETRY_FLAG_DISABLE_ANYHIT);
            geometry->setAttributeProgram(
                context_->createProgramFromPTXString(device_ptx, "mesh_attributes"));
            instance->setGeometryTriangles(geometry);
        } else {
            Geometry geometry = context_->createGeometry();
            geometry->setPrimitiveCount(count);
            geometry->setBoundingBoxProgram(
                context_->createProgramFromPTXString(device_ptx, "mesh_bounds"));
            geometry->setIntersectionProgram(
                context_->createProgramFromPTXString(device_ptx, "mesh_intersect"));
            geometry["material_buffer"]->set(materials);
            instance->setGeometry(geometry);
        }
        instance["vertex_buffer"]->setBuffer(vertices_);
        instance["normal_buffer"]->setBuffer(normals);
        instance["index_buffer"]->setBuffer(indices);
        instance->setMaterialCount(2);
        for (unsigned i = 0; i < 2; ++i) {
            Material material = context_->createMaterial();
            material->setClosestHitProgram(
                0, context_->createProgramFromPTXString(device_ptx, "closest_hit"));
            material["Kd"]->setUint(i ? make_uint3(50, 200, 0) : make_uint3(200, 50, 0));
            instance->setMaterial(i, material);
        }
        acceleration_ = context_->createAcceleration("Trbvh");
        acceleration_->setProperty("vertex_buffer_name", "vertex_buffer");
        acceleration_->setProperty("vertex_buffer_stride", "12");
        acceleration_->setProperty("index_buffer_name", "index_buffer");
        acceleration_->setProperty("index_buffer_stride", "12");
        acceleration_->setProperty("chunk_size", "-1");
        acceleration_->setProperty("refit", "1");
        GeometryGroup group = context_->createGeometryGroup();
        group->addChild(instance);
        group->setAcceleration(acceleration_);
        context_["top_object"]->set(group);
        context_["top_shadower"]->set(group);
    }
    // As the device has it.
    float3 place(unsigned x, unsigned y, unsigned frame) const {
        const float extent = frame ? 1.2f : 1.0f;
        const float jx = frame ? float(frame * 7 % 16) / 16.0f : 0.5f;
        const float jy = frame ? float(frame * 11 % 16) / 16.0f : 0.5f;
        return make_float3(((float(x) + jx) / kWidth * 2 - 1) * extent + camera_.x, camera_.y,
                           ((float(y) + jy) / kHeight * 2 - 1) * extent + camera_.z);
    }
    double expectedHeight(unsigned x, unsigned y, unsigned frame) const {
        const float3 p = place(x, y, frame);
        return double(meshHeight(mesh_, p.x, p.z));
    }

    Mesh mesh_;
    Context context_;
    Buffer vertices_;
    Acceleration acceleration_;
    float3 camera_;
    unsigned frame_ = 1;
    bool moved_ = true;
};

void run(bool asTriangles) {
    const std::string kind = asTriangles ? "geometry triangles" : "geometry";
    Viewer viewer(asTriangles);
    for (int i = 0; i < 5; ++i)
        viewer.frame();
    viewer.checkPicture(kind);
    require(!viewer.acceleration()->isDirty(), "the acceleration is dirty after a launch");
    viewer.checkMaterials();
    viewer.moveCamera(make_float3(-0.2f, 3.0f, 0.15f));
    for (int i = 0; i < 3; ++i)
        viewer.frame();
    viewer.checkPicture(kind + ", camera moved");
    viewer.raise(0.25f);
    viewer.frame();
    viewer.checkPicture(kind + ", vertices moved");
    require(viewer.acceleration()->getBuilder() == "Trbvh", "another builder");
    require(viewer.acceleration()->getProperty("index_buffer_name") == "index_buffer",
            "another property");
}

} // namespace

int main() {
    return runProgram([] {
        run(false);
        run(true);
    });
}
