// SPDX-License-Identifier: Apache-2.0
// Tufts of curves, heaps of spheres and boxes on a landscape, in one structure of instances;
// device/mixed_shapes.cu.
#include "programs.h"

#include "device/mixed_shapes.h"
#include "sampling.h"

#include <cmath>

std::string_view bench_second_mixed_shapes_ptx();
std::string_view bench_second_mixed_shapes_round_ptx();

namespace bench {
namespace {

enum Shape : unsigned { kGround, kTuft, kHeap, kBoxes, kShapes };

// A point in a ball.
float3 inBall(unsigned i) {
    const float y = 2 * randomOf(i, 1) - 1, level = std::sqrt(1 - y * y);
    const float2 c = circlePoint(randomOf(i, 2));
    return vec(level * c.x, y, level * c.y) * std::cbrt(randomOf(i, 3));
}

class MixedShapes : public Application {
public:
    MixedShapes(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height) {
        const Mesh ground = makeScene(SceneKind::kTerrain, settings.some(5e5, 400));
        const MeshMemory memory = uploadMesh(scene_, ground);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        handles_[kGround] = scene_.build(inputOf(memory, flags));
        records_[kGround].color = vec(0.45f, 0.5f, 0.35f);
        records_[kGround].mesh = {reinterpret_cast<const float3*>(memory.vertices),
                                  reinterpret_cast<const uint3*>(memory.indices)};
        addTuft(settings.some(20000, 30));
        addHeap(settings.some(2e5, 100));
        addBoxes(settings.some(1e5, 100));
        MixedParams& p = launch_.params;
        p.handle = scene_.buildInstances(place(ground, settings.some(240, 30)));
        p.camera = cameraOf(ground, settings);
        p.sun = normalize(vec(-0.5f, 0.6f, -0.4f));
        p.reach = 3;
        p.occlusionRays = 4;
        image_.allocate(sizeof(float4) * width_ * height_);
        p.image = image_.as<float4>();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CUBIC_BSPLINE);
        o.numAttributeValues = 3;
        const OptixModule rays = programs_.load(bench_second_mixed_shapes_ptx());
        const OptixModule round = programs_.load(bench_second_mixed_shapes_round_ptx());
        const OptixModule curves =
            programs_.builtin(OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE, kCurveFlags);
        const OptixModule spheres = programs_.builtin(OPTIX_PRIMITIVE_TYPE_SPHERE, kFlags);
        const auto raygen = programs_.raygen({rays, "__raygen__mixed"});
        const auto surface = programs_.miss({rays, "__miss__surface"});
        const auto open = programs_.miss({rays, "__miss__open"});
        const OptixProgramGroup hits[kShapes] = {
            programs_.hit({{rays, "__closesthit__mesh"}, {}, {}}),
            programs_.hit({{round, "__closesthit__strand"}, {}, {curves, nullptr}}),
            programs_.hit({{round, "__closesthit__ball"}, {}, {spheres, nullptr}}),
            programs_.hit({{rays, "__closesthit__box"}, {}, {rays, "__intersection__box"}})};
        pipeline_ = programs_.link({raygen, surface, open, hits[0], hits[1], hits[2], hits[3]},
                                   {.trace = 1, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(surface), makeRecord(open)});
        std::vector<SbtRecord<MixedRecord>> records;
        for (unsigned i = 0; i < kShapes; ++i)
            records.push_back(makeRecord(hits[i], records_[i]));
        table_.setHits(records);
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    // Those of buildAccel().
    static constexpr unsigned kFlags =
        OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
    static constexpr unsigned kCurveFlags = kFlags | OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;

