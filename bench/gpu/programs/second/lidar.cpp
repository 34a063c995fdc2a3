// SPDX-License-Identifier: Apache-2.0
// A scanner among moving objects, whose structure of instances is updated in each frame and built
// again in every fourth; device/lidar.cu.
#include "programs.h"

#include "device/lidar.h"

#include <cmath>

std::string_view bench_second_lidar_ptx();

namespace bench {
namespace {

constexpr unsigned kShapes = 4, kFrames = 4, kMapSide = 512;
constexpr unsigned kGround = 0x10000; // number of the ground as an object

class Lidar : public Application {
public:
    Lidar(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context),
          world_(context, OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_PREFER_FAST_BUILD) {
        const Mesh ground = makeScene(SceneKind::kTerrain, settings.some(8e5, 200));
        children_.push_back(add(ground));
        for (unsigned i = 0; i + 2 < kShapes; ++i)
            children_.push_back(add(makeRock(settings.some(5e4 * (i + 1), 100))));
        Mesh crown = makeLeaves(settings.some(4e4, 100));
        for (float& x : crown.vertices)
            x *= 0.03f;
        children_.push_back(add(crown));
        numObjects_ = settings.some(3000, 40);
        const std::vector<float> first = scatter(numObjects_);
        instances_.push_back(instanceOf(children_[0], kIdentity, 0, 0));
        for (unsigned i = 0; i < numObjects_; ++i)
            instances_.push_back(instanceOf(children_[1 + i % (kShapes - 1)],
                                            &first[12 * size_t(i)], i, 1 + i % (kShapes - 1)));
        instanceMemory_.allocate(instances_.size() * sizeof(OptixInstance));
        setLaunch(settings);
    }
    void compile() override {
        programs_.options.traversableGraphFlags =
            OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        programs_.options.numPayloadValues = 5;
        const OptixModule module = programs_.load(bench_second_lidar_ptx());
        const auto scan = programs_.raygen({module, "__raygen__scan"});
        const auto map = programs_.raygen({module, "__raygen__map"});
        const auto miss = programs_.miss({module, "__miss__end"});
        const auto hit = programs_.hit({{module, "__closesthit__echo"}, {}, {}});
        pipeline_ = programs_.link({scan, map, miss, hit}, {1, 2, 0, 0});
        std::vector<SbtRecord<LidarMaterial>> hits = {
            makeRecord(hit, LidarMaterial{0.3f, 0, kGround}),
            makeRecord(hit, LidarMaterial{0.7f, 0, 0}),
            makeRecord(hit, LidarMaterial{0.5f, 0.3f, 0}), // nets
            makeRecord(hit, LidarMaterial{0.6f, 0.5f, 0}), // leaves
        };
        scanTable_.setRaygen(makeRecord(scan));
        mapTable_.setRaygen(makeRecord(map));
        for (Table* table : {&scanTable_, &mapTable_}) {
            table->setMisses(std::vector{makeRecord(miss, LidarMiss{1.0f})});
            table->setHits(hits);
        }
    }
    double compileTime() const override { return programs_.compileTime(); }

    void renderFrame() override {
        LidarParams& p = launch_.params;
        move(frame_ % kFrames);
        CUDA_CHECK(cudaMemcpyAsync(instanceMemory_.data(), instances_.data(),
                                   instanceMemory_.size(), cudaMemcpyHostToDevice, nullptr));
        world_.build(inputOfInstances(instanceMemory_.address(), instances_.size()),
                     frame_ % kFrames ? OPTIX_BUILD_OPERATION_UPDATE : OPTIX_BUILD_OPERATION_BUILD);
        p.world = world_.handle();
        p.angle = 0.25f * float(frame_ % kFrames);
        CUDA_CHECK(cudaMemsetAsync(p.numEchoes, 0, sizeof(unsigned), nullptr));
        CUDA_CHECK(cudaMemsetAsync(p.map, 0, sizeof(float4) * kMapSide * kMapSide, nullptr));
        launch_.run(pipeline_, scanTable_, p.numColumns, p.numChannels);
        launch_.run(pipeline_, mapTable_, p.maxEchoes);
        ++frame_;
    }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    OptixTraversableHandle add(const Mesh& mesh) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        return scene_.build(inputOf(uploadMesh(scene_, mesh), flags),
                            OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    }
    void move(unsigned step) {
        for (size_t i = 1; i < instances_.size(); ++i) {
            const auto n = unsigned(i);
            const float speed = 0.4f * float(step);
            instances_[i].transform[3] += step ? speed * (randomOf(n, 1) - 0.5f) : 0;
            instances_[i].transform[11] += step ? speed * (randomOf(n, 2) - 0.5f) : 0;
        }
    }
    void setLaunch(const JobSettings& settings) {
        LidarParams& p = launch_.params;
        p.numChannels = settings.height < 512 ? settings.height : 512;
        p.numColumns = settings.some(4096, settings.width);
        const size_t beams = size_t(p.numChannels) * p.numColumns;
        p.maxEchoes = unsigned(3 * beams);
        p.echoes = scene_.allocate<Echo>(p.maxEchoes);
        p.numEchoes = scene_.allocate<unsigned>(1);
        image_.allocate(sizeof(float4) * (beams + kMapSide * kMapSide));
        p.beams = image_.as<float4>();
        p.map = p.beams + beams;
        p.mapSide = kMapSide;
        p.mapReach = 60;
        p.scanner = vec(2, 19, 3);
    }

    Scene scene_;
    Programs programs_;
    Table scanTable_, mapTable_;
    Launch<LidarParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    LiveStructure world_;
    std::vector<OptixTraversableHandle> children_;
    std::vector<OptixInstance> instances_;
    DeviceBuffer instanceMemory_, image_;
    unsigned numObjects_ = 0, frame_ = 0;
};

} // namespace

JobKind lidarJob() {
    return secondJob<Lidar>(
        "lidar", "a scanner among moving objects, four echoes a pulse, one list of echoes", 0.002,
        0.02);
}

} // namespace bench
