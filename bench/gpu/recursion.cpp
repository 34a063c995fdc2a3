// SPDX-License-Identifier: Apache-2.0
// Frames of a recursive ray tracer: a terrain of a million triangles, some patches mirrors or
// glass; rays four deep, four samples a pixel.
#include "recursion.h"
#include "benches.h"
#include "camera.h"
#include "optix_setup.h"
#include "sampling.h"
#include "world.h"

#include <algorithm>
#include <cmath>

// The PTX of recursion.cu, built into this program.
std::string_view gpu_bench_recursion_ptx();

namespace bench {
namespace {

constexpr unsigned kDepth = 4, kSamples = 4;
enum Material : uint8_t { kMatt, kMirror, kGlass, kMaterials };

// The material of each triangle, equal for 64 consecutive triangles.
std::vector<uint8_t> materialsOf(const Mesh& mesh) {
    std::vector<uint8_t> materials(mesh.numTriangles());
    for (size_t i = 0; i < materials.size(); ++i) {
        const unsigned kind = hashPcg(unsigned(i / 64)) % 8;
        materials[i] = kind == 0 ? kMirror : kind == 1 ? kGlass : kMatt;
    }
    return materials;
}

class Frames {
public:
    Frames(OptixDeviceContext context, const Settings& settings)
        : settings_(settings),
          program_(context, gpu_bench_recursion_ptx(), 5, 2, OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) {
        const Mesh mesh =
            makeScene(SceneKind::kTerrain, uint32_t(std::max(16.0, 1e6 * settings.scale)));
        build(context, mesh);
        makeTable();
        const size_t pixels = size_t(settings.width) * settings.height;
        image_.allocate(pixels * sizeof(float4));
        const Camera camera =
            makeCamera(vec(mesh.eye[0], mesh.eye[1], mesh.eye[2]),
                       vec(mesh.target[0], mesh.target[1], mesh.target[2]), vec(0, 1, 0),
                       mesh.fovDegrees, float(settings.width) / float(settings.height));
        const RecursionParams params = {image_.as<float4>(),
                                        vertices_.as<float3>(),
                                        triangles_.as<uint3>(),
                                        accel_.handle,
                                        camera.eye,
                                        camera.forward,
                                        camera.right,
                                        camera.up,
                                        normalize(vec(0.55f, 0.5f, 0.6f)),
                                        1e-4f * mesh.aoRadius,
                                        kSamples,
                                        kDepth};
        params_.upload(&params, sizeof(params));
    }

    double milliseconds() {
        return fastest(int(settings_.repeats), [&] {
            OPTIX_CHECK(optixLaunch(pipeline_, nullptr, params_.address(), params_.size(), &table_,
                                    settings_.width, settings_.height, 1));
        });
    }
    std::vector<float> image() const { return image_.download<float>(); }

private:
    void build(OptixDeviceContext context, const Mesh& mesh) {
        vertices_.upload(mesh.vertices);
        triangles_.upload(mesh.indices);
        DeviceBuffer materials;
        materials.upload(materialsOf(mesh));
        const unsigned flags[kMaterials] = {};
        const CUdeviceptr address = vertices_.address();
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        OptixBuildInputTriangleArray& t = input.triangleArray;
        t.vertexBuffers = &address;
        t.numVertices = mesh.numVertices();
        t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        t.indexBuffer = triangles_.address();
        t.numIndexTriplets = mesh.numTriangles();
        t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
        t.flags = flags;
        t.numSbtRecords = kMaterials;
        t.sbtIndexOffsetBuffer = materials.address();
        t.sbtIndexOffsetSizeInBytes = sizeof(uint8_t);
        accel_ = buildAccel(context, input);
    }

    void makeTable() {
        const SbtRecord<NoData> records[] = {
            makeRecord(program_.addRaygen("__raygen__camera")),
            makeRecord(program_.addMiss("__miss__sky")),
            makeRecord(program_.addMiss("__miss__sun")),
            makeRecord(program_.addHitgroup("__closesthit__matt", nullptr, nullptr)),
            makeRecord(program_.addHitgroup("__closesthit__mirror", nullptr, nullptr)),
            makeRecord(program_.addHitgroup("__closesthit__glass", nullptr, nullptr))};
        pipeline_ = program_.link(kDepth + 1); // and a ray to the sun
        records_.upload(records, sizeof(records));
        constexpr unsigned kStride = sizeof(records[0]);
        table_.raygenRecord = records_.address();
        table_.missRecordBase = records_.address() + kStride;
        table_.missRecordStrideInBytes = kStride;
        table_.missRecordCount = 2;
        table_.hitgroupRecordBase = records_.address() + 3 * kStride;
        table_.hitgroupRecordStrideInBytes = kStride;
        table_.hitgroupRecordCount = kMaterials;
    }

    const Settings& settings_;
    Program program_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer vertices_, triangles_, records_, image_, params_;
    OptixShaderBindingTable table_ = {};
    Accel accel_;
};

} // namespace

void benchRecursion(OptixDeviceContext context, const Settings& settings,
                    Measurements& measurements) {
    Frames frames(context, settings);
    measurements.add("recursion 1 M", "frame of 4 samples", frames.milliseconds(), "ms/frame");
    comparePictures(settings, "recursion", frames.image(), measurements, "recursion 1 M");
}

} // namespace bench