    // Blades of grass of seven control points.
    void addTuft(unsigned blades) {
        constexpr unsigned kPoints = 7, kSegments = kPoints - 3;
        std::vector<float4> points;
        std::vector<unsigned> firsts;
        for (unsigned i = 0; i < blades; ++i) {
            const float2 c = circlePoint(randomOf(i, 0)), lean = circlePoint(randomOf(i, 1));
            const float r = std::sqrt(randomOf(i, 2)), height = 0.8f + 0.7f * randomOf(i, 3);
            for (unsigned k = 0; k < kPoints; ++k) {
                const float along = float(k) / (kPoints - 1), bend = 0.5f * along * along;
                points.push_back(make_float4(r * c.x + bend * lean.x, height * along - 0.2f,
                                             r * c.y + bend * lean.y, 0.008f * (1.1f - along)));
            }
            for (unsigned k = 0; k < kSegments; ++k)
                firsts.push_back(i * kPoints + k);
        }
        const auto vertices = reinterpret_cast<CUdeviceptr>(scene_.upload(points));
        const CUdeviceptr widths = vertices + 3 * sizeof(float);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
        OptixBuildInputCurveArray& c = input.curveArray;
        c.curveType = OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE;
        c.numPrimitives = unsigned(firsts.size());
        c.vertexBuffers = &vertices;
        c.numVertices = unsigned(points.size());
        c.vertexStrideInBytes = sizeof(float4);
        c.widthBuffers = &widths;
        c.widthStrideInBytes = sizeof(float4);
        c.indexBuffer = reinterpret_cast<CUdeviceptr>(scene_.upload(firsts));
        c.indexStrideInBytes = sizeof(unsigned);
        c.flag = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        handles_[kTuft] = scene_.build(input, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
        records_[kTuft].color = vec(0.3f, 0.6f, 0.2f);
    }
    void addHeap(unsigned count) {
        std::vector<float4> balls;
        const float size = 0.5f / std::cbrt(float(count));
        for (unsigned i = 0; i < count; ++i) {
            const float3 p = inBall(i);
            balls.push_back(make_float4(p.x, p.y, p.z, size * (0.5f + randomOf(i, 4))));
        }
        const float4* const memory = scene_.upload(balls);
        const auto centers = reinterpret_cast<CUdeviceptr>(memory),
                   radii = centers + 3 * sizeof(float);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_SPHERES;
        OptixBuildInputSphereArray& s = input.sphereArray;
        s.vertexBuffers = &centers;
        s.vertexStrideInBytes = sizeof(float4);
        s.numVertices = count;
        s.radiusBuffers = &radii;
        s.radiusStrideInBytes = sizeof(float4);
        s.flags = &flags;
        s.numSbtRecords = 1;
        handles_[kHeap] = scene_.build(input);
        records_[kHeap].color = vec(0.8f, 0.5f, 0.4f);
        records_[kHeap].balls = memory;
    }
    void addBoxes(unsigned count) {
        std::vector<MixedBox> boxes;
        std::vector<OptixAabb> bounds;
        const float size = 0.5f / std::cbrt(float(count));
        for (unsigned i = 0; i < count; ++i) {
            const float3 c = inBall(i + 1000003);
            const float3 h =
                vec(0.3f + randomOf(i, 5), 0.3f + randomOf(i, 6), 0.3f + randomOf(i, 7)) * size;
            boxes.push_back({c, h});
            bounds.push_back({c.x - h.x, c.y - h.y, c.z - h.z, c.x + h.x, c.y + h.y, c.z + h.z});
        }
        handles_[kBoxes] = scene_.buildBoxes(bounds, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
        records_[kBoxes].color = vec(0.5f, 0.55f, 0.8f);
        records_[kBoxes].boxes = scene_.upload(boxes);
    }
    std::vector<OptixInstance> place(const Mesh& ground, unsigned count) const {
        std::vector<OptixInstance> instances = {
            instanceOf(handles_[kGround], kIdentity, 0, kGround)};
        for (unsigned i = 0; i < count; ++i) {
            const unsigned shape = 1 + i % (kShapes - 1);
            const auto on = size_t(randomOf(i, 1) * float(ground.numTriangles() - 1));
            const float3 at = vertexOf(ground, on, 0);
            const float s = (shape == kTuft ? 3.0f : 1.8f) * (0.6f + 0.8f * randomOf(i, 2));
            const float y = at.y + (shape == kTuft ? 0 : 0.4f * s);
            const float2 c = circlePoint(randomOf(i, 3));
            const float m[12] = {s * c.x, 0, s * c.y, at.x, 0, s, 0, y, -s * c.y, 0, s * c.x, at.z};
            instances.push_back(instanceOf(handles_[shape], m, i, shape));
        }
        return instances;
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<MixedParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    unsigned width_, height_;
    OptixTraversableHandle handles_[kShapes] = {};
    MixedRecord records_[kShapes] = {};
    DeviceBuffer image_;
};

} // namespace

JobKind mixedShapesJob() {
    return secondJob<MixedShapes>(
        "mixed_shapes", "triangles, curves, spheres and boxes under one structure of instances",
        0.002, 0.02);
}

} // namespace bench
