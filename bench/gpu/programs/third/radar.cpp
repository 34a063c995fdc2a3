// SPDX-License-Identifier: Apache-2.0
// A radar over a landscape with vehicles: a histogram of ranges and Doppler shifts;
// device/radar.cu.
#include "programs.h"

#include "device/radar.h"

std::string_view bench_third_radar_ptx();

namespace bench {
namespace {

class Radar : public Renderer {
public:
    Radar(OptixDeviceContext context, const JobSettings& settings) : Renderer(context, settings) {
        addObjects(settings);
        RadarParams& p = launch_.params;
        p.world = scene_.buildInstances(instances_);
        p.antenna = vec(-46, 26, -46);
        p.axis = normalize(vec(1, -0.35f, 1));
        p.velocity = vec(18, 0, 6); // an aircraft
        p.beam = 0.45f;
        p.maxBounces = 4;
        p.ranges = std::max(16u, std::min(512u, width_));
        p.shifts = std::max(16u, std::min(256u, height_));
        p.maxRange = 140;
        p.maxShift = 60;
        p.rays = 8 * (width_ / 2) * (height_ / 2);
        p.cells = scene_.allocate<unsigned long long>(size_t(p.ranges) * p.shifts);
        p.image = allocatePicture(p.ranges, p.shifts);
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 8;
        o.pipelineLaunchParamsVariableName = "launchParams";
        const OptixModule module = programs_.load(bench_third_radar_ptx());
        const auto transmit = programs_.raygen({module, "__raygen__transmit"});
        const auto develop = programs_.raygen({module, "__raygen__develop"});
        const auto miss = programs_.miss({module, "__miss__nothing"});
        const auto hit = programs_.hit({{module, "__closesthit__reflect"}, {}, {}});
        pipeline_ = programs_.link({transmit, develop, miss, hit}, {.trace = 1, .graph = 2});
        table_.setRaygen(makeRecord(transmit));
        developTable_.setRaygen(makeRecord(develop));
        std::vector<SbtRecord<RadarRecord>> records;
        for (const RadarRecord& r : records_)
            records.push_back(makeRecord(hit, r));
        for (Table* table : {&table_, &developTable_}) {
            table->setMisses(std::vector{makeRecord(miss)});
            table->setHits(records);
        }
    }
    // Eight chirps, then the picture.
    void renderFrame() override {
        RadarParams& p = launch_.params;
        CUDA_CHECK(
            cudaMemsetAsync(p.cells, 0, sizeof(unsigned long long) * p.ranges * p.shifts, nullptr));
        for (p.chirp = 0; p.chirp < 8; ++p.chirp)
            launch_.run(pipeline_, table_, width_ / 2, height_ / 2);
        launch_.run(pipeline_, developTable_, p.ranges, p.shifts);
    }

private:
    // A record with tables of a material. `roughness`: 0 mirror to 1 matt.
    void addRecord(const MeshMemory& memory, float roughness, float3 velocity) {
        RadarRecord r = {};
        r.mesh = viewOf(memory);
        r.velocity = velocity;
        r.roughness = roughness;
        for (unsigned i = 0; i < kAngles; ++i) {
            const float cosine = (float(i) + 0.5f) / kAngles;
            r.horizontal[i] = 0.3f + 0.6f * (1 - roughness) + 0.1f * (1 - cosine);
            r.vertical[i] = std::fabs(cosine - 0.25f) * (1.2f - 0.6f * roughness);
        }
        records_.push_back(r);
    }
    void addObjects(const JobSettings& settings) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const MeshMemory ground =
            uploadMesh(scene_, makeScene(SceneKind::kTerrain, settings.some(1e6, 400)));
        const MeshMemory rock = uploadMesh(scene_, makeRock(settings.some(2000, 60)));
        const MeshMemory box =
            uploadMesh(scene_, makeBox(vec(-1, -0.6f, -0.5f), vec(1, 0.6f, 0.5f)));
        const OptixTraversableHandle shapes[] = {scene_.build(inputOf(rock, flags)),
                                                 scene_.build(inputOf(box, flags))};
        instances_.push_back(instanceOf(scene_.build(inputOf(ground, flags)), kIdentity, 0, 0));
        addRecord(ground, 0.95f, vec(0));
        // Columns of vehicles: a record for each column, which moves at one speed.
        const unsigned columns = settings.some(24, 4), each = settings.some(60, 8);
        for (unsigned c = 0; c < columns; ++c) {
            const float turns = randomOf(c, 0), speed = 60 * randomOf(c, 1) - 30;
            const float2 d = circlePoint(turns);
            addRecord(c % 3 ? box : rock, c % 3 ? 0.1f : 0.6f, vec(speed * d.x, 0, -speed * d.y));
            const float3 first =
                vec(70 * randomOf(c, 2) - 35, 12 + 6 * randomOf(c, 3), 70 * randomOf(c, 4) - 35);
            for (unsigned i = 0; i < each; ++i) {
                const float along = 1.3f * (float(i) - 0.5f * float(each));
                const float3 at = first + vec(d.x, 0.02f, -d.y) * along;
                instances_.push_back(
                    instanceOf(shapes[c % 3 ? 1 : 0], placed(at, 0.5f, turns).matrix, i, c + 1));
            }
        }
    }

    Table developTable_;
    Launch<RadarParams> launch_;
    std::vector<OptixInstance> instances_;
    std::vector<RadarRecord> records_;
};

} // namespace

JobKind radarJob() {
    return thirdJob<Radar>(
        "radar", "ranges and Doppler shifts of paths with four bounces, summed by atomics", 0.005,
        0.05);
}

} // namespace bench
