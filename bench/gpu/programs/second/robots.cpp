// SPDX-License-Identifier: Apache-2.0
// A crowd of robots: instances of robots, which are instances of parts under transforms. Each frame
// gives the robots' parts new poses and updates all structures of instances; device/robots.cu.
#include "programs.h"

#include "device/robots.h"
#include "sampling.h"

#include <cmath>
#include <cstring>

std::string_view bench_second_robots_ptx();

namespace bench {
namespace {

constexpr unsigned kParts = 10, kUpdate = OPTIX_BUILD_FLAG_ALLOW_UPDATE;

struct Matrix {
    float m[12];
};
// A turn around the x axis through the origin, then a shift.
Matrix turned(float turns, float3 at, float scale = 1) {
    const float2 c = circlePoint(turns - std::floor(turns));
    return {
        {scale, 0, 0, at.x, 0, scale * c.x, -scale * c.y, at.y, 0, scale * c.y, scale * c.x, at.z}};
}

// The shape of a part: a stretched rock.
struct PartShape {
    float3 stretch;
    float3 color;
    bool isPainted;
};
constexpr unsigned kShapes = 4; // body, limb, head, rotor

class Robots : public Application {
public:
    Robots(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height),
          world_(context, kUpdate | OPTIX_BUILD_FLAG_PREFER_FAST_TRACE) {
        makeParts(settings.some(6000, 100));
        const unsigned poses = settings.some(48, 6);
        for (unsigned i = 0; i < poses; ++i)
            robots_.push_back(std::make_unique<LiveStructure>(context, kUpdate));
        partInstances_.resize(size_t(poses) * kParts);
        count_ = settings.some(2500, 30);
        topInstances_.resize(count_ + 1);
        partMemory_.allocate(partInstances_.size() * sizeof(OptixInstance));
        topMemory_.allocate(topInstances_.size() * sizeof(OptixInstance));
        addGround(settings.some(2e5, 100));
        RobotParams& p = launch_.params;
        p.camera =
            makeCamera(vec(-46, 36, -52), vec(0, 8, -8), vec(0, 1, 0), 46, settings.aspect());
        p.sun = normalize(vec(-0.5f, 0.8f, -0.3f));
        p.samples = 2;
        image_.allocate(sizeof(float4) * width_ * height_);
        p.image = image_.as<float4>();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.usesMotionBlur = true;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
        o.numPayloadValues = 7;
        o.pipelineLaunchParamsVariableName = "launch";
        const OptixModule module = programs_.load(bench_second_robots_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__camera"});
        const auto miss = programs_.miss({module, "__miss__none"});
        const auto hit = programs_.hit({{module, "__closesthit__part"}, {}, {}});
        pipeline_ = programs_.link({raygen, miss, hit}, {.trace = 1, .graph = 4});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        std::vector<SbtRecord<PartRecord>> records;
        for (const PartRecord& r : records_)
            records.push_back(makeRecord(hit, r));
        table_.setHits(records);
    }
    double compileTime() const override { return programs_.compileTime(); }

    void renderFrame() override {
        const auto operation =
            frame_ == 0 ? OPTIX_BUILD_OPERATION_BUILD : OPTIX_BUILD_OPERATION_UPDATE;
        for (unsigned i = 0; i < robots_.size(); ++i)
            pose(i, 0.02f * float(frame_));
        CUDA_CHECK(cudaMemcpyAsync(partMemory_.data(), partInstances_.data(), partMemory_.size(),
                                   cudaMemcpyHostToDevice, nullptr));
        for (unsigned i = 0; i < robots_.size(); ++i)
            robots_[i]->build(
                inputOfInstances(partMemory_.address() + i * kParts * sizeof(OptixInstance),
                                 kParts),
                operation);
        place(0.1f * float(frame_));
        CUDA_CHECK(cudaMemcpyAsync(topMemory_.data(), topInstances_.data(), topMemory_.size(),
                                   cudaMemcpyHostToDevice, nullptr));
        world_.build(inputOfInstances(topMemory_.address(), topInstances_.size()), operation);
        launch_.params.world = world_.handle();
        launch_.run(pipeline_, table_, width_, height_);
        ++frame_;
    }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    // Structures of the shapes, each under a transform that stretches it; that of the rotor turns
    // during the exposure.
    void makeParts(unsigned triangles) {
        const PartShape shapes[kShapes] = {{vec(0.5f, 0.7f, 0.35f), vec(0.9f), true},
                                           {vec(0.15f, 0.5f, 0.15f), vec(0.4f, 0.4f, 0.45f), false},
                                           {vec(0.3f, 0.3f, 0.3f), vec(0.8f, 0.8f, 0.7f), true},
                                           {vec(0.6f, 0.04f, 0.12f), vec(0.7f, 0.2f, 0.1f), false}};
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        for (unsigned i = 0; i < kShapes; ++i) {
            const Mesh rock = makeRock(triangles / (i == 0 ? 1 : 4));
            const MeshMemory memory = uploadMesh(scene_, rock);
            addRecord(memory, shapes[i].color, shapes[i].isPainted);
            const OptixTraversableHandle child = scene_.build(inputOf(memory, flags));
            children_[i] = i == 3 ? makeRotor(child, shapes[i].stretch)
                                  : makeStretched(child, shapes[i].stretch);
        }
    }
    void addRecord(const MeshMemory& m, float3 color, bool isPainted) {
        records_.push_back({reinterpret_cast<const float3*>(m.vertices),
                            reinterpret_cast<const uint3*>(m.indices), color, isPainted});
    }
    OptixTraversableHandle makeStretched(OptixTraversableHandle child, float3 s) {
        OptixStaticTransform t = {};
        t.child = child;
        const float forth[12] = {s.x, 0, 0, 0, 0, s.y, 0, 0, 0, 0, s.z, 0};
        const float back[12] = {1 / s.x, 0, 0, 0, 0, 1 / s.y, 0, 0, 0, 0, 1 / s.z, 0};
        std::memcpy(t.transform, forth, sizeof(forth));
        std::memcpy(t.invTransform, back, sizeof(back));
        return convert(&t, sizeof(t), OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM);
    }
    OptixTraversableHandle makeRotor(OptixTraversableHandle child, float3 s) {
        OptixMatrixMotionTransform t = {};
        t.child = child;
        t.motionOptions = {2, OPTIX_MOTION_FLAG_NONE, 0, 1};
        for (unsigned key = 0; key < 2; ++key) {
            const float2 c = circlePoint(0.06f * float(key));
            const float m[12] = {s.x * c.x, 0, s.z * c.y,  0, 0,         s.y,
                                 0,         0, -s.x * c.y, 0, s.z * c.x, 0};
            std::memcpy(t.transform[key], m, sizeof(m));
        }
        return convert(&t, sizeof(t), OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM);
    }
    OptixTraversableHandle convert(const void* transform, size_t size, OptixTraversableType type) {
        const auto* const bytes = static_cast<const unsigned char*>(transform);
        const std::vector<unsigned char> copy(bytes, bytes + size);
        OptixTraversableHandle handle = 0;
        OPTIX_CHECK(optixConvertPointerToTraversableHandle(
            scene_.context(), reinterpret_cast<CUdeviceptr>(scene_.upload(copy)), type, &handle));
        return handle;
    }
    void addGround(unsigned triangles) {
        Mesh mesh = makeScene(SceneKind::kTerrain, triangles);
        for (size_t i = 1; i < mesh.vertices.size(); i += 3)
            mesh.vertices[i] *= 0.3f;
        const MeshMemory memory = uploadMesh(scene_, mesh);
        addRecord(memory, vec(0.5f, 0.45f, 0.35f), false);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        ground_ = scene_.build(inputOf(memory, flags));
    }

    // Body, head, rotor, two arms, two legs, and lower parts of three limbs.
    void pose(unsigned robot, float time) {
        OptixInstance* const part = &partInstances_[size_t(robot) * kParts];
        const auto set = [&](unsigned n, unsigned shape, const Matrix& matrix) {
            part[n] = instanceOf(children_[shape], matrix.m, n, shape);
        };
        const float swing = 0.12f * std::sin(6.28f * (time + float(robot) / 7));
        set(0, 0, turned(0.02f * swing, vec(0, 1.7f, 0)));
        set(1, 2, turned(swing * 0.3f, vec(0, 2.7f, 0)));
        set(2, 3, turned(0.02f, vec(0, 3.1f, 0)));
        const float3 hips[4] = {vec(-0.6f, 2, 0), vec(0.6f, 2, 0), vec(-0.3f, 0.9f, 0),
                                vec(0.3f, 0.9f, 0)};
        for (unsigned k = 0; k < 4; ++k)
            set(3 + k, 1, turned(k % 2 ? swing : -swing, hips[k] - vec(0, 0.3f, 0)));
        for (unsigned k = 0; k < 3; ++k)
            set(7 + k, 1, turned(k % 2 ? -swing : swing, hips[k] - vec(0, 0.9f, 0.1f), 0.8f));
    }
    // Robots in a crowd that walks.
    void place(float shift) {
        topInstances_[0] = instanceOf(ground_, kIdentity, 0, kShapes);
        const auto across = unsigned(std::ceil(std::sqrt(float(count_))));
        const float step = 90.0f / float(across);
        for (unsigned i = 0; i < count_; ++i) {
            const float x = (float(i % across) + 0.7f * randomOf(i, 1)) * step - 45;
            const float z = (float(i / across) + 0.7f * randomOf(i, 2)) * step - 45 + shift;
            const float2 c = circlePoint(randomOf(i, 3));
            const float s = 0.8f + 0.6f * randomOf(i, 4), y = 3 + randomOf(i, 5);
            const float m[12] = {s * c.x, 0, s * c.y, x, 0, s, 0, y, -s * c.y, 0, s * c.x, z};
            topInstances_[i + 1] = instanceOf(robots_[i % robots_.size()]->handle(), m, i, 0);
        }
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<RobotParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    unsigned width_, height_;
    std::vector<PartRecord> records_;
    OptixTraversableHandle children_[kShapes] = {}, ground_ = 0;
    std::vector<std::unique_ptr<LiveStructure>> robots_;
    LiveStructure world_;
    std::vector<OptixInstance> partInstances_, topInstances_;
    DeviceBuffer partMemory_, topMemory_, image_;
    unsigned count_ = 0, frame_ = 0;
};

} // namespace

JobKind robotsJob() {
    return secondJob<Robots>("robots",
                             "instances of instances under transforms, all updated in each frame",
                             0.002, 0.02);
}

} // namespace bench
